#include <lamap_core/scan/glancing_surfaces.h>
#include <lamap_core/training/point_groups.h>
#include <lamap_core/training/ray_widths.h>
#include <lamap_core/training/sample_cells.h>
#include <lamap_core/training/sampler.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

namespace lamap
{
namespace
{
/// The rules' lengths in cells.
struct RulesInCells
{
  RulesInCells(const SamplingRules& rules, double resolution_m)
      : step(rules.freeResolution / resolution_m),
        margin(rules.freeMargin / resolution_m),
        sensorMargin(rules.sensorMargin / resolution_m),
        hitEdge(rules.hitDownsampling / resolution_m),
        freeEdge(rules.freeDownsampling / resolution_m),
        widthUnit(rules.widthUnit / resolution_m),
        fromEnd(rules.samplesFrom == SamplesFrom::End),
        asCells(rules.points == TrainingPoints::Cells)
  {
  }
  double step, margin, sensorMargin, hitEdge, freeEdge, widthUnit;
  bool fromEnd, asCells;
};

/// A ray in the scan's frame [cells]; free from the origin as far as freeLength.
struct TrainingRay
{
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;  ///< of length 1
  double freeLength;          ///< < 0: the ray has no free part
  bool hasHit;                ///< at its end
  RayWidth width;             ///< [cells²]
};

constexpr double kOnEnd_cells = 1e-6;

/** Distances of a ray's free samples from its origin [cells].
 *
 * Counted from the sensor, a sample within a millionth of a cell of the end stands on the end. Ranges are
 * often whole steps (a maximum range, a simulated wall): without this, rounding would decide for each ray and
 * each place on the map whether it has its last sample. For the same reason a sample at the end of a ray
 * without a hit stands that much before it: a cell that begins at the maximum range is not seen. */
class FreeSamples
{
 public:
  FreeSamples(const TrainingRay& ray, const RulesInCells& rules)
      : length_(std::max(ray.freeLength, 0.0)),
        last_(ray.hasHit || !rules.asCells ? length_ : length_ - kOnEnd_cells)
  {
    const double slack = rules.fromEnd ? 0.0 : kOnEnd_cells;
    const double stretch = length_ - rules.sensorMargin + slack;
    if (ray.freeLength < -slack || stretch < 0) return;
    count_ = static_cast<int64_t>(stretch / rules.step) + 1;
    first_ = rules.fromEnd ? length_ : rules.sensorMargin;
    step_ = rules.fromEnd ? -rules.step : rules.step;
  }
  [[nodiscard]] int64_t count() const { return count_; }
  [[nodiscard]] double last() const { return std::max(0.0, last_); }
  [[nodiscard]] SampledRay along(const TrainingRay& ray) const
  {
    return {ray.origin, ray.direction, first_, step_, last_};
  }
  [[nodiscard]] double at(int64_t i) const
  {
    return std::max(0.0, std::min(first_ + static_cast<double>(i) * step_, last_));
  }

 private:
  double length_;
  double last_;
  int64_t count_ = 0;
  double first_ = 0;
  double step_ = 0;
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

/// Marks of some rays of a scan.
struct Marks
{
  ScanBlocks& blocks;
  std::vector<BlockMasks>& masks;
  std::array<std::vector<WideMasks>, kWideLevels>& wideMasks;
};

/// Marks cells in the masks of the blocks that hold them; the last block is remembered, for rays walk on.
class MaskMarker
{
 public:
  MaskMarker(const Marks& marks, const BlockOffset& offset, double widthUnit)
      : marks_(marks), offset_(offset), levels_(widthUnit)
  {
  }

  template <CellMask BlockMasks::*kMask>
  void mark(int32_t localX, int32_t localY, int32_t localZ)
  {
    const uint64_t bit = find(localX, localY, localZ);
    (sharp_->*kMask)[layer_] |= bit;
  }

  /// @param variance of the point there [cells²]
  template <CellMask BlockMasks::*kSharp, CellMask WideMasks::*kWide>
  void markWide(const Eigen::Vector3d& point, double variance)
  {
    const uint64_t bit = find(localCell(point.x()), localCell(point.y()), localCell(point.z()));
    level_ = levels_.of(variance, level_);
    if (level_ == 0)
      (sharp_->*kSharp)[layer_] |= bit;
    else
      (maskOf(marks_.wideMasks[level_ - 1]).*kWide)[layer_] |= bit;
  }

  /// Marks the cells of the ray's free samples.
  void markFreeSamples(const TrainingRay& ray, const RulesInCells& rules)
  {
    if (ray.hasHit)
      markSamples<&BlockMasks::free, &WideMasks::free>(ray, rules);
    else
      markSamples<&BlockMasks::freeWithoutHit, &WideMasks::freeWithoutHit>(ray, rules);
  }

