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
  double length;
  double freeLength;  ///< < 0: the ray has no free part
  bool hasHit;        ///< at its end
  RayWidth width;     ///< [cells²]
  double weight = 1;  ///< of its free points, as a share; less than 1: it is silent
  double spread = 0;  ///< where it is as far from the others of its bundle as free points are; 0: it is alone

  /// Of a free point by itself, as a share: those of a bundle that are closer together count as one.
  [[nodiscard]] double weightAt(double distance, bool planar) const
  {
    if (!(distance < spread)) return weight;
    const double share = distance / spread;
    return weight * (planar ? share : share * share);
  }
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

/** Counts different blocks in 8 MiB: never more than there are, and up to ScanBlocks::kMaxBlocks 97 of 100.
 */
class BlockTally
{
 public:
  void add(const BlockIndex& block)
  {
    const size_t mark = BlockIndexHash{}(block) % kMarks;
    uint64_t& word = marks_[mark / 64];
    const uint64_t bit = uint64_t{1} << mark % 64;
    count_ += (word & bit) == 0;
    word |= bit;
  }
  [[nodiscard]] size_t count() const { return count_; }

 private:
  static constexpr size_t kMarks = 16 * ScanBlocks::kMaxBlocks;
  std::vector<uint64_t> marks_ = std::vector<uint64_t>(kMarks / 64);
  size_t count_ = 0;
};

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
    if (ray.weight < 1)
      markSharpSamples<&BlockMasks::silent>(FreeSamples(ray, rules), ray, rules);
    else if (ray.hasHit)
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

  template <CellMask BlockMasks::*kSharp>
  void markSharpSamples(const FreeSamples& samples, const TrainingRay& ray, const RulesInCells& rules)
  {
    const int64_t count = samples.count();
    const SampledRay sampled = samples.along(ray);
    for (int64_t from = 0; from < count; from += SampleCells::kMost)
    {
      const int some = static_cast<int>(std::min<int64_t>(SampleCells::kMost, count - from));
      cells_.find(sampled, from, some);
      for (int i = 0; i < some; ++i) mark<kSharp>(cells_.x(i), cells_.y(i), cells_.z(i));
    }
    if (!marksEnd(samples, ray, rules)) return;
    const CellIndex end = cellOfLocal(ray.origin + samples.last() * ray.direction);
    mark<kSharp>(end.x, end.y, end.z);
  }

  /// Samples from the sensor on may leave out the cell that a ray without a hit was seen to reach.
  [[nodiscard]] static bool marksEnd(const FreeSamples& samples, const TrainingRay& ray,
                                     const RulesInCells& rules)
  {
    return !ray.hasHit && !rules.fromEnd && samples.count() > 0;
  }

  template <CellMask BlockMasks::*kSharp, CellMask WideMasks::*kWide>
  void markSamples(const TrainingRay& ray, const RulesInCells& rules)
  {
    const FreeSamples samples(ray, rules);
    // Variances are convex along a ray: the widest sample is at an end.
    if (levels_.of(std::max(ray.width.constant, ray.width.variance(samples.last()))) == 0)
      return markSharpSamples<kSharp>(samples, ray, rules);
    const auto markAt = [&](double t)
    { markWide<kSharp, kWide>(ray.origin + t * ray.direction, ray.width.variance(t)); };
    for (int64_t i = 0; i < samples.count(); ++i) markAt(samples.at(i));
    if (marksEnd(samples, ray, rules)) markAt(samples.last());
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

/// Key of the cell, or of the voxel, in which hits are averaged.
uint64_t groupKey(const RulesInCells& rules, const Eigen::Vector3d& local, const CellIndex& anchor)
{
  return rules.asCells || rules.hitEdge == 0 ? cellKey(local) : voxelKey(local, rules.hitEdge, anchor);
}

/// A fan of a scan, and how it becomes training points.
struct PlacedFan
{
  PlacedFan(const Scan& scanOf, const RayFan& rays, const SamplingRules& by, const ScanFrame& in,
            const RayWidths& wide)
      : scan(scanOf),
        fan(rays),
        rules(by),
        inCells(by, in.resolution_m()),
        frame(in),
        widths(wide),
        cone(coneOf(scanOf, rays, by.beamWidth, in.planar())),
        origin(in.toLocal(scanOf.inMap(rays.centre)))
  {
  }

  const Scan& scan;
  const RayFan& fan;
  const SamplingRules& rules;
  RulesInCells inCells;
  const ScanFrame& frame;
  const RayWidths& widths;
  BeamCone cone;
  std::optional<Eigen::Vector3d> origin;  ///< [cells]; nothing: outside

  /// The end of a ray [cells]; nothing where it is outside. @param end as of a Ray
  [[nodiscard]] std::optional<Eigen::Vector3d> toLocal(const Eigen::Vector3d& end, bool isReturn) const
  {
    if (!origin) return std::nullopt;
    return isReturn ? frame.toLocal(scan.inMap(end)) : frame.endOfRay(*origin, scan.turnedToMap(end));
  }
  /// @return whether only the beam's axis was seen; else its echo may have come from anywhere on a cap
  [[nodiscard]] bool isNarrow(const Ray& ray) const
  {
    return !cone.isWide(fan.directionOf(ray), frame.resolution_m());
  }
  [[nodiscard]] bool isLaterEcho(const Ray& ray) const
  {
    return ray.echo > 0 && rules.beamWidth != BeamWidth::None;
  }
  /// @return false for one without a hit whose free space does not count
  [[nodiscard]] bool saysAnything(const Ray& ray) const
  {
    if (ray.meaning == RayEnd::Return) return true;
    const bool isSilenced = ray.meaning == RayEnd::NoReturn && rules.noEchoWeight == 0 && !isNarrow(ray);
    return !isLaterEcho(ray) && !isSilenced;
  }
  /// The ray to a place [cells]; nothing if it has no length. @param angle that its points are uncertain by
  [[nodiscard]] std::optional<TrainingRay> rayTo(const Eigen::Vector3d& end, double angle, bool hasHit) const;

  /// Between the places that a cap is sampled at: no cell of it is missed.
  static constexpr double kCapSpacing_cells = 0.5;
};

std::optional<TrainingRay> PlacedFan::rayTo(const Eigen::Vector3d& end, double angle, bool hasHit) const
{
  const Eigen::Vector3d ray = end - *origin;
  const double length = ray.norm();
  // A free point that is wide says something of its ray's hit.
  const double margin = hasHit ? std::max(inCells.margin, angle * length) : 0.0;
  if (!(length > 0)) return std::nullopt;
  const Eigen::Vector3d direction = ray / length;
  const RayWidth width = widths.any() ? widths.along(angle, direction, length) : RayWidth{};
  return TrainingRay{*origin, direction, length, length - margin, hasHit, width};
}

/// @return of the ray's end [cells]
double widthOfEnd(const std::optional<TrainingRay>& ray)
{
  return ray ? std::sqrt(std::max(0.0, ray->width.variance(ray->length) + ray->width.ofRange)) : 0.0;
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
  std::vector<Eigen::Vector3d> bundle;  ///< rays over a cone
  PointGroups capPoints;                ///< places that share the echoes of wide beams
  std::vector<CellIndex> capCells;      ///< cells that may hold what they came from
  std::vector<ThreadMarks> marks;
  CellBounds bounds;

  void clear();
  void collectFan(const PlacedFan& fan);
  void leaveOut(const Ray& ray);
  template <typename IsWanted>
  void findEnds(const PlacedFan& fan, const IsWanted& isWanted, size_t& used);
  void addHits(const PlacedFan& fan, bool areLater);
  void addBeam(const PlacedFan& fan, const Ray& ray, double angle);
  void shareEcho(const PlacedFan& fan, const Eigen::Vector3d& axis, double angle);
  template <typename Visit>
  void groupEnds(const RulesInCells& rules, const CellIndex& anchor, Visit&& visit);
  void markHits(const SamplingRules& rules, const RulesInCells& inCells);
  void markCaps(const RulesInCells& inCells);
  void requireFewBlocks(const RulesInCells& rules) const;
  void markFreeCells(const RulesInCells& rules, unsigned threads);
  void collectSurfaces(const Scan& scan, const RayFan& fan, const ScanFrame& frame);
  void keepSurfaces();
  void sampleFreePoints(const RulesInCells& rules, const ScanFrame& frame);
  void addSegments();
  void finishMasks();
  void openWindow();
};

void Sampler::Workspace::clear()
{
  set.masks.clear();
  for (auto& masks : set.wideMasks) masks.clear();
  set.hitPoints.clear();
  set.freePoints.clear();
  set.freeSegments.clear();
  rays.clear();
  rawHits.clear();
  surfaces.clear();
  capPoints.clear();
  capCells.clear();
  bounds = {};
}

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
  for (const End& end : ends) groups.add(groupKey(rules, end.place, anchor), end.place, end.angle);
  for (const PointGroup& group : groups.groups()) visit(group.first, group.mean(), group.narrowest);
}

