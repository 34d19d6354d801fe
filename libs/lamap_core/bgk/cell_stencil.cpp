#include <lamap_core/bgk/cell_stencil.h>

#include <algorithm>
#include <cmath>

namespace lamap
{
namespace
{
constexpr int kEdge = kScanBlockEdge;

double offsetsWithin(double support)
{
  const double edge = 2 * std::ceil(support) + 1;
  return edge * edge * edge;
}

/// Bits of the rows of cells in and around a block, up to `reach` cells beyond it on every side.
class PaddedRows
{
 public:
  PaddedRows(const MaskNeighbourhood& neighbourhood, int reach) : reach_(reach), edge_(kEdge + 2 * reach)
  {
    for (int z = -reach; z < kEdge + reach; ++z) addLayer(neighbourhood, z);
  }

  [[nodiscard]] bool anyInLayer(int z) const { return layerBits_[static_cast<size_t>(z + reach_)] != 0; }
  /// Bits of the cells −reach … 7 + reach of a row, lowest first.
  [[nodiscard]] uint32_t at(int y, int z) const { return rows_[index(y, z)]; }

 private:
  void addLayer(const MaskNeighbourhood& neighbourhood, int z)
  {
    const int dz = z < 0 ? -1 : z >= kEdge;
    std::array<std::array<uint64_t, 3>, 3> words;  // of the nine masks around, by dy and dx
    uint64_t any = 0;
    for (int dy = -1; dy <= 1; ++dy)
    {
      for (int dx = -1; dx <= 1; ++dx)
      {
        const CellMask* mask = neighbourhood.at(dx, dy, dz);
        const uint64_t word = mask ? (*mask)[static_cast<size_t>(z & (kEdge - 1))] : 0;
        words[static_cast<size_t>(dy + 1)][static_cast<size_t>(dx + 1)] = word;
        any |= word;
      }
    }
    if (any == 0) return;  // the rows of such a layer are never read
    for (int y = -reach_; y < kEdge + reach_; ++y)
    {
      const auto& [left, middle, right] = words[static_cast<size_t>(y < 0 ? 0 : y < kEdge ? 1 : 2)];
      const uint32_t row = rowBits(left, middle, right, y & (kEdge - 1));
      rows_[index(y, z)] = row;
      layerBits_[static_cast<size_t>(z + reach_)] |= row;
    }
  }
  [[nodiscard]] size_t index(int y, int z) const
  {
    return static_cast<size_t>((z + reach_) * edge_ + y + reach_);
  }
  [[nodiscard]] uint32_t rowBits(uint64_t left, uint64_t middle, uint64_t right, int y) const
  {
    const int shift = y * kEdge;
    const auto byte = [shift](uint64_t word) { return static_cast<uint32_t>(word >> shift & 0xFF); };
    return byte(left) >> (kEdge - reach_) | byte(middle) << reach_ |
           (byte(right) & ((1u << reach_) - 1)) << (reach_ + kEdge);
  }

