#include <lamap_core/overlapping/model_fusion.h>

#include <lamap_core/grid/evidence_draft.h>
#include <lamap_core/math/portable_math_four.h>
#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <tuple>

namespace lamap
{
namespace
{
using Four = Eigen::Array4f;
constexpr int kEdge = kScanBlockEdge;

double tilesIn(const BlockIndex& low, const BlockIndex& high)
{
  const auto along = [](int32_t from, int32_t to) { return static_cast<double>(to) - from + 1; };
  return along(low.x, high.x) * along(low.y, high.y) * along(low.z, high.z);
}

bool fewEnough(const BlockIndex& low, const BlockIndex& high)
{
  return tilesIn(low, high) <= ScanBlocks::kMaxBlocks;
}

/// The tile of a coordinate [cells] along an axis, held to some tiles; by default, to those that cells are
/// in.
int32_t tileAt(int32_t anchor, double cell, int32_t low = -(1 << 28), int32_t high = (1 << 28) - 1)
{
  const double tile = std::floor((cell + anchor) / kEdge);
  return static_cast<int32_t>(std::clamp(tile, static_cast<double>(low), static_cast<double>(high)));
}

}  // namespace

/// Log-odds of the cells of a tile, x fastest, then y, then z.
class ModelFusion::Tile
{
 public:
  explicit Tile(ModelFusion& fusion)
      : fusion_(fusion), threshold_(std::max(static_cast<float>(fusion.shape_.cutoff), kNothing))
  {
  }

  void sum(size_t number)
  {
    const bool compact = fusion_.shape_.compact();
    logodds_.fill(compact ? kUnreached : fusion_.model_->bias);
    tile_ = fusion_.tiles_.blocks()[number];
    const CellIndex corner = fusion_.firstCellOf(tile_);
    const CellIndex& anchor = fusion_.pose_.anchor;
    first_ = {corner.x - anchor.x, corner.y - anchor.y, corner.z - anchor.z};
    const uint32_t begin = number == 0 ? 0 : fusion_.sourceEnds_[number - 1];
    for (uint32_t i = begin; i < fusion_.sourceEnds_[number]; ++i)
      add(fusion_.sources_[fusion_.tileSources_[i]]);
    keepHits(number);
  }

  /// Calls visit(x, y, z, sums) for the cells of which the model says something.
  template <typename Visit>
  void forEachEvidence(Visit&& visit) const
  {
    for (int z = 0; z < layers(); ++z)
      for (int y = 0; y < kEdge; ++y)
        for (int x = 0; x < kEdge; x += 4) visitFour(x, y, z, visit);
  }

 private:
  /// What stays where nothing is added; all that is added is so much larger that it replaces this.
  static constexpr float kUnreached = 0x1p-100f;
  static constexpr float kNothing = 1e-9f;

  static constexpr float kOne = 1.0f;

  [[nodiscard]] int layers() const { return fusion_.shape_.planar ? 1 : kEdge; }
  [[nodiscard]] const float* factorsOf(const Source& source, size_t axis, int32_t tile) const
  {
    return fusion_.factors_.data() + source.factors[axis] + static_cast<size_t>(tile) * kEdge;
  }