/// Counts a ray whose free space is not wanted.
void Sampler::Workspace::leaveOut(const Ray& ray)
{
  --set.counts.freeOnly;
  ++set.counts.unbounded;
  if (ray.meaning != RayEnd::NoReturn) return;
  --set.counts.noReturn;
  set.counts.noReturnLength_m -= ray.end.norm();
}

/// Fills `ends` with the ends of a fan's narrow rays that are wanted; its wide ones become bundles.
template <typename IsWanted>
void Sampler::Workspace::findEnds(const PlacedFan& fan, const IsWanted& isWanted, size_t& used)
{
  ends.clear();
  for (size_t i = 0; i < fan.fan.rays.size(); ++i)
  {
    const Ray& ray = fan.fan.rays[i];
    if (!isWanted(ray)) continue;
    if (!fan.saysAnything(ray))
    {
      leaveOut(ray);
      continue;
    }
    const std::optional<Eigen::Vector3d> local = fan.toLocal(ray.end, ray.meaning == RayEnd::Return);
    if (!local || (fan.frame.planar() && *local == *fan.origin))
    {
      --used;
      ++(local ? set.counts.tooNear : set.counts.outside);
      continue;
    }
    bounds.extend(*local);
    const double angle = fan.widths.angleOf(i);
    if (fan.isNarrow(ray))
      ends.push_back({*local, angle});
    else
      addBeam(fan, ray, angle);
  }
}

