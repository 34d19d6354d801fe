#include <lamap_core/training/point_groups.h>
#include <lamap_core/training/scan_training.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace lamap
{
namespace
{
/// A ray in the scan's frame [cells]; free from the origin as far as freeLength.
struct TrainingRay
{
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;  ///< of length 1
  double freeLength;          ///< < 0: the ray has no free part
};

/** Distances of a ray's free samples from its origin [cells]: i·step, as far as the ray is free.
 *
 * A sample within a millionth of a cell of the end stands on the end. Ranges are often whole steps (a maximum
 * range, a simulated wall): without this, rounding would decide for each ray and each place on the map
 * whether it has its last sample. */
class FreeSamples
{
 public:
  FreeSamples(const TrainingRay& ray, double step)
      : step_(step),
        length_(std::max(ray.freeLength, 0.0)),
        count_(ray.freeLength < -kOnEnd_cells ? 0 : static_cast<int64_t>((length_ + kOnEnd_cells) / step) + 1)
  {
  }
  [[nodiscard]] int64_t count() const { return count_; }
  [[nodiscard]] double at(int64_t i) const { return std::min(static_cast<double>(i) * step_, length_); }

 private:
  static constexpr double kOnEnd_cells = 1e-6;
  double step_;
  double length_;
  int64_t count_;
};

/// A bounding box of cells relative to the anchor.
struct CellBounds
{
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e18);
  Eigen::Vector3d high = Eigen::Vector3d::Constant(-1e18);

  void extend(const Eigen::Vector3d& point)
  {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
};

BlockIndex blockOfLocal(const Eigen::Vector3d& local, const BlockOffset& offset)
{
  return {(localCell(local.x()) + offset.x) >> kScanBlockLog2Edge,
          (localCell(local.y()) + offset.y) >> kScanBlockLog2Edge,
          (localCell(local.z()) + offset.z) >> kScanBlockLog2Edge};
}

/// Marks cells in the masks of the blocks that hold them; the last block is remembered, for rays walk on.
class MaskMarker
{
 public:
  MaskMarker(ScanBlocks& blocks, std::vector<BlockMasks>& masks, const BlockOffset& offset)
      : blocks_(blocks), masks_(masks), offset_(offset)
  {
  }

  template <CellMask BlockMasks::*kMask>
  void mark(int32_t localX, int32_t localY, int32_t localZ)
  {
    const int32_t x = localX + offset_.x;
    const int32_t y = localY + offset_.y;
    const int32_t z = localZ + offset_.z;
    const BlockIndex block{x >> kScanBlockLog2Edge, y >> kScanBlockLog2Edge, z >> kScanBlockLog2Edge};
    if (number_ < 0 || !(block == last_))
    {
      number_ = blocks_.findOrAdd(block);
      last_ = block;
      if (static_cast<size_t>(number_) >= masks_.size()) masks_.resize(static_cast<size_t>(number_) + 1);
    }
    constexpr int32_t kLow = kScanBlockEdge - 1;
    (masks_[static_cast<size_t>(number_)].*kMask)[static_cast<size_t>(z & kLow)] |=
        uint64_t{1} << ((y & kLow) * kScanBlockEdge + (x & kLow));
  }

  /// Marks the cells of the ray's free samples.
  void markFreeSamples(const TrainingRay& ray, double step)
  {
    const FreeSamples samples(ray, step);
    for (int64_t i = 0; i < samples.count(); ++i)
    {
      const double t = samples.at(i);
      mark<&BlockMasks::free>(localCell(ray.origin.x() + t * ray.direction.x()),
                              localCell(ray.origin.y() + t * ray.direction.y()),
                              localCell(ray.origin.z() + t * ray.direction.z()));
    }
  }

 private:
  ScanBlocks& blocks_;
  std::vector<BlockMasks>& masks_;
  BlockOffset offset_;
  BlockIndex last_;
  int32_t number_ = -1;
};

}  // namespace

struct ScanTrainer::Workspace
{
  /// Free cells marked by one of several threads.
  struct Marks
  {
    ScanBlocks blocks;
    std::vector<BlockMasks> masks;
  };

  TrainingSet set;
  std::vector<TrainingRay> rays;
  PointGroups groups;
  PointGroups rawHits;
  std::vector<Marks> marks;
  CellBounds bounds;

  void collectFan(SelectedFan& fan, const TrainingRules& rules, const ScanFrame& frame, bool planar,
                  double resolution_m, RayCounts& counts);
  void addRays(const Eigen::Vector3d& origin, double margin);
  void markHits(const TrainingRules& rules, const BlockOffset& offset);
  void markFreeCells(double step, const BlockOffset& offset, unsigned threads);
  void sampleFreePoints(double step, double downsampling_cells, const CellIndex& anchor);
  void openWindow(const BlockOffset& offset);
};

namespace
{
/** Key of the group a point belongs to: its cell, its voxel of `edge`, or one of its own.
 * @param edge [cells]; 0: a group a point */
uint64_t groupKey(const Eigen::Vector3d& local, TrainingPoints kind, double edge, const CellIndex& anchor,
                  size_t ordinal)
{
  if (kind == TrainingPoints::Cells || edge == 1.0) return cellKey(local);
  if (edge == 0.0) return ordinal;
  // Voxels are counted from the map's origin, not from the anchor.
  const auto voxel = [&](double coordinate, int32_t anchorCell)
  {
    const double first = std::floor(anchorCell / edge);
    return static_cast<int64_t>(std::floor((anchorCell + coordinate) / edge) - first);
  };
  return packKey(voxel(local.x(), anchor.x), voxel(local.y(), anchor.y), voxel(local.z(), anchor.z));
}

}  // namespace

void ScanTrainer::Workspace::addRays(const Eigen::Vector3d& origin, double margin)
{
  for (const PointGroup& group : groups.groups())
  {
    const Eigen::Vector3d ray = group.mean() - origin;
    const double length = ray.norm();
    if (length > 0) rays.push_back({origin, ray / length, length - margin});
  }
}

void ScanTrainer::Workspace::collectFan(SelectedFan& fan, const TrainingRules& rules, const ScanFrame& frame,
                                        bool planar, double resolution_m, RayCounts& counts)
{
  const auto localOrigin = frame.toLocal(fan.origin_map);
  const auto forEachEnd =
      [&](const std::vector<Eigen::Vector3d>& ends, size_t& used, auto&& toLocal, auto&& visit)
  {
    size_t ordinal = 0;
    for (const Eigen::Vector3d& end : ends)
    {
      const std::optional<Eigen::Vector3d> local = localOrigin ? toLocal(end) : std::nullopt;
      if (!local || (planar && *local == *localOrigin))
      {
        --used;
        ++(local ? counts.tooNear : counts.outside);
        continue;
      }
      bounds.extend(*local);
      visit(*local, ordinal++);
    }
  };

  const double hitEdge = rules.hitDownsampling / resolution_m;
  const bool asCells = rules.points == TrainingPoints::Cells;
  groups.clear();
  forEachEnd(
      fan.hitEnds_map, counts.hits, [&](const Eigen::Vector3d& end) { return frame.toLocal(end); },
      [&](const Eigen::Vector3d& local, size_t ordinal)
      {
        groups.add(groupKey(local, rules.points, hitEdge, frame.anchor(), ordinal), local);
        if (asCells || rules.protectHits > 0) rawHits.add(cellKey(local), local);
      });
  if (!asCells)
  {
    for (const PointGroup& group : groups.groups()) set.hitPoints.push_back(group.mean());
  }
  if (localOrigin)
  {
    bounds.extend(*localOrigin);
    addRays(*localOrigin, rules.freeMargin / resolution_m);
  }

  groups.clear();
  forEachEnd(
      fan.freeRays_map, counts.freeOnly,
      [&](const Eigen::Vector3d& ray) { return frame.endOfRay(*localOrigin, ray); },
      [&](const Eigen::Vector3d& local, size_t ordinal)
      { groups.add(groupKey(local, rules.points, hitEdge, frame.anchor(), ordinal), local); });
  if (localOrigin) addRays(*localOrigin, 0.0);
}

void ScanTrainer::Workspace::openWindow(const BlockOffset& offset)
{
  if (bounds.low.x() > bounds.high.x()) bounds.extend(Eigen::Vector3d::Zero());
  // A sample may round across the face of its ray's last cell.
  bounds.low.array() -= 1.0;
  bounds.high.array() += 1.0;
  set.blocks.reset(blockOfLocal(bounds.low, offset), blockOfLocal(bounds.high, offset));
}

void ScanTrainer::Workspace::markHits(const TrainingRules& rules, const BlockOffset& offset)
{
  const bool asCells = rules.points == TrainingPoints::Cells;
  MaskMarker marker(set.blocks, set.masks, offset);
  for (const PointGroup& group : rawHits.groups())
  {
    const int32_t x = localCell(group.first.x());
    const int32_t y = localCell(group.first.y());
    const int32_t z = localCell(group.first.z());
    if (asCells) marker.mark<&BlockMasks::hit>(x, y, z);
    if (rules.protectHits > 0 && group.count >= rules.protectHits)
      marker.mark<&BlockMasks::protectedHit>(x, y, z);
  }
}

void ScanTrainer::Workspace::markFreeCells(double step, const BlockOffset& offset, unsigned threads)
{
  constexpr size_t kRaysWorthAThread = 256;
  const size_t workers = std::min<size_t>(threads, rays.size() / kRaysWorthAThread + 1);
  const auto markRange = [&](ScanBlocks& blocks, std::vector<BlockMasks>& masks, size_t begin, size_t end)
  {
    MaskMarker marker(blocks, masks, offset);
    for (size_t i = begin; i < end; ++i) marker.markFreeSamples(rays[i], step);
  };
  if (workers == 1) return markRange(set.blocks, set.masks, 0, rays.size());

  if (marks.size() < workers) marks.resize(workers);
  tbb::parallel_for(size_t{0}, workers,
                    [&](size_t worker)
                    {
                      Marks& own = marks[worker];
                      own.blocks.reset(blockOfLocal(bounds.low, offset), blockOfLocal(bounds.high, offset));
                      own.masks.clear();
                      markRange(own.blocks, own.masks, rays.size() * worker / workers,
                                rays.size() * (worker + 1) / workers);
                    });
  for (size_t worker = 0; worker < workers; ++worker)
  {
    const std::vector<BlockIndex>& blocks = marks[worker].blocks.blocks();
    for (size_t i = 0; i < blocks.size(); ++i)
    {
      const auto number = static_cast<size_t>(set.blocks.findOrAdd(blocks[i]));
      if (number >= set.masks.size()) set.masks.resize(number + 1);
      for (size_t z = 0; z < kScanBlockEdge; ++z) set.masks[number].free[z] |= marks[worker].masks[i].free[z];
    }
  }
}

void ScanTrainer::Workspace::sampleFreePoints(double step, double downsampling_cells, const CellIndex& anchor)
{
  groups.clear();
  for (const TrainingRay& ray : rays)
  {
    const FreeSamples samples(ray, step);
    for (int64_t i = 0; i < samples.count(); ++i)
    {
      const double t = samples.at(i);
      const Eigen::Vector3d point = ray.origin + t * ray.direction;
      if (downsampling_cells > 0)
        groups.add(groupKey(point, TrainingPoints::Centroids, downsampling_cells, anchor, 0), point);
      else
        set.freePoints.push_back(point);
    }
  }
  for (const PointGroup& group : groups.groups()) set.freePoints.push_back(group.mean());
}

ScanTrainer::ScanTrainer() : workspace_(std::make_unique<Workspace>()) {}
ScanTrainer::~ScanTrainer() = default;

const TrainingSet& ScanTrainer::train(SelectedRays& selected, const TrainingRules& rules,
                                      const ScanFrame& frame, bool planar, double resolution_m,
                                      unsigned threads)
{
  Workspace& work = *workspace_;
  TrainingSet& set = work.set;
  set.masks.clear();
  set.hitPoints.clear();
  set.freePoints.clear();
  set.freeSegments.clear();
  work.rays.clear();
  work.rawHits.clear();
  work.bounds = {};
  for (SelectedFan& fan : selected.fans)
    work.collectFan(fan, rules, frame, planar, resolution_m, selected.counts);

  const BlockOffset offset(frame.anchor());
  work.openWindow(offset);
  work.markHits(rules, offset);
  const double step = rules.freeResolution / resolution_m;
  if (rules.freeSpace == FreeSpace::Samples)
  {
    if (rules.points == TrainingPoints::Cells)
      work.markFreeCells(step, offset, threads);
    else
      work.sampleFreePoints(step, rules.freeDownsampling / resolution_m, frame.anchor());
  }
  if (rules.freeSpace == FreeSpace::Line)
  {
    for (const TrainingRay& ray : work.rays)
    {
      if (ray.freeLength >= 0)
        set.freeSegments.push_back({ray.origin, ray.origin + ray.freeLength * ray.direction});
    }
  }
  for (BlockMasks& masks : set.masks)
  {
    const auto anyIn = [](const CellMask& mask)
    { return std::any_of(mask.begin(), mask.end(), [](uint64_t word) { return word != 0; }); };
    masks.anyHit = anyIn(masks.hit);
    masks.anyFree = anyIn(masks.free);
  }
  return set;
}

}  // namespace lamap
