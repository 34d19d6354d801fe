#include <lamap_core/bgk/wide_cells.h>

#include <algorithm>
#include <stdexcept>

namespace lamap
{
namespace
{
constexpr int kEdge = kScanBlockEdge;
constexpr size_t kRow = kEdge;
constexpr size_t kLayer = kRow * kRow;

/// Weights of cells by their distance along an axis, zero beyond the reach: at distance d at [d + middle].
struct AxisWeights
{
  AxisWeights(const std::vector<float>& weights, double factor)
      : reach(static_cast<int>(weights.size()) / 2), middle(reach + 2 * kEdge), padded(2 * middle + 1, 0.0F)
  {
    for (size_t i = 0; i < weights.size(); ++i)
      padded[i + 2 * kRow] = static_cast<float>(factor * weights[i]);
  }
  [[nodiscard]] int blocksEachWay() const { return (reach + kEdge - 1) / kEdge; }
  [[nodiscard]] const float* from(int distance) const
  {
    return &padded[static_cast<size_t>(distance + middle)];
  }

  int reach;
  int middle;
  std::vector<float> padded;
};

BlockIndex moved(const BlockIndex& block, const BlockIndex& axis, int steps)
{
  return {block.x + axis.x * steps, block.y + axis.y * steps, block.z + axis.z * steps};
}

constexpr BlockIndex kAlongX{1, 0, 0};
constexpr BlockIndex kAlongY{0, 1, 0};
constexpr BlockIndex kAlongZ{0, 0, 1};

/// Fields of more blocks would take gigabytes: such scans are a mistake in the unit, or have no maximum
/// range.
constexpr size_t kMaxBlocks = size_t{1} << 17;

void requireRoom(const ScanBlocks& blocks)
{
  if (blocks.blocks().size() > kMaxBlocks)
    throw std::length_error(
        "the wide points of a scan reach more than 67 million cells: set maxRange, or beamWidth = none");
}

void addScaled(const float* from, float weight, size_t count, float* to)
{
  for (size_t i = 0; i < count; ++i)
  {
    const float product = weight * from[i];
    to[i] += product;
  }
}

}  // namespace

void WideCells::clear(Field& field, const std::vector<BlockIndex>& others, const BlockIndex& axis,
                      int blocksEachWay) const
{
  field.blocks.reset(low_, high_);
  for (const BlockIndex& other : others)
    for (int step = -blocksEachWay; step <= blocksEachWay; ++step)
      (void)field.blocks.findOrAdd(moved(other, axis, step));
  requireRoom(field.blocks);
  field.sums.assign(field.blocks.blocks().size(), Sums{});
}

void WideCells::compute(const TrainingSet& training, const std::vector<ExpectedKernel>& kernels,
                        CellMask WideMasks::*mask, bool WideMasks::*any, bool planar, const Workers& workers)
{
  const auto isMarked = [&](const WideMasks& masks) { return masks.*any; };
  int blocksEachWay = 0;
  for (size_t level = 0; level < kWideLevels; ++level)
    if (std::any_of(training.wideMasks[level].begin(), training.wideMasks[level].end(), isMarked))
      blocksEachWay = kernels[level].reach() / kEdge + 1;
  const BlockIndex& low = training.blocks.low();
  const BlockIndex& high = training.blocks.high();
  low_ = {low.x - blocksEachWay, low.y - blocksEachWay, low.z - blocksEachWay};
  high_ = {high.x + blocksEachWay, high.y + blocksEachWay, high.z + blocksEachWay};
  clear(total_, {}, kAlongX, 0);
  for (size_t level = 0; level < kWideLevels; ++level)
  {
    const std::vector<WideMasks>& masks = training.wideMasks[level];
    if (std::none_of(masks.begin(), masks.end(), isMarked)) continue;
    for (const ExpectedKernel::Term& term : kernels[level].terms())
    {
      sumAlongX(training, masks, mask, term, workers);
      sumAlongY(term, workers);
      if (planar)
        addLayers(term.factor);
      else
        addAlongZ(term, workers);
    }
  }
}

void WideCells::sumAlongX(const TrainingSet& training, const std::vector<WideMasks>& level,
                          CellMask WideMasks::*mask, const ExpectedKernel::Term& term, const Workers& workers)
{
  const AxisWeights weights(term.weights, 1.0);
  const int n = weights.blocksEachWay();
  const auto isEmpty = [](const CellMask& cells)
  { return std::all_of(cells.begin(), cells.end(), [](uint64_t word) { return word == 0; }); };
  std::vector<BlockIndex> marked;
  for (size_t number = 0; number < level.size(); ++number)
    if (!isEmpty(level[number].*mask)) marked.push_back(training.blocks.blocks()[number]);
  clear(alongX_, marked, kAlongX, n);
  workers.forEach(alongX_.sums.size(),
                  [&](size_t i)
                  {
                    Sums& sums = alongX_.sums[i];
                    for (int step = -n; step <= n; ++step)
                    {
                      const int32_t number =
                          training.blocks.find(moved(alongX_.blocks.blocks()[i], kAlongX, step));
                      if (number < 0 || static_cast<size_t>(number) >= level.size()) continue;
                      const CellMask& cells = level[static_cast<size_t>(number)].*mask;
                      for (size_t z = 0; z < cells.size(); ++z)
                        for (uint64_t rest = cells[z]; rest != 0; rest &= rest - 1)
                        {
                          const int bit = __builtin_ctzll(rest);
                          const float* const weight = weights.from(-(step * kEdge + bit % kEdge));
                          float* const row = &sums[z * kLayer + static_cast<size_t>(bit / kEdge) * kRow];
                          for (size_t x = 0; x < kRow; ++x) row[x] += weight[x];
                        }
                    }
                  });
}

void WideCells::sumAlongY(const ExpectedKernel::Term& term, const Workers& workers)
{
  const AxisWeights weights(term.weights, 1.0);
  const int n = weights.blocksEachWay();
  clear(alongXy_, alongX_.blocks.blocks(), kAlongY, n);
  workers.forEach(alongXy_.sums.size(),
                  [&](size_t i)
                  {
                    Sums& sums = alongXy_.sums[i];
                    for (int step = -n; step <= n; ++step)
                    {
                      const Sums* const from =
                          alongX_.find(moved(alongXy_.blocks.blocks()[i], kAlongY, step));
                      if (from == nullptr) continue;
                      for (int fromY = 0; fromY < kEdge; ++fromY)
                        for (int y = 0; y < kEdge; ++y)
                        {
                          const float weight = *weights.from(y - fromY - step * kEdge);
                          if (weight == 0) continue;
                          for (size_t z = 0; z < kRow; ++z)
                            addScaled(&(*from)[z * kLayer + static_cast<size_t>(fromY) * kRow], weight, kRow,
                                      &sums[z * kLayer + static_cast<size_t>(y) * kRow]);
                        }
                    }
                  });
}

void WideCells::addAlongZ(const ExpectedKernel::Term& term, const Workers& workers)
{
  const AxisWeights weights(term.weights, term.factor);
  const int n = weights.blocksEachWay();
  for (const BlockIndex& block : alongXy_.blocks.blocks())
    for (int step = -n; step <= n; ++step) (void)total_.blocks.findOrAdd(moved(block, kAlongZ, step));
  requireRoom(total_.blocks);
  total_.sums.resize(total_.blocks.blocks().size(), Sums{});
  workers.forEach(total_.sums.size(),
                  [&](size_t i)
                  {
                    Sums& sums = total_.sums[i];
                    for (int step = -n; step <= n; ++step)
                    {
                      const Sums* const from = alongXy_.find(moved(total_.blocks.blocks()[i], kAlongZ, step));
                      if (from == nullptr) continue;
                      for (int fromZ = 0; fromZ < kEdge; ++fromZ)
                        for (int z = 0; z < kEdge; ++z)
                        {
                          const float weight = *weights.from(z - fromZ - step * kEdge);
                          if (weight != 0)
                            addScaled(&(*from)[static_cast<size_t>(fromZ) * kLayer], weight, kLayer,
                                      &sums[static_cast<size_t>(z) * kLayer]);
                        }
                    }
                  });
}

/// As addAlongZ(), where cells have no weight but in their own layer.
void WideCells::addLayers(double factor)
{
  for (size_t i = 0; i < alongXy_.sums.size(); ++i)
  {
    const auto number = static_cast<size_t>(total_.blocks.findOrAdd(alongXy_.blocks.blocks()[i]));
    if (number >= total_.sums.size()) total_.sums.resize(number + 1, Sums{});
    addScaled(alongXy_.sums[i].data(), static_cast<float>(factor), kScanBlockCells,
              total_.sums[number].data());
  }
}

}  // namespace lamap