 private:
  /// Finds the cell's block and layer. @return its bit there.
  [[nodiscard]] uint64_t find(int32_t localX, int32_t localY, int32_t localZ)
  {
    const int32_t x = localX + offset_.x;
    const int32_t y = localY + offset_.y;
    const int32_t z = localZ + offset_.z;
    const BlockIndex block{x >> kScanBlockLog2Edge, y >> kScanBlockLog2Edge, z >> kScanBlockLog2Edge};
    if (number_ < 0 || !(block == last_))
    {
      number_ = marks_.blocks.findOrAdd(block);
      last_ = block;
      sharp_ = &maskOf(marks_.masks);
    }
    constexpr int32_t kLow = kScanBlockEdge - 1;
    layer_ = static_cast<size_t>(z & kLow);
    return uint64_t{1} << ((y & kLow) * kScanBlockEdge + (x & kLow));
  }
  template <typename Masks>
  [[nodiscard]] Masks& maskOf(std::vector<Masks>& masks)
  {
    if (static_cast<size_t>(number_) >= masks.size()) masks.resize(static_cast<size_t>(number_) + 1);
    return masks[static_cast<size_t>(number_)];
  }

  template <CellMask BlockMasks::*kSharp, CellMask WideMasks::*kWide>
  void markSamples(const TrainingRay& ray, const RulesInCells& rules)
  {
    const FreeSamples samples(ray, rules);
    const int64_t count = samples.count();
    // Samples from the sensor on may leave out the cell that the ray was seen to reach.
    const bool marksEnd = !ray.hasHit && !rules.fromEnd && count > 0;
    // Variances are convex along a ray: the widest sample is at an end.
    if (levels_.of(std::max(ray.width.constant, ray.width.variance(samples.last()))) > 0)
    {
      const auto markAt = [&](double t)
      { markWide<kSharp, kWide>(ray.origin + t * ray.direction, ray.width.variance(t)); };
      for (int64_t i = 0; i < count; ++i) markAt(samples.at(i));
      if (marksEnd) markAt(samples.last());
      return;
    }
    const SampledRay sampled = samples.along(ray);
    for (int64_t from = 0; from < count; from += SampleCells::kMost)
    {
      const int some = static_cast<int>(std::min<int64_t>(SampleCells::kMost, count - from));
      cells_.find(sampled, from, some);
      for (int i = 0; i < some; ++i) mark<kSharp>(cells_.x(i), cells_.y(i), cells_.z(i));
    }
    if (!marksEnd) return;
    const CellIndex end = cellOfLocal(ray.origin + samples.last() * ray.direction);
    mark<kSharp>(end.x, end.y, end.z);
  }

  Marks marks_;
  BlockOffset offset_;
  WidthLevels levels_;
  SampleCells cells_;
  size_t level_ = 0;  ///< of the last wide sample, for rays walk on
  BlockIndex last_;
  int32_t number_ = -1;
  BlockMasks* sharp_ = nullptr;  ///< of that block; masks are added by find() alone
  size_t layer_ = 0;
};

/// Key of the voxel that a point is in. Voxels are counted from the map's origin, not from the anchor.
uint64_t voxelKey(const Eigen::Vector3d& local, double edge, const CellIndex& anchor)
{
  if (edge == 1.0) return cellKey(local);
  const auto voxel = [&](double coordinate, int32_t anchorCell)
  {
    const double first = std::floor(anchorCell / edge);
    return static_cast<int64_t>(std::floor((anchorCell + coordinate) / edge) - first);
  };
  return packKey(voxel(local.x(), anchor.x), voxel(local.y(), anchor.y), voxel(local.z(), anchor.z));
}

}  // namespace

struct Sampler::Workspace
{
  /// Free cells marked by one of several threads.
  struct ThreadMarks
  {
    ScanBlocks blocks;
    std::vector<BlockMasks> masks;
    std::array<std::vector<WideMasks>, kWideLevels> wideMasks;
  };
  struct End
  {
    Eigen::Vector3d place;
    double angle;  ///< that the ray is uncertain by
  };

  /// A piece of surface in the scan's frame [cells].
  struct Piece
  {
    Eigen::Vector3d begin;
    Eigen::Vector3d end;
  };

  TrainingSet set;
  std::vector<TrainingRay> rays;
  GlancingSurfaces glancing;
  std::vector<Piece> surfaces;
  std::vector<End> ends;  ///< of one fan's rays, with a hit or without
  PointGroups groups;
  PointGroups rawHits;
  std::vector<ThreadMarks> marks;
  CellBounds bounds;