/// @param areLater echoes than the first of their pulses: what they passed was no free space
void Sampler::Workspace::addHits(const PlacedFan& fan, bool areLater)
{
  const auto isWanted = [&](const Ray& ray)
  { return ray.meaning == RayEnd::Return && fan.isLaterEcho(ray) == areLater; };
  findEnds(fan, isWanted, set.counts.hits);
  const RulesInCells& inCells = fan.inCells;
  groupEnds(inCells, fan.frame.anchor(),
            [&](const Eigen::Vector3d& first, const Eigen::Vector3d& mean, double angle)
            {
              const auto ray = fan.rayTo(mean, angle, true);
              set.hitPoints.push_back({inCells.asCells ? first : mean, widthOfEnd(ray)});
              if (ray && !areLater) rays.push_back(*ray);
            });
  if (inCells.asCells)
  {
    for (const PointGroup& group : groups.groups()) rawHits.add(cellKey(group.first), group);
  }
  else
  {
    for (const End& end : ends) rawHits.add(cellKey(end.place), end.place, 0);
  }
}

void Sampler::Workspace::collectFan(const PlacedFan& fan)
{
  if (fan.origin) bounds.extend(*fan.origin);
  addHits(fan, false);
  if (fan.rules.beamWidth != BeamWidth::None) addHits(fan, true);
  findEnds(
      fan, [](const Ray& ray) { return ray.meaning != RayEnd::Return; }, set.counts.freeOnly);
  groupEnds(fan.inCells, fan.frame.anchor(),
            [&](const Eigen::Vector3d&, const Eigen::Vector3d& mean, double angle)
            {
              if (const auto ray = fan.rayTo(mean, angle, false)) rays.push_back(*ray);
            });
}