  template <typename Visit>
  void visitFour(int x, int y, int z, Visit&& visit) const
  {
    const ModelShape& shape = fusion_.shape_;
    const HilbertModel& model = *fusion_.model_;
    const float* logodds = logodds_.data() + (z * kEdge + y) * kEdge + x;
    // Of most cells of a tile along a long ray, nothing is said.
    const auto isReached = [&](float sum) { return !shape.compact() || sum != kUnreached; };
    if (std::none_of(logodds, logodds + 4, isReached)) return;
    std::array<Eigen::Vector3d, 4> places;
    std::array<bool, 4> speaks{};
    for (size_t i = 0; i < 4; ++i)
    {
      const Eigen::Vector3d centre_cells(first_[0] + x + static_cast<int>(i) + 0.5, first_[1] + y + 0.5,
                                         shape.planar ? 0.0 : first_[2] + z + 0.5);
      places[i] = fusion_.pose_.toModel(centre_cells * shape.resolution_m);
      if (shape.planar) places[i].z() = shape.flatHeight();
      speaks[i] = isReached(logodds[i]) && model.inBox(places[i], shape.planar);
    }
    if (!(speaks[0] || speaks[1] || speaks[2] || speaks[3])) return;
    const DepthView::Seen seen = model.seen(places);
    for (size_t i = 0; i < 4; ++i)
    {
      if (!speaks[i]) continue;
      const CellSums sums = model.evidenceOf(shape, logodds[i], seen.inField[i], seen.open[i]);
      if (sums.any()) visit(x + static_cast<int>(i), y, z, sums);
    }
  }

  void keepHits(size_t number)
  {
    const auto first = std::lower_bound(fusion_.hits_.begin(), fusion_.hits_.end(), number,
                                        [](const Hit& hit, size_t tile) { return hit.tile < tile; });
    const auto last =
        std::find_if(first, fusion_.hits_.end(), [&](const Hit& hit) { return hit.tile != number; });
    for (auto hit = first; hit != last; ++hit)
    {
      const bool isSecond = hit != first && hit->cell == std::prev(hit)->cell;
      if (isSecond) continue;
      fusion_.hitLogodds_[hit->number] = logodds_[hit->cell];
      logodds_[hit->cell] = std::max(logodds_[hit->cell], HilbertModel::kHitLogodds);
    }
  }

  void add(const Source& source)
  {
    const float* alongX = factorsOf(source, 0, tile_.x - source.firstTile.x);
    const float* alongY = factorsOf(source, 1, tile_.y - source.firstTile.y);
    const float* alongZ = fusion_.shape_.planar ? &kOne : factorsOf(source, 2, tile_.z - source.firstTile.z);
    const Four low = Eigen::Map<const Four>(alongX);
    const Four high = Eigen::Map<const Four>(alongX + 4);
    const Four cutoff = Four::Constant(static_cast<float>(fusion_.shape_.cutoff));
    const Four zero = Four::Zero();
    const float largestX = *std::max_element(alongX, alongX + kEdge);
    const auto addHalf = [&](const Four& factors, float yz, float* sums)
    {
      const Four product = yz * factors;
      const Four kernel = (product - cutoff).max(zero);
      const Four term = source.weight * kernel;
      Eigen::Map<Four> held(sums);
      held += term;
    };
    for (int z = 0; z < layers(); ++z)
      for (int y = 0; y < kEdge; ++y)
      {
        const float yz = alongY[y] * alongZ[z];
        if (!(yz * largestX > threshold_)) continue;
        float* sums = logodds_.data() + (z * kEdge + y) * kEdge;
        addHalf(low, yz, sums);
        addHalf(high, yz, sums + 4);
      }
  }