  void collectFan(const Scan& scan, const RayFan& fan, const SamplingRules& rules, const ScanFrame& frame,
                  RayWidths& widths);
  template <typename Visit>
  void groupEnds(const RulesInCells& rules, const CellIndex& anchor, Visit&& visit);
  void markHits(const SamplingRules& rules, const RulesInCells& inCells);
  void markFreeCells(const RulesInCells& rules, unsigned threads);
  void collectSurfaces(const Scan& scan, const RayFan& fan, const ScanFrame& frame);
  void keepSurfaces();
  void sampleFreePoints(const RulesInCells& rules, const CellIndex& anchor);
  void addSegments();
  void finishMasks();
  void openWindow();
};

/// Calls visit(first, mean, angle) for each group of `ends`.
template <typename Visit>
void Sampler::Workspace::groupEnds(const RulesInCells& rules, const CellIndex& anchor, Visit&& visit)
{
  groups.clear();
  if (!rules.asCells && rules.hitEdge == 0)
  {
    for (const End& end : ends) visit(end.place, end.place, end.angle);
    return;
  }
  for (const End& end : ends)
    groups.add(rules.asCells ? cellKey(end.place) : voxelKey(end.place, rules.hitEdge, anchor), end.place,
               end.angle);
  for (const PointGroup& group : groups.groups()) visit(group.first, group.mean(), group.narrowest);
}

void Sampler::Workspace::collectFan(const Scan& scan, const RayFan& fan, const SamplingRules& rules,
                                    const ScanFrame& frame, RayWidths& widths)
{
  widths.enterFan(fan);
  RayCounts& counts = set.counts;
  const RulesInCells inCells(rules, frame.resolution_m());
  const auto origin = frame.toLocal(scan.inMap(fan.centre));
  const auto findEnds = [&](bool ofHits, size_t& used, auto&& toLocal)
  {
    ends.clear();
    for (size_t i = 0; i < fan.rays.size(); ++i)
    {
      const Ray& ray = fan.rays[i];
      if ((ray.meaning == RayEnd::Return) != ofHits) continue;
      const std::optional<Eigen::Vector3d> local = origin ? toLocal(ray.end) : std::nullopt;
      if (!local || (frame.planar() && *local == *origin))
      {
        --used;
        ++(local ? counts.tooNear : counts.outside);
        continue;
      }
      bounds.extend(*local);
      ends.push_back({*local, widths.angleOf(i)});
    }
  };
  /// @return the width of the ray's end [cells]
  const auto addRay = [&](const Eigen::Vector3d& end, double angle, bool hasHit)
  {
    const Eigen::Vector3d ray = end - *origin;
    const double length = ray.norm();
    // A free point that is wide says something of its ray's hit.
    const double margin = hasHit ? std::max(inCells.margin, angle * length) : 0.0;
    if (!(length > 0)) return 0.0;
    const Eigen::Vector3d direction = ray / length;
    const RayWidth width = widths.any() ? widths.along(angle, direction) : RayWidth{};
    rays.push_back({*origin, direction, length - margin, hasHit, width});
    return std::sqrt(std::max(0.0, width.variance(length) + width.ofRange));
  };

  if (origin) bounds.extend(*origin);
  findEnds(true, counts.hits, [&](const Eigen::Vector3d& end) { return frame.toLocal(scan.inMap(end)); });
  groupEnds(inCells, frame.anchor(),
            [&](const Eigen::Vector3d& first, const Eigen::Vector3d& mean, double angle) {
              set.hitPoints.push_back({inCells.asCells ? first : mean, addRay(mean, angle, true)});
            });
  if (inCells.asCells)
  {
    for (const PointGroup& group : groups.groups()) rawHits.add(cellKey(group.first), group);
  }
  else
  {
    for (const End& end : ends) rawHits.add(cellKey(end.place), end.place, 0);
  }

  findEnds(false, counts.freeOnly,
           [&](const Eigen::Vector3d& ray) { return frame.endOfRay(*origin, scan.turnedToMap(ray)); });
  groupEnds(inCells, frame.anchor(),
            [&](const Eigen::Vector3d&, const Eigen::Vector3d& mean, double angle)
            { addRay(mean, angle, false); });
}

void Sampler::Workspace::openWindow()
{
  if (bounds.low.x() > bounds.high.x()) bounds.extend(Eigen::Vector3d::Zero());
  // A sample may round across the face of its ray's last cell.
  bounds.low.array() -= 1.0;
  bounds.high.array() += 1.0;
  set.blocks.reset(blockOfLocal(bounds.low, set.offset), blockOfLocal(bounds.high, set.offset));
}

void Sampler::Workspace::markHits(const SamplingRules& rules, const RulesInCells& inCells)
{
  MaskMarker marker({set.blocks, set.masks, set.wideMasks}, set.offset, inCells.widthUnit);
  for (const PointGroup& group : rawHits.groups())
  {
    const CellIndex cell = cellOfLocal(group.first);
    marker.mark<&BlockMasks::ended>(cell.x, cell.y, cell.z);
    if (rules.protectHits > 0 && group.count >= rules.protectHits)
      marker.mark<&BlockMasks::protectedHit>(cell.x, cell.y, cell.z);
  }
  if (!inCells.asCells) return;
  for (const PlacedPoint& hit : set.hitPoints)
    marker.markWide<&BlockMasks::hit, &WideMasks::hit>(hit.place, hit.width * hit.width);
  set.hitPoints.clear();
}

void Sampler::Workspace::markFreeCells(const RulesInCells& rules, unsigned threads)
{
  constexpr size_t kRaysWorthAThread = 256;
  const size_t workers = std::min<size_t>(threads, rays.size() / kRaysWorthAThread + 1);
  const auto markRange = [&](const Marks& into, size_t begin, size_t end)
  {
    MaskMarker marker(into, set.offset, rules.widthUnit);
    for (size_t i = begin; i < end; ++i) marker.markFreeSamples(rays[i], rules);
  };
  if (workers == 1) return markRange({set.blocks, set.masks, set.wideMasks}, 0, rays.size());

  if (marks.size() < workers) marks.resize(workers);
  tbb::parallel_for(size_t{0}, workers,
                    [&](size_t worker)
                    {
                      ThreadMarks& own = marks[worker];
                      own.blocks.reset(blockOfLocal(bounds.low, set.offset),
                                       blockOfLocal(bounds.high, set.offset));
                      own.masks.clear();
                      for (auto& masks : own.wideMasks) masks.clear();
                      markRange({own.blocks, own.masks, own.wideMasks}, rays.size() * worker / workers,
                                rays.size() * (worker + 1) / workers);
                    });
  const auto unite = [](auto& masks, size_t number, const auto& other)
  {
    if (number >= masks.size()) masks.resize(number + 1);
    for (size_t z = 0; z < kScanBlockEdge; ++z)
    {
      masks[number].free[z] |= other.free[z];
      masks[number].freeWithoutHit[z] |= other.freeWithoutHit[z];
    }
  };
  for (size_t worker = 0; worker < workers; ++worker)
  {
    const ThreadMarks& own = marks[worker];
    for (size_t i = 0; i < own.blocks.blocks().size(); ++i)
    {
      const auto number = static_cast<size_t>(set.blocks.findOrAdd(own.blocks.blocks()[i]));
      if (i < own.masks.size()) unite(set.masks, number, own.masks[i]);
      for (size_t level = 0; level < kWideLevels; ++level)
        if (i < own.wideMasks[level].size()) unite(set.wideMasks[level], number, own.wideMasks[level][i]);
    }
  }
}

void Sampler::Workspace::collectSurfaces(const Scan& scan, const RayFan& fan, const ScanFrame& frame)
{
  const double shortest_m = frame.resolution_m() / 2;
  for (const GlancingSurfaces::Piece& piece : glancing.of(fan))
  {
    if ((piece.end - piece.begin).squaredNorm() < shortest_m * shortest_m) continue;
    const auto begin = frame.toLocal(scan.inMap(piece.begin));
    const auto end = frame.toLocal(scan.inMap(piece.end));
    if (begin && end) surfaces.push_back({*begin, *end});
  }
}

/// Free cells through which a surface passes are not free.
void Sampler::Workspace::keepSurfaces()
{
  for (const Piece& piece : surfaces)
  {
    const Eigen::Vector3d along = piece.end - piece.begin;
    const int count = static_cast<int>(2 * along.norm()) + 1;  // every half a cell or less
    std::optional<CellIndex> last;
    for (int i = 1; i < count; ++i)
    {
      const CellIndex cell = cellOfLocal(piece.begin + along * (static_cast<double>(i) / count));
      if (last && cell == *last) continue;
      set.removeFree(cell);
      last = cell;
    }
  }
}

void Sampler::Workspace::sampleFreePoints(const RulesInCells& rules, const CellIndex& anchor)
{
  double expected = 0;
  for (const TrainingRay& ray : rays) expected += static_cast<double>(FreeSamples(ray, rules).count());
  constexpr double kMaxPoints = 5e7;
  if (expected > kMaxPoints)
    throw std::length_error(
        "a scan has more than 50 million training points: set maxRange, or a larger freeResolution");

  groups.clear();
  for (const TrainingRay& ray : rays)
  {
    const FreeSamples samples(ray, rules);
    for (int64_t i = 0; i < samples.count(); ++i)
    {
      const Eigen::Vector3d point = ray.origin + samples.at(i) * ray.direction;
      if (!ray.hasHit && set.isIn(&BlockMasks::ended, cellOfLocal(point))) continue;
      const double width = std::sqrt(std::max(0.0, ray.width.variance(samples.at(i))));
      if (rules.freeEdge > 0)
        groups.add(voxelKey(point, rules.freeEdge, anchor), point, width);
      else
        set.freePoints.push_back({point, width});
    }
  }
  for (const PointGroup& group : groups.groups()) set.freePoints.push_back({group.mean(), group.narrowest});
}

void Sampler::Workspace::addSegments()
{
  for (const TrainingRay& ray : rays)
    if (ray.freeLength >= 0)
      set.freeSegments.push_back(
          {ray.origin, ray.origin + ray.freeLength * ray.direction, ray.width, ray.hasHit});
}

/// Cells count once, where they are sharpest; those of rays without a hit, where no ray of the scan ended.
void Sampler::Workspace::finishMasks()
{
  const auto anyIn = [](const CellMask& mask)
  { return std::any_of(mask.begin(), mask.end(), [](uint64_t word) { return word != 0; }); };
  set.masks.resize(set.blocks.blocks().size());
  for (size_t number = 0; number < set.masks.size(); ++number)
  {
    BlockMasks& sharp = set.masks[number];
    for (size_t z = 0; z < kScanBlockEdge; ++z) sharp.free[z] |= sharp.freeWithoutHit[z] & ~sharp.ended[z];
    sharp.anyHit = anyIn(sharp.hit);
    sharp.anyFree = anyIn(sharp.free);
    CellMask hit = sharp.hit;
    CellMask free = sharp.free;
    for (std::vector<WideMasks>& level : set.wideMasks)
    {
      if (number >= level.size()) continue;
      WideMasks& wide = level[number];
      for (size_t z = 0; z < kScanBlockEdge; ++z)
      {
        wide.hit[z] &= ~hit[z];
        wide.free[z] = (wide.free[z] | (wide.freeWithoutHit[z] & ~sharp.ended[z])) & ~free[z];
        hit[z] |= wide.hit[z];
        free[z] |= wide.free[z];
      }
      wide.anyHit = anyIn(wide.hit);
      wide.anyFree = anyIn(wide.free);
    }
  }
}

Sampler::Sampler() : workspace_(std::make_unique<Workspace>()) {}
Sampler::~Sampler() = default;

const TrainingSet& Sampler::sample(const SelectedRays& selected, const SamplingRules& rules,
                                   const ScanFrame& frame, const BlockOffset& offset, unsigned threads)
{
  Workspace& work = *workspace_;
  TrainingSet& set = work.set;
  set.counts = selected.counts;
  set.offset = offset;
  set.hitWeight = rules.hitWeight;
  set.freeWeight = rules.freeWeight;
  const RulesInCells inCells(rules, frame.resolution_m());
  set.widthUnit = inCells.widthUnit;
  set.masks.clear();
  for (auto& masks : set.wideMasks) masks.clear();
  set.hitPoints.clear();
  set.freePoints.clear();
  set.freeSegments.clear();
  work.rays.clear();
  work.rawHits.clear();
  work.surfaces.clear();
  work.bounds = {};
  const bool areSampled = rules.freeWeight > 0 && rules.freeSpace == FreeSpace::Samples;
  const bool keepsSurfaces = rules.keepGlancingSurfaces && areSampled && inCells.asCells;
  RayWidths widths(selected.scan, rules, frame);
  for (const RayFan& fan : selected.scan.fans)
  {
    work.collectFan(selected.scan, fan, rules, frame, widths);
    if (keepsSurfaces) work.collectSurfaces(selected.scan, fan, frame);
  }

  work.openWindow();
  work.markHits(rules, inCells);
  if (areSampled && inCells.asCells) work.markFreeCells(inCells, threads);
  if (areSampled && !inCells.asCells) work.sampleFreePoints(inCells, frame.anchor());
  work.keepSurfaces();
  if (rules.freeWeight > 0 && rules.freeSpace == FreeSpace::Line) work.addSegments();
  work.finishMasks();
  return set;
}

}  // namespace lamap