/// Adds what a wide beam says: nothing is in its cone before its first echo, which came from somewhere on the
/// cone's cap. @param angle that its points are uncertain by
void Sampler::Workspace::addBeam(const PlacedFan& fan, const Ray& ray, double angle)
{
  const Eigen::Vector3d axis = fan.fan.directionOf(ray);
  const bool isReturn = ray.meaning == RayEnd::Return;
  if (isReturn) shareEcho(fan, axis, angle);
  if (fan.isLaterEcho(ray)) return;
  const double spacing = std::max(1.0, fan.inCells.step) * fan.frame.resolution_m();
  fan.cone.spread(axis, spacing, bundle);
  for (const Eigen::Vector3d& each : bundle)
  {
    const auto end = fan.toLocal(isReturn ? Eigen::Vector3d(fan.fan.centre + each) : each, isReturn);
    const auto freeRay = end ? fan.rayTo(*end, angle, isReturn) : std::nullopt;
    if (!freeRay) continue;
    bounds.extend(*end);
    rays.push_back(*freeRay);
    rays.back().spread = freeRay->length;
    if (ray.meaning == RayEnd::NoReturn) rays.back().weight = fan.rules.noEchoWeight;
  }
}

/// Spreads an echo evenly over the cells (or voxels) of the cap.
void Sampler::Workspace::shareEcho(const PlacedFan& fan, const Eigen::Vector3d& axis, double angle)
{
  const double cell_m = fan.frame.resolution_m();
  fan.cone.spread(axis, PlacedFan::kCapSpacing_cells * cell_m, bundle);
  groups.clear();
  for (const Eigen::Vector3d& each : bundle)
  {
    const auto end = fan.toLocal(fan.fan.centre + each, true);
    if (!end) continue;
    bounds.extend(*end);
    groups.add(groupKey(fan.inCells, *end, fan.frame.anchor()), *end,
               widthOfEnd(fan.rayTo(*end, angle, true)));
    const CellIndex cell = cellOfLocal(*end);
    if (capCells.empty() || !(capCells.back() == cell)) capCells.push_back(cell);
  }
  const double weight = std::min(fan.rules.echoWeight, std::max(1.0, fan.cone.footprint(axis, cell_m)));
  for (PointGroup group : groups.groups())
  {
    group.weight = weight / static_cast<double>(groups.groups().size());
    capPoints.add(groupKey(fan.inCells, group.first, fan.frame.anchor()), group);
  }
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

/// Adds the shares of echoes as hits: in a cell, or voxel, at most one. No cell of a cap is free.
void Sampler::Workspace::markCaps(const RulesInCells& inCells)
{
  for (const PointGroup& group : capPoints.groups())
  {
    const Eigen::Vector3d centre = group.first.array().floor() + 0.5;
    set.hitPoints.push_back(
        {inCells.asCells ? centre : group.mean(), group.narrowest, std::min(1.0, group.weight)});
  }
  MaskMarker marker({set.blocks, set.masks, set.wideMasks}, set.offset, inCells.widthUnit);
  for (const CellIndex& cell : capCells)
  {
    marker.mark<&BlockMasks::protectedHit>(cell.x, cell.y, cell.z);
    set.removeFree(cell);
  }
}

/** Refuses a scan whose rays are too long for its cells before masks of its blocks are made, which would take
 * gigabytes by then. Counts blocks that free samples are in: of every 64th ray, then of the next ones, and so
 * on, until there are too many, or not as many new ones as could become too many. ScanBlocks counts the rest
 * exactly. */
void Sampler::Workspace::requireFewBlocks(const RulesInCells& rules) const
{
  constexpr auto kMost = static_cast<double>(ScanBlocks::kMaxBlocks);
  const BlockIndex& low = set.blocks.low();
  const BlockIndex& high = set.blocks.high();
  const auto extent = [](int32_t from, int32_t to) { return static_cast<double>(to) - from + 1; };
  if (extent(low.x, high.x) * extent(low.y, high.y) * extent(low.z, high.z) <= kMost) return;
  // Of a ray's samples, about one in each block.
  const auto every = static_cast<int64_t>(std::max(1.0, std::floor(kScanBlockEdge / rules.step)));
  double samples = 0;
  for (const TrainingRay& ray : rays)
    samples += std::ceil(static_cast<double>(FreeSamples(ray, rules).count()) / static_cast<double>(every));
  if (samples <= kMost) return;

  BlockTally found;
  constexpr size_t kPasses = 64;
  for (size_t pass = 0; pass < kPasses; ++pass)
  {
    const size_t before = found.count();
    for (size_t i = pass; i < rays.size(); i += kPasses)
    {
      const FreeSamples along(rays[i], rules);
      for (int64_t sample = 0; sample < along.count(); sample += every)
        found.add(blockOfLocal(rays[i].origin + along.at(sample) * rays[i].direction, set.offset));
      if (found.count() > ScanBlocks::kMaxBlocks) ScanBlocks::refuse();
    }
    const size_t left = kPasses - 1 - pass;
    if (found.count() + (found.count() - before) * left <= ScanBlocks::kMaxBlocks) return;
  }
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
      if (i < own.masks.size())
      {
        unite(set.masks, number, own.masks[i]);
        for (size_t z = 0; z < kScanBlockEdge; ++z) set.masks[number].silent[z] |= own.masks[i].silent[z];
      }
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

void Sampler::Workspace::sampleFreePoints(const RulesInCells& rules, const ScanFrame& frame)
{
  const bool planar = frame.planar();
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
      if (rules.freeEdge > 0 && ray.spread == 0)
        groups.add(voxelKey(point, rules.freeEdge, frame.anchor()), point, width);
      else
      {
        const double weight = ray.weightAt(samples.at(i), planar);
        if (weight > 0) set.freePoints.push_back({point, width, weight});
      }
    }
  }
  for (const PointGroup& group : groups.groups()) set.freePoints.push_back({group.mean(), group.narrowest});
}