  ModelFusion& fusion_;  ///< of which it changes hitLogodds_ only
  float threshold_;
  BlockIndex tile_;
  std::array<int32_t, 3> first_{};  ///< cell of the tile, from the anchor
  alignas(16) std::array<float, kScanBlockCells> logodds_;
};

/// Working memory of one thread.
struct ModelFusion::Worker
{
  explicit Worker(ModelFusion& fusion) : tile(fusion), draft(fusion.blockShape_) {}
  Tile tile;
  EvidenceDraft draft;
};

CellIndex ModelFusion::firstCellOf(const BlockIndex& tile) const
{
  return {tile.x * kEdge, tile.y * kEdge, shape_.planar ? tile.z : tile.z * kEdge};
}

void ModelFusion::choose(const HilbertModel& model, const ModelPose& pose, const BlockShape& blockShape,
                         const Workers& workers)
{
  blockShape_ = blockShape;
  model_ = &model;
  shape_ = certain_.widened(model.variance);
  pose_ = pose;
  findWindow();
  requireFewTiles();
  listSources();
  constexpr size_t kAtOnce = 256;
  workers.forEach((sources_.size() + kAtOnce - 1) / kAtOnce,
                  [&](size_t part)
                  {
                    const size_t end = std::min(sources_.size(), (part + 1) * kAtOnce);
                    for (size_t i = part * kAtOnce; i < end; ++i) findFactors(sources_[i]);
                  });
  listTiles();
  listHits();
  listGroups();
}

/// The tiles around the box, as it lies in the grid.
void ModelFusion::findWindow()
{
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e300);
  Eigen::Vector3d high = -low;
  for (int corner = 0; corner < 8; ++corner)
  {
    const auto along = [&](int axis)
    { return (corner >> axis & 1) != 0 ? model_->boxHigh[axis] : model_->boxLow[axis]; };
    const Eigen::Vector3d at =
        pose_.fromModel(Eigen::Vector3d(along(0), along(1), along(2))) / shape_.resolution_m;
    low = low.cwiseMin(at);
    high = high.cwiseMax(at);
  }
  const CellIndex& anchor = pose_.anchor;
  low_ = {tileAt(anchor.x, std::floor(low.x()) - 1), tileAt(anchor.y, std::floor(low.y()) - 1),
          shape_.planar ? layer_ : tileAt(anchor.z, std::floor(low.z()) - 1)};
  high_ = {tileAt(anchor.x, std::ceil(high.x()) + 1), tileAt(anchor.y, std::ceil(high.y()) + 1),
           shape_.planar ? layer_ : tileAt(anchor.z, std::ceil(high.z()) + 1)};
}

/// A bias is said everywhere in the box.
void ModelFusion::requireFewTiles() const
{
  if (!shape_.compact() && !fewEnough(low_, high_))
    throw std::length_error(
        "the box of a scan's training points has more than 4 million blocks with edges of 8 cells: set "
        "maxRange, boxQuantile or a larger resolution");
}

void ModelFusion::listSources()
{
  const double reach = shape_.support_m / shape_.resolution_m;
  const CellIndex& anchor = pose_.anchor;
  sources_.clear();
  sources_.reserve(model_->kernelCount());
  size_t factors = 0;
  double pairs = 0;  // of a kernel and a tile
  model_->forEachKernel(
      shape_,
      [&](const Eigen::Vector3d& centre, float weight)
      {
        Source source{pose_.fromModel(centre) / shape_.resolution_m, weight, low_, high_, {}};
        const Eigen::Vector3d& c = source.centre_cells;
        // Cells whose centres lie within the reach.
        const auto first = [&](int axis) { return std::ceil(c[axis] - reach - 0.5); };
        const auto last = [&](int axis) { return std::floor(c[axis] + reach - 0.5); };
        // One tile more than there are, where all that is reached lies beside the window.
        source.firstTile.x = tileAt(anchor.x, first(0), low_.x, high_.x + 1);
        source.firstTile.y = tileAt(anchor.y, first(1), low_.y, high_.y + 1);
        source.lastTile.x = tileAt(anchor.x, last(0), low_.x - 1, high_.x);
        source.lastTile.y = tileAt(anchor.y, last(1), low_.y - 1, high_.y);
        if (!shape_.planar)
        {
          source.firstTile.z = tileAt(anchor.z, first(2), low_.z, high_.z + 1);
          source.lastTile.z = tileAt(anchor.z, last(2), low_.z - 1, high_.z);
        }
        const std::array<int32_t, 3> tiles{source.lastTile.x - source.firstTile.x + 1,
                                           source.lastTile.y - source.firstTile.y + 1,
                                           source.lastTile.z - source.firstTile.z + 1};
        if (*std::min_element(tiles.begin(), tiles.end()) <= 0) return;
        pairs += tilesIn(source.firstTile, source.lastTile);
        if (pairs > kMostPairs)
          throw std::length_error(
              "the kernels of a scan's model reach more than 2^29 blocks with edges of 8 cells, each counted "
              "for "
              "every kernel: set maxRange, fewer components, or a larger gamma or resolution");
        for (size_t axis = 0; axis < 3; ++axis)
        {
          source.factors[axis] = factors;
          factors += static_cast<size_t>(tiles[axis]) * kEdge;
        }
        sources_.push_back(source);
      });
  factors_.resize(factors);
}

