#include <lamap_core/scan/glancing_surfaces.h>
#include <lamap_core/scan/open_space.h>
#include <lamap_core/scan/ray_selection.h>
#include <support/bgk_oracle.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <sstream>

namespace lamap::test
{
namespace
{
constexpr double kPi = 3.14159265358979323846;
/// Distances this close to the support, relative to it, are undecided.
constexpr double kBorder = 1e-9;

int64_t floorDivided(double coordinate, double edge)
{
  return static_cast<int64_t>(std::floor(coordinate / edge));
}

Cell voxelOf(const Eigen::Vector3d& point, double edge)
{
  return {floorDivided(point.x(), edge), floorDivided(point.y(), edge), floorDivided(point.z(), edge)};
}

bool addressable(const Eigen::Vector3d& point, double resolution)
{
  return cellAt(point, resolution).has_value();
}

Eigen::Vector3d meanOf(const std::vector<Eigen::Vector3d>& points)
{
  long double x = 0, y = 0, z = 0;
  for (const Eigen::Vector3d& point : points)
  {
    x += point.x();
    y += point.y();
    z += point.z();
  }
  const auto n = static_cast<long double>(points.size());
  return {static_cast<double>(x / n), static_cast<double>(y / n), static_cast<double>(z / n)};
}

/// The mean of the points of each voxel; every point by itself for an edge of 0.
std::vector<Eigen::Vector3d> voxelMeans(const std::vector<Eigen::Vector3d>& points, double edge)
{
  if (edge == 0) return points;
  std::map<Cell, std::vector<Eigen::Vector3d>> voxels;
  for (const Eigen::Vector3d& point : points) voxels[voxelOf(point, edge)].push_back(point);
  std::vector<Eigen::Vector3d> means;
  for (const auto& voxel : voxels) means.push_back(meanOf(voxel.second));
  return means;
}

struct OracleFan
{
  Eigen::Vector3d origin;
  std::vector<Eigen::Vector3d> hits;
  std::vector<Eigen::Vector3d> freeEnds;
};

class Selection
{
 public:
  Selection(const Scan& scan, double resolution, const BgkInference& inference)
      : resolution_(resolution), inference_(inference)
  {
    for (const RayFan& fan : scan.fans) select(scan, fan);
  }

  std::vector<OracleFan> fans;
  RayCounts counts;

 private:
  void select(const Scan& scan, const RayFan& fan)
  {
    const Eigen::Matrix3d turn = scan.sensorPose_map.linear();
    const Eigen::Vector3d sensor = scan.sensorPose_map.translation();
    const Eigen::Vector3d origin = turn * fan.centre + sensor;
    fans.push_back({origin, {}, {}});
    const double nearest = std::max(inference_.minRange, fan.statedRangeMin_m);
    double farthest = inference_.maxRange;
    if (farthest == 0 || (fan.statedRangeMax_m > 0 && fan.statedRangeMax_m < farthest))
      farthest = fan.statedRangeMax_m;
    OpenSpace openSpace(fan, nearest);
    for (const Ray& given : fan.rays)
    {
      if (isDecimated()) continue;
      if (given.meaning == RayEnd::NoReturn)
      {
        const bool isRay = given.end.allFinite() && !given.end.isZero(0);
        const double reach = isRay ? openSpace.reach_m(given.end) : 0;
        const bool isBounded = std::isfinite(reach) && (farthest == 0 || reach < farthest);
        selectWithoutReturn(turn * given.end, origin, isBounded ? reach : farthest);
        continue;
      }
      const Eigen::Vector3d end = turn * given.end + sensor;
      if (!end.allFinite() || !origin.allFinite())
      {
        ++counts.notFinite;
        continue;
      }
      const Eigen::Vector3d ray = end - origin;
      const double range = std::hypot(ray.x(), ray.y(), ray.z());
      if (range == 0 || range < nearest)
        ++counts.tooNear;
      else if (farthest > 0 && range > farthest)
        keepFree(origin + ray / range * farthest);
      else if (!addressable(end, resolution_))
        ++counts.outside;
      else
      {
        ++counts.hits;
        fans.back().hits.push_back(end);
      }
    }
  }