void Sampler::Workspace::addSegments()
{
  for (const TrainingRay& ray : rays)
    if (ray.freeLength >= 0)
      set.freeSegments.push_back(
          {ray.origin, ray.origin + ray.freeLength * ray.direction, ray.width, ray.weight, ray.hasHit});
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
    for (size_t z = 0; z < kScanBlockEdge; ++z) sharp.silent[z] &= ~(sharp.ended[z] | sharp.free[z]);
    sharp.anySilent = anyIn(sharp.silent);
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
  work.clear();
  TrainingSet& set = work.set;
  set.counts = selected.counts;
  set.offset = offset;
  set.hitWeight = rules.hitWeight;
  set.freeWeight = rules.freeWeight;
  set.silentWeight = rules.noEchoWeight;
  const RulesInCells inCells(rules, frame.resolution_m());
  set.widthUnit = inCells.widthUnit;
  const bool areSampled = rules.freeWeight > 0 && rules.freeSpace == FreeSpace::Samples;
  const bool keepsSurfaces = rules.keepGlancingSurfaces && areSampled && inCells.asCells;
  RayWidths widths(selected.scan, rules, frame);
  for (const RayFan& fan : selected.scan.fans)
  {
    widths.enterFan(fan);
    work.collectFan({selected.scan, fan, rules, frame, widths});
    if (keepsSurfaces) work.collectSurfaces(selected.scan, fan, frame);
  }

  work.openWindow();
  if (areSampled && inCells.asCells) work.requireFewBlocks(inCells);
  work.markHits(rules, inCells);
  if (areSampled && inCells.asCells) work.markFreeCells(inCells, threads);
  if (areSampled && !inCells.asCells) work.sampleFreePoints(inCells, frame);
  work.keepSurfaces();
  work.markCaps(inCells);
  if (rules.freeWeight > 0 && rules.freeSpace == FreeSpace::Line) work.addSegments();
  work.finishMasks();
  return set;
}

}  // namespace lamap