/// exp(−γd²) at the cells of its tiles along each axis; where that is not above the cutoff it may be 0.
void ModelFusion::findFactors(Source& source)
{
  const auto alongAxis = [&](size_t axis, int32_t firstTile, int32_t lastTile, int32_t anchor)
  {
    const double first = firstTile * kEdge - anchor + 0.5 - source.centre_cells[static_cast<int>(axis)];
    const auto start = static_cast<float>(first * shape_.resolution_m);
    const auto step = static_cast<float>(shape_.resolution_m);
    const auto gamma = static_cast<float>(-shape_.gamma);
    const int count = (lastTile - firstTile + 1) * kEdge;
    float* factors = factors_.data() + source.factors[axis];
    for (int i = 0; i < count; ++i)
    {
      const float d = start + static_cast<float>(i) * step;
      factors[i] = gamma * (d * d);
    }
    for (int i = 0; i < count; i += 4)
    {
      Eigen::Map<Four> four(factors + i);
      four = portableExp(Four(four));
    }
  };
  const CellIndex& anchor = pose_.anchor;
  alongAxis(0, source.firstTile.x, source.lastTile.x, anchor.x);
  alongAxis(1, source.firstTile.y, source.lastTile.y, anchor.y);
  if (!shape_.planar) alongAxis(2, source.firstTile.z, source.lastTile.z, anchor.z);
}

void ModelFusion::listTiles()
{
  tiles_.reset(low_, high_);
  if (!shape_.compact())
    forEachBlock(low_, high_, [&](const BlockIndex& tile) { (void)tiles_.findOrAdd(tile); });
  // Counted, then sorted into each tile's part, in the order of the sources.
  sourceEnds_.assign(tiles_.blocks().size(), 0);
  for (const Source& source : sources_)
    forEachBlock(source.firstTile, source.lastTile,
                 [&](const BlockIndex& tile)
                 {
                   const auto number = static_cast<size_t>(tiles_.findOrAdd(tile));
                   if (number >= sourceEnds_.size()) sourceEnds_.resize(number + 1, 0);
                   ++sourceEnds_[number];
                 });
  uint32_t total = 0;
  for (uint32_t& end : sourceEnds_)
  {
    const uint32_t count = end;
    end = total;
    total += count;
  }
  tileSources_.resize(total);
  for (uint32_t i = 0; i < sources_.size(); ++i)
    forEachBlock(sources_[i].firstTile, sources_[i].lastTile,
                 [&](const BlockIndex& tile)
                 { tileSources_[sourceEnds_[static_cast<size_t>(tiles_.find(tile))]++] = i; });
}

void ModelFusion::listHits()
{
  hits_.clear();
  hitLogodds_.assign(model_->hits.size(), std::numeric_limits<float>::infinity());
  const auto cells = model_->hitCells(pose_, shape_, layer_);
  for (size_t i = 0; i < cells.size(); ++i)
  {
    if (!cells[i]) continue;
    const CellIndex& cell = *cells[i];
    const BlockIndex tile{cell.x >> kScanBlockLog2Edge, cell.y >> kScanBlockLog2Edge,
                          shape_.planar ? cell.z : cell.z >> kScanBlockLog2Edge};
    const int32_t number = tiles_.find(tile);
    if (number < 0) continue;
    const CellIndex corner = firstCellOf(tile);
    const int32_t inTile = ((cell.z - corner.z) * kEdge + cell.y - corner.y) * kEdge + cell.x - corner.x;
    hits_.push_back({static_cast<uint32_t>(number), static_cast<uint32_t>(inTile), static_cast<uint32_t>(i)});
  }
  std::sort(hits_.begin(), hits_.end(),
            [](const Hit& a, const Hit& b)
            { return std::tie(a.tile, a.cell, a.number) < std::tie(b.tile, b.cell, b.number); });
}