  void selectWithoutReturn(const Eigen::Vector3d& direction, const Eigen::Vector3d& origin, double farthest)
  {
    const double length = std::hypot(direction.x(), direction.y(), direction.z());
    if (!direction.allFinite() || !origin.allFinite())
      ++counts.notFinite;
    else if (length == 0)
      ++counts.tooNear;
    else if (!inference_.considerInvalidRangesAsFreeSpace || inference_.freeSpace == FreeSpace::None ||
             !(farthest > 0))
      ++counts.unbounded;
    else
      keepFree(origin + direction / length * farthest);
  }

  bool isDecimated()
  {
    const bool decimated = index_++ % inference_.rayDecimation != 0;
    if (decimated) ++counts.decimated;
    return decimated;
  }

  void keepFree(const Eigen::Vector3d& end)
  {
    if (!addressable(end, resolution_))
    {
      ++counts.outside;
      return;
    }
    ++counts.freeOnly;
    fans.back().freeEnds.push_back(end);
  }

  double resolution_;
  const BgkInference& inference_;
  size_t index_ = 0;
};

/// Puts a fan into the layer; rays that have no length there are left out.
void flatten(OracleFan& fan, double height, RayCounts& counts)
{
  const auto flattenEnds = [&](std::vector<Eigen::Vector3d>& ends, size_t& used)
  {
    std::vector<Eigen::Vector3d> kept;
    for (Eigen::Vector3d end : ends)
    {
      if (end.x() == fan.origin.x() && end.y() == fan.origin.y())
      {
        --used;
        ++counts.tooNear;
        continue;
      }
      end.z() = height;
      kept.push_back(end);
    }
    ends = kept;
  };
  flattenEnds(fan.hits, counts.hits);
  flattenEnds(fan.freeEnds, counts.freeOnly);
  fan.origin.z() = height;
}

/// Free points or the free line of one ray, from the origin up to a distance. A sample within a millionth of
/// a cell of the end stands on the end. A ray without a hit is not free at its very end, nor where others
/// hit.
void addFreeSpace(const Eigen::Vector3d& origin, const Eigen::Vector3d& end, bool hasHit, double resolution,
                  const BgkInference& inference, TrainingSet& training)
{
  const double length = (end - origin).norm();
  const double upTo = length - (hasHit ? *inference.freeMargin : 0);
  const Eigen::Vector3d direction =
      length > 0 ? Eigen::Vector3d((end - origin) / length) : Eigen::Vector3d::Zero();
  if (inference.freeSpace == FreeSpace::Line && upTo >= 0)
    training.lines.push_back({origin, origin + direction * upTo, hasHit});
  if (inference.freeSpace != FreeSpace::Samples || upTo < -1e-6 * resolution) return;
  const bool cells = inference.trainingPoints == TrainingPoints::Cells;
  const double last = hasHit || !cells ? upTo : upTo - 1e-6 * resolution;
  const auto addAt = [&](double along)
  {
    const Eigen::Vector3d place = origin + direction * std::max(0.0, std::min(along, last));
    if (hasHit || training.rawHits.count(voxelOf(place, resolution)) == 0)
      training.frees_map.push_back(place);
  };
  for (int64_t i = 0;; ++i)
  {
    const double along = static_cast<double>(i) * *inference.freeResolution;
    if (along > upTo + 1e-6 * resolution) break;
    addAt(along);
  }
  if (!hasHit && cells) addAt(last);
}

std::vector<Eigen::Vector3d> cellCentres(const std::vector<Eigen::Vector3d>& points, double resolution)
{
  std::set<Cell> cells;
  for (const Eigen::Vector3d& point : points) cells.insert(voxelOf(point, resolution));
  std::vector<Eigen::Vector3d> centres;
  for (const Cell& cell : cells)
    centres.emplace_back((static_cast<double>(cell[0]) + 0.5) * resolution,
                         (static_cast<double>(cell[1]) + 0.5) * resolution,
                         (static_cast<double>(cell[2]) + 0.5) * resolution);
  return centres;
}

/// The cells that surfaces seen at a glancing angle pass through.
std::set<Cell> cellsOfSurfaces(const Scan& scan, const BgkStructure& structure, const BgkInference& inference)
{
  std::set<Cell> cells;
  const double height =
      (std::floor(structure.planarHeight / structure.resolution) + 0.5) * structure.resolution;
  const Scan selected = selectRays(scan, inference.resolved(structure.resolution).rangeLimits()).scan;
  GlancingSurfaces surfaces;
  for (const RayFan& fan : selected.fans)
    for (const GlancingSurfaces::Piece& piece : surfaces.of(fan))
    {
      Eigen::Vector3d begin = selected.inMap(piece.begin);
      Eigen::Vector3d end = selected.inMap(piece.end);
      if (structure.planar) begin.z() = end.z() = height;
      const int parts = static_cast<int>(2 * (end - begin).norm() / structure.resolution) + 1;
      for (int i = 1; i < parts; ++i)
        cells.insert(voxelOf(begin + (end - begin) * i / parts, structure.resolution));
    }
  return cells;
}
}  // namespace

double oracleKernel(KernelShape shape, double distance_m, double support_m, double scale)
{
  if (distance_m >= support_m) return 0;
  const double r = distance_m / support_m;
  const double sparse = (2 + std::cos(2 * kPi * r)) / 3 * (1 - r) + std::sin(2 * kPi * r) / (2 * kPi);
  switch (shape)
  {
    case KernelShape::Sparse:
      return scale * sparse;
    case KernelShape::SparseMatern32:
      return scale * sparse * (1 + std::sqrt(3.0) * r) * std::exp(-std::sqrt(3.0) * r);
    case KernelShape::WendlandC2:
      return scale * std::pow(1 - r, 4) * (4 * r + 1);
  }
  return std::numeric_limits<double>::quiet_NaN();
}

double FreeLine::distanceTo(const Eigen::Vector3d& point_map) const
{
  const Eigen::Vector3d pq = q_map - p_map;
  const double squaredLength = pq.dot(pq);
  if (squaredLength == 0) return (point_map - p_map).norm();
  const double d = pq.dot(point_map - p_map) / squaredLength;
  if (d < 0) return (point_map - p_map).norm();
  if (d > 1) return (point_map - q_map).norm();
  return (point_map - (p_map + d * pq)).norm();
}

TrainingSet trainingSetOf(const Scan& scan, const BgkStructure& structure, const BgkInference& options)
{
  const double resolution = structure.resolution;
  BgkInference inference = options;
  if (!inference.freeResolution) inference.freeResolution = resolution;
  if (!inference.freeMargin) inference.freeMargin = 0.5 * resolution;
  if (!inference.hitDownsampling) inference.hitDownsampling = resolution;
  const bool cells = inference.trainingPoints == TrainingPoints::Cells;
  const double groupEdge = cells ? resolution : *inference.hitDownsampling;

  Selection selection(scan, resolution, inference);
  TrainingSet training;
  for (OracleFan& fan : selection.fans)
  {
    if (structure.planar)
      flatten(fan, (std::floor(structure.planarHeight / resolution) + 0.5) * resolution, selection.counts);
    for (const Eigen::Vector3d& hit : fan.hits) ++training.rawHits[voxelOf(hit, resolution)];
    for (const Eigen::Vector3d& end : voxelMeans(fan.hits, groupEdge))
    {
      if (!cells) training.hits_map.push_back(end);
      addFreeSpace(fan.origin, end, true, resolution, inference, training);
    }
    if (cells) training.hits_map.insert(training.hits_map.end(), fan.hits.begin(), fan.hits.end());
  }
  for (const OracleFan& fan : selection.fans)
    for (const Eigen::Vector3d& end : voxelMeans(fan.freeEnds, groupEdge))
      addFreeSpace(fan.origin, end, false, resolution, inference, training);
  if (cells)
  {
    training.hits_map = cellCentres(training.hits_map, resolution);
    training.frees_map = cellCentres(training.frees_map, resolution);
    if (inference.protectHits > 0)
    {
      const std::set<Cell> surfaces = cellsOfSurfaces(scan, structure, inference);
      const auto isOnSurface = [&](const Eigen::Vector3d& place)
      { return surfaces.count(voxelOf(place, resolution)) > 0; };
      training.frees_map.erase(
          std::remove_if(training.frees_map.begin(), training.frees_map.end(), isOnSurface),
          training.frees_map.end());
    }
  }
  else
    training.frees_map = voxelMeans(training.frees_map, inference.freeDownsampling);
  if (inference.freeWeight == 0)
  {
    training.frees_map.clear();
    training.lines.clear();
  }
  training.counts = selection.counts;
  return training;
}

OracleField::OracleField(const Scan& scan, const BgkStructure& structure, const BgkInference& inference)
    : training_(trainingSetOf(scan, structure, inference)),
      resolution_(structure.resolution),
      planar_(structure.planar),
      layer_(floorDivided(structure.planarHeight, structure.resolution)),
      kernel_(inference.kernel),
      support_(inference.kernelSupport.value_or(2 * structure.resolution)),
      scale_(inference.kernelScale)
{
  std::vector<Eigen::Vector3d> points = training_.hits_map;
  points.insert(points.end(), training_.frees_map.begin(), training_.frees_map.end());
  for (const FreeLine& line : training_.lines) points.insert(points.end(), {line.p_map, line.q_map});
  if (points.empty()) return;
  Eigen::Vector3d low = points.front(), high = points.front();
  for (const Eigen::Vector3d& point : points)
  {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  size_t count = 1;
  for (size_t axis = 0; axis < 3; ++axis)
  {
    first_[axis] = floorDivided(low[static_cast<int>(axis)] - support_, resolution_) - 1;
    last_[axis] = floorDivided(high[static_cast<int>(axis)] + support_, resolution_) + 1;
    if (planar_ && axis == 2) first_[axis] = last_[axis] = layer_;
    count *= static_cast<size_t>(last_[axis] - first_[axis] + 1);
  }
  sums_.resize(count);

  for (const Eigen::Vector3d& hit : training_.hits_map)
    weigh(hit, hit, 1.0, true,
          [&hit](const Eigen::Vector3d& centre, const Cell&) { return (centre - hit).norm(); });
  for (const Eigen::Vector3d& free : training_.frees_map)
    weigh(free, free, inference.freeWeight, false,
          [&free](const Eigen::Vector3d& centre, const Cell&) { return (centre - free).norm(); });
  for (const FreeLine& line : training_.lines)
    weigh(line.p_map.cwiseMin(line.q_map), line.p_map.cwiseMax(line.q_map), inference.freeWeight, false,
          [&](const Eigen::Vector3d& centre, const Cell& cell)
          {
            const double d = line.distanceTo(centre);
            const bool isHit = !line.hasHit && d <= support_ && training_.rawHits.count(cell) > 0;
            return isHit ? std::numeric_limits<double>::infinity() : d;
          });

  if (!planar_ && inference.keepsUnseenSpace()) keepUnseenSpace(inference.freeWeight);
  for (const auto& [cell, hits] : training_.rawHits)
    if (inference.protectHits > 0 && hits >= inference.protectHits)
    {
      sumsAt(cell).free = 0;
      sumsAt(cell).freeReach = OracleEvidence::Reach::No;
    }
}

/// Where no free sample is, free evidence counts little unless more cells around are free than a half-space.
void OracleField::keepUnseenSpace(double freeWeight)
{
  long double halfSpace = 0;
  const int reach = static_cast<int>(std::ceil(support_ / resolution_));
  for (int x = 1; x <= reach; ++x)
    for (int y = -reach; y <= reach; ++y)
      for (int z = -reach; z <= reach; ++z)
        halfSpace += freeWeight *
                     oracleKernel(kernel_, resolution_ * std::sqrt(x * x + y * y + z * z), support_, scale_);
  std::set<Cell> seen;
  for (const Eigen::Vector3d& free : training_.frees_map) seen.insert(voxelOf(free, resolution_));
  Cell cell{};
  for (cell[0] = first_[0]; cell[0] <= last_[0]; ++cell[0])
    for (cell[1] = first_[1]; cell[1] <= last_[1]; ++cell[1])
      for (cell[2] = first_[2]; cell[2] <= last_[2]; ++cell[2])
      {
        Sums& sums = sumsAt(cell);
        if (seen.count(cell) == 0 && sums.free < halfSpace * 9 / 8) sums.free /= 128;
      }
}

Eigen::Vector3d OracleField::centreOf(const Cell& cell) const
{
  return {(static_cast<double>(cell[0]) + 0.5) * resolution_,
          (static_cast<double>(cell[1]) + 0.5) * resolution_,
          (static_cast<double>(cell[2]) + 0.5) * resolution_};
}

OracleField::Sums& OracleField::sumsAt(const Cell& cell)
{
  size_t offset = 0;
  for (size_t axis = 0; axis < 3; ++axis)
    offset = offset * static_cast<size_t>(last_[axis] - first_[axis] + 1) +
             static_cast<size_t>(cell[axis] - first_[axis]);
  return sums_.at(offset);
}

/// Adds weight · k(distance) to every cell of the box [low, high] widened by the support.
template <typename Distance>
void OracleField::weigh(const Eigen::Vector3d& low_map, const Eigen::Vector3d& high_map, double weight,
                        bool occupied, const Distance& distance)
{
  Cell from{}, to{};
  for (size_t axis = 0; axis < 3; ++axis)
  {
    from[axis] = floorDivided(low_map[static_cast<int>(axis)] - support_, resolution_) - 1;
    to[axis] = floorDivided(high_map[static_cast<int>(axis)] + support_, resolution_) + 1;
  }
  if (planar_) from[2] = to[2] = layer_;
  Cell cell{};
  for (cell[0] = from[0]; cell[0] <= to[0]; ++cell[0])
    for (cell[1] = from[1]; cell[1] <= to[1]; ++cell[1])
      for (cell[2] = from[2]; cell[2] <= to[2]; ++cell[2])
      {
        const double d = distance(centreOf(cell), cell);
        if (d > support_ * (1 + kBorder)) continue;
        Sums& sums = sumsAt(cell);
        (occupied ? sums.occupied : sums.free) += weight * oracleKernel(kernel_, d, support_, scale_);
        auto& reach = occupied ? sums.occupiedReach : sums.freeReach;
        reach = std::max(
            reach, d < support_ * (1 - kBorder) ? OracleEvidence::Reach::Yes : OracleEvidence::Reach::Maybe);
      }
}

OracleEvidence OracleField::at(const Cell& cell) const
{
  for (size_t axis = 0; axis < 3; ++axis)
    if (cell[axis] < first_[axis] || cell[axis] > last_[axis]) return {};
  const Sums& sums = const_cast<OracleField*>(this)->sumsAt(cell);
  return {static_cast<double>(sums.occupied), static_cast<double>(sums.free), sums.occupiedReach,
          sums.freeReach};
}

namespace
{
struct Comparer
{
  const BgkMap& map;
  const std::vector<OracleField>& scans;
  Comparison result;

  void differ(const Cell& cell, const std::string& how)
  {
    if (!result.firstDifference.empty()) return;
    std::ostringstream text;
    text << "cell (" << cell[0] << ", " << cell[1] << ", " << cell[2] << "): " << how;
    result.firstDifference = text.str();
  }

  void compareCount(const Cell& cell, const char* name, double oracle, uint64_t units, double count,
                    OracleEvidence::Reach reach)
  {
    const double deviation = std::abs(count - oracle);
    result.worstDeviation = std::max(result.worstDeviation, deviation);
    if (scans.size() == 1 && oracle > kEvidenceUnit)
      result.worstRounding = std::max(result.worstRounding, deviation);
    // Nearly all agree: no text is made for them.
    const bool isFar = !(deviation <= 1e-6 * static_cast<double>(scans.size()));
    const bool isMissing = reach == OracleEvidence::Reach::Yes && units == 0;
    const bool isTooMuch = reach == OracleEvidence::Reach::No && units != 0;
    if (!isFar && !isMissing && !isTooMuch) return;
    std::ostringstream text;
    text.precision(17);
    text << name << " is " << count;
    if (isFar)
      text << ", by brute force " << oracle;
    else
      text << (isMissing ? " though a training point lies within the support"
                         : " though no training point lies within the support");
    differ(cell, text.str());
  }

  void compareCell(const Cell& cell)
  {
    OracleEvidence oracle;
    for (const OracleField& scan : scans)
    {
      const OracleEvidence one = scan.at(cell);
      oracle.occupied += one.occupied;
      oracle.free += one.free;
      oracle.occupiedReach = std::max(oracle.occupiedReach, one.occupiedReach);
      oracle.freeReach = std::max(oracle.freeReach, one.freeReach);
    }
    const CellIndex index{static_cast<int32_t>(cell[0]), static_cast<int32_t>(cell[1]),
                          static_cast<int32_t>(cell[2])};
    const CellSums evidence = map.evidence().at(index);
    const double occupied = static_cast<double>(evidence.first) * kEvidenceUnit;
    const double free = static_cast<double>(evidence.second) * kEvidenceUnit;
    compareCount(cell, "occupied evidence", oracle.occupied, evidence.first, occupied, oracle.occupiedReach);
    compareCount(cell, "free evidence", oracle.free, evidence.second, free, oracle.freeReach);

    const auto estimate = map.cell(index, StateThresholds{});
    if (estimate.has_value() != evidence.any())
      differ(cell, "cell() and evidence() differ on whether it is observed");
    if (!estimate) return;
    ++result.cells;
    const double alpha = map.structure().priorAlpha + occupied, beta = map.structure().priorBeta + free;
    if (std::abs(estimate->evidence[0] - alpha) > 1e-12 * alpha ||
        std::abs(estimate->evidence[1] - beta) > 1e-12 * beta)
      differ(cell, "alpha and beta are not prior plus evidence");
    if (std::abs(estimate->prob - alpha / (alpha + beta)) > 1e-12) differ(cell, "prob is not eq. (4.1)");
    const double sum = alpha + beta;
    if (!estimate->variance || std::abs(*estimate->variance - alpha * beta / (sum * sum * (sum + 1))) > 1e-12)
      differ(cell, "variance is not eq. (4.2)");
  }
};
}  // namespace

Comparison compare(const BgkMap& map, const std::vector<OracleField>& scans)
{
  Comparer comparer{map, scans, {}};
  Cell first{0, 0, 0}, last{-1, -1, -1};
  bool any = false;
  for (const OracleField& scan : scans)
  {
    if (scan.last()[0] < scan.first()[0]) continue;
    for (size_t axis = 0; axis < 3; ++axis)
    {
      first[axis] = any ? std::min(first[axis], scan.first()[axis]) : scan.first()[axis];
      last[axis] = any ? std::max(last[axis], scan.last()[axis]) : scan.last()[axis];
    }
    any = true;
  }
  Cell cell{};
  for (cell[0] = first[0]; cell[0] <= last[0]; ++cell[0])
    for (cell[1] = first[1]; cell[1] <= last[1]; ++cell[1])
      for (cell[2] = first[2]; cell[2] <= last[2]; ++cell[2]) comparer.compareCell(cell);

  size_t visited = 0;
  map.visitCells(StateThresholds{},
                 [&](const CellIndex& index, const CellEstimate&)
                 {
                   ++visited;
                   const Cell at{index.x, index.y, index.z};
                   for (size_t axis = 0; axis < 3; ++axis)
                     if (at[axis] < first[axis] || at[axis] > last[axis])
                       comparer.differ(at, "has evidence beyond everything within the support");
                 });
  if (visited != comparer.result.cells)
    comparer.differ({0, 0, 0}, "visitCells() visits " + std::to_string(visited) + " cells, not " +
                                   std::to_string(comparer.result.cells));
  return comparer.result;
}

}  // namespace lamap::test