  static constexpr size_t kMaxEdge = 3 * kEdge;
  int reach_;
  int edge_;
  std::array<uint32_t, kMaxEdge> layerBits_{};  ///< all rows of a layer together
  std::array<uint32_t, kMaxEdge * kMaxEdge> rows_;
};

}  // namespace

CellStencil::CellStencil(const Kernel& kernel, double factor, bool planar,
                         const std::optional<WeightScale>& scale)
    : scale_(scale.value_or(WeightScale(kernel.scale() * factor, offsetsWithin(kernel.support()))))
{
  const double squaredSupport = kernel.support() * kernel.support();
  while (static_cast<double>(reach_ + 1) < kernel.support()) ++reach_;
  reachZ_ = planar ? 0 : reach_;
  for (int dz = -reachZ_; dz <= reachZ_; ++dz)
  {
    for (int dy = -reach_; dy <= reach_; ++dy)
    {
      int extent = -1;
      while (extent < reach_ && (extent + 1) * (extent + 1) + dy * dy + dz * dz < squaredSupport) ++extent;
      if (extent >= 0) rows_.push_back({dy, dz, extent});
    }
  }
  for (int squared = 0; squared < squaredSupport; ++squared)
    weights_.push_back(scale_.quantized(factor * kernel.atSquaredDistance(squared)));
  classSizes_.assign(weights_.size(), 0);
  for (const Row& row : rows_)
  {
    for (int dx = -row.extent; dx <= row.extent; ++dx)
      ++classSizes_[static_cast<size_t>(dx * dx + row.dy * row.dy + row.dz * row.dz)];
  }
  for (size_t squared = 0; squared < weights_.size(); ++squared)
  {
    fullLanes_.push_back(classSizes_[squared] * 0x0101010101010101u);
    fullSum_ += classSizes_[squared] * weights_[squared];
  }
  countable_ = reach_ <= kEdge && *std::max_element(classSizes_.begin(), classSizes_.end()) <= 255;
}

int64_t CellStencil::sumBesidePlane() const
{
  int64_t sum = 0;
  for (const Row& row : rows_)
    for (int dx = 1; dx <= row.extent; ++dx) sum += weight(dx, row.dy, row.dz);
  return sum;
}

Layers CellStencil::addUp(MaskNeighbourhood& neighbourhood, BlockSums& sums) const
{
  return countable_ ? addByCounting(neighbourhood, sums) : addByCell(neighbourhood, sums);
}

/** Counts the marked cells at each squared distance from each cell of the block, for a row of 8 cells in the
 * bytes of a word; then weights the counts. */
Layers CellStencil::addByCounting(MaskNeighbourhood& neighbourhood, BlockSums& sums) const
{
  constexpr int kMaxEdge = 3 * kEdge;
  constexpr size_t kRows = kEdge * kEdge;
  const PaddedRows rows(neighbourhood, reach_);
  Layers reached;
  for (int fromZ = -reach_; fromZ < kEdge + reach_; ++fromZ)
  {
    if (rows.anyInLayer(fromZ))
      reached.include({std::max(0, fromZ - reachZ_), std::min(kEdge, fromZ + reachZ_ + 1)});
  }
  if (!reached.any()) return reached;
  std::vector<uint64_t>& counts = neighbourhood.counts;
  counts.resize(weights_.size() * kRows);
  for (size_t squared = 0; squared < weights_.size(); ++squared)
  {
    uint64_t* const count = &counts[squared * kRows];
    std::fill(count + reached.begin * kEdge, count + reached.end * kEdge, uint64_t{0});
  }
  for (int fromZ = -reach_; fromZ < kEdge + reach_; ++fromZ)
  {
    if (!rows.anyInLayer(fromZ)) continue;
    for (int j = 0; j <= reach_; ++j)
    {
      // Byte i: the number of marked cells among i − j and i + j of the row (j = 0: only cell i).
      std::array<uint64_t, kMaxEdge> pairs;
      for (int y = -reach_; y < kEdge + reach_; ++y)
      {
        const uint32_t bits = rows.at(y, fromZ);
        uint64_t& pair = pairs[static_cast<size_t>(y + reach_)];
        pair = bytesOfBits(bits >> (reach_ - j) & 0xFF);
        if (j > 0) pair += bytesOfBits(bits >> (reach_ + j) & 0xFF);
      }
      for (const Row& row : rows_)
      {
        const int z = fromZ - row.dz;
        if (j > row.extent || z < 0 || z >= kEdge) continue;
        const size_t squared = static_cast<size_t>(j * j + row.dy * row.dy + row.dz * row.dz);
        uint64_t* const count = &counts[squared * kRows + static_cast<size_t>(z * kEdge)];
        const uint64_t* const from = &pairs[static_cast<size_t>(row.dy + reach_)];
        for (int y = 0; y < kEdge; ++y) count[y] += from[y];
      }
    }
  }
  for (int row = reached.begin * kEdge; row < reached.end * kEdge; ++row)
    addWeighted(&counts[static_cast<size_t>(row)], kRows, &sums[static_cast<size_t>(row * kEdge)]);
  return reached;
}

/** Weights the counts of one row of cells.
 * @param counts of squared distance i at counts[i · stride], one cell per byte; @param sums of the 8 cells,
 * added to */
void CellStencil::addWeighted(const uint64_t* counts, size_t stride, int64_t* sums) const
{
  uint64_t any = 0;
  uint64_t notFull = 0;
  for (size_t squared = 0; squared < weights_.size(); ++squared)
  {
    any |= counts[squared * stride];
    notFull |= counts[squared * stride] ^ fullLanes_[squared];
  }
  if (any == 0) return;
  if (notFull == 0)  // inside free space
  {
    for (int x = 0; x < kEdge; ++x) sums[x] += fullSum_;
    return;
  }
  for (size_t squared = 0; squared < weights_.size(); ++squared)
  {
    const uint64_t lanes = counts[squared * stride];
    const int64_t weight = weights_[squared];
    for (int x = 0; x < kEdge; ++x) sums[x] += weight * static_cast<int64_t>(lanes >> (8 * x) & 0xFF);
  }
}

/// Spreads every marked cell over the block.
Layers CellStencil::addByCell(MaskNeighbourhood& neighbourhood, BlockSums& sums) const
{
  Layers reached;
  const auto spread = [&](int x, int y, int z)  // relative to the block's first cell
  {
    for (const Row& row : rows_)
    {
      const int toY = y + row.dy;
      const int toZ = z + row.dz;
      const int begin = std::max(0, x - row.extent);
      const int end = std::min(kEdge - 1, x + row.extent);
      if (toY < 0 || toY >= kEdge || toZ < 0 || toZ >= kEdge || begin > end) continue;
      reached.include({toZ, toZ + 1});
      for (int toX = begin; toX <= end; ++toX)
        sums[static_cast<size_t>((toZ * kEdge + toY) * kEdge + toX)] += weight(toX - x, row.dy, row.dz);
    }
  };
  const int n = neighbourhood.blocksEachWay;
  for (int dz = -n; dz <= n; ++dz)
  {
    for (int dy = -n; dy <= n; ++dy)
    {
      for (int dx = -n; dx <= n; ++dx)
      {
        const CellMask* mask = neighbourhood.at(dx, dy, dz);
        if (!mask) continue;
        for (int z = 0; z < kEdge; ++z)
        {
          for (uint64_t rest = (*mask)[static_cast<size_t>(z)]; rest != 0; rest &= rest - 1)
          {
            const int bit = __builtin_ctzll(rest);
            spread(dx * kEdge + bit % kEdge, dy * kEdge + bit / kEdge, dz * kEdge + z);
          }
        }
      }
    }
  }
  return reached;
}

}  // namespace lamap