void ModelFusion::listGroups()
{
  const int log2Group = std::max(0, blockShape_.log2Edge() - kScanBlockLog2Edge);
  const std::vector<BlockIndex>& tiles = tiles_.blocks();
  groups_.form(tiles.size(), log2Group == 0,
               [&](uint32_t tile)
               {
                 const BlockIndex& index = tiles[tile];
                 return BlockIndex{index.x >> log2Group, index.y >> log2Group,
                                   shape_.planar ? index.z : index.z >> log2Group};
               });

  mapBlocks_.clear();
  const int each = 1 << std::max(0, kScanBlockLog2Edge - blockShape_.log2Edge());
  const int eachZ = shape_.planar ? 1 : each;
  for (const BlockGroups::Group& group : groups_.all())
  {
    const BlockIndex first{group.place.x * each, group.place.y * each, group.place.z * eachZ};
    forEachBlock(first, {first.x + each - 1, first.y + each - 1, first.z + eachZ - 1},
                 [&](const BlockIndex& block) { mapBlocks_.push_back(block); });
  }
  std::sort(mapBlocks_.begin(), mapBlocks_.end());
}

Evidence ModelFusion::infer(const std::vector<BlockIndex>* wanted, const Workers& workers)
{
  tbb::enumerable_thread_specific<Worker> own([&] { return Worker(*this); });
  workers.forEach(groups_.all().size(), [&](size_t i) { inferGroup(groups_.all()[i], own.local(), wanted); });
  return collectEvidence(blockShape_, SumKind::Signed, own);
}

void ModelFusion::inferGroup(const BlockGroups::Group& group, Worker& worker,
                             const std::vector<BlockIndex>* wanted)
{
  const auto isWanted = [&](const BlockIndex& block)
  { return wanted == nullptr || std::binary_search(wanted->begin(), wanted->end(), block); };
  const bool holdsGroup = blockShape_.edge() >= kEdge;
  if (holdsGroup && !isWanted(group.place)) return;
  EvidenceDraft& draft = worker.draft;
  for (const uint32_t number : group)
  {
    const CellIndex corner = firstCellOf(tiles_.blocks()[number]);
    worker.tile.sum(number);
    if (holdsGroup)
    {
      worker.tile.forEachEvidence(
          [&](int x, int y, int z, const CellSums& sums) {
            draft.set(blockShape_.offsetOf({corner.x + x, corner.y + y, corner.z + z}), sums);
          });
      continue;
    }
    // Several blocks of the map in one tile: the cells of one after the other.
    std::vector<std::pair<BlockIndex, std::pair<uint32_t, CellSums>>> cells;
    worker.tile.forEachEvidence(
        [&](int x, int y, int z, const CellSums& sums)
        {
          const CellIndex cell{corner.x + x, corner.y + y, corner.z + z};
          const BlockIndex block = blockShape_.blockOf(cell);
          if (isWanted(block)) cells.push_back({block, {blockShape_.offsetOf(cell), sums}});
        });
    std::stable_sort(cells.begin(), cells.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    for (size_t c = 0; c < cells.size(); ++c)
    {
      draft.set(cells[c].second.first, cells[c].second.second);
      const bool isLast = c + 1 == cells.size() || !(cells[c + 1].first == cells[c].first);
      if (isLast) draft.finishBlock(cells[c].first);
    }
  }
  if (holdsGroup) draft.finishBlock(group.place);
}

}  // namespace lamap
