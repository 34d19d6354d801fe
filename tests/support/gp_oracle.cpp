#include <lamap_core/scan/open_space.h>
#include <support/gp_oracle.h>

#include <lamap_core/grid/cell_sums.h>
#include <support/grid_words.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace lamap::test
{
namespace
{
constexpr double kBorder = 1e-9;

int64_t floorDivided(double coordinate, double edge)
{
  return static_cast<int64_t>(std::floor(coordinate / edge));
}

Eigen::Vector3d centreOf(const Cell& cell, double resolution)
{
  return {(static_cast<double>(cell[0]) + 0.5) * resolution,
          (static_cast<double>(cell[1]) + 0.5) * resolution,
          (static_cast<double>(cell[2]) + 0.5) * resolution};
}

Cell cellOf(const Eigen::Vector3d& place, double resolution)
{
  return {floorDivided(place.x(), resolution), floorDivided(place.y(), resolution),
          floorDivided(place.z(), resolution)};
}

/// Edge of a block in cells, along each axis.
Cell edgesOf(const GpStructure& structure)
{
  const int64_t edge = int64_t{1} << (structure.blockDepth - 1);
  return {edge, edge, structure.planar ? 1 : edge};
}

Cell blockOf(const Cell& cell, const Cell& edges)
{
  Cell block;
  for (size_t axis = 0; axis < 3; ++axis)
    block[axis] =
        static_cast<int64_t>(std::floor(static_cast<double>(cell[axis]) / static_cast<double>(edges[axis])));
  return block;
}

template <typename Visit>
void forEachCell(const Cell& first, const Cell& last, Visit&& visit)
{
  for (int64_t z = first[2]; z <= last[2]; ++z)
    for (int64_t y = first[1]; y <= last[1]; ++y)
      for (int64_t x = first[0]; x <= last[0]; ++x) visit(Cell{x, y, z});
}

/// Adds what a GP says of the cells of [first, last] that it reaches.
void addSums(const OracleGp& gp, const Cell& first, const Cell& last, const GpStructure& structure,
             double support, std::map<Cell, GpSums>& sums)
{
  forEachCell(first, last,
              [&](const Cell& cell)
              {
                const Eigen::Vector3d centre = centreOf(cell, structure.resolution);
                const double distance = gp.distanceTo(centre);
                if (distance > support * (1 + kBorder)) return;
                GpSums& held = sums[cell];
                if (distance > support * (1 - kBorder))
                {
                  held.undecided = true;
                  return;
                }
                held.reached = true;
                const OracleGp::Normal said = gp.at(centre);
                held.precision += 1 / said.variance - 1 / static_cast<long double>(structure.signalVariance);
                held.weighted += said.mean / said.variance;
              });
}

}  // namespace

long double oracleMatern(long double distance_m, double lengthScale_m, double signalVariance)
{
  const long double t = std::sqrt(3.0L) * distance_m / static_cast<long double>(lengthScale_m);
  return static_cast<long double>(signalVariance) * (1 + t) * std::exp(-t);
}

OracleGp::OracleGp(OraclePoints points, double lengthScale_m, double signalVariance, double noiseVariance)
    : points_(std::move(points)), lengthScale_(lengthScale_m), signalVariance_(signalVariance)
{
  const auto n = static_cast<Eigen::Index>(points_.places_map.size());
  Matrix k(n, n);
  labels_.resize(n);
  for (Eigen::Index i = 0; i < n; ++i)
  {
    const auto a = static_cast<size_t>(i);
    labels_[i] = static_cast<long double>(points_.labels[a]);
    for (Eigen::Index j = 0; j < n; ++j)
    {
      const double distance = (points_.places_map[a] - points_.places_map[static_cast<size_t>(j)]).norm();
      k(i, j) = oracleMatern(static_cast<long double>(distance), lengthScale_m, signalVariance) +
                (i == j ? static_cast<long double>(noiseVariance) : 0.0L);
    }
  }
  inverse_ = k.fullPivLu().inverse();
}

OracleGp::Normal OracleGp::at(const Eigen::Vector3d& place_map) const
{
  Vector k(labels_.size());
  for (Eigen::Index i = 0; i < k.size(); ++i)
  {
    const double distance = (points_.places_map[static_cast<size_t>(i)] - place_map).norm();
    k[i] = oracleMatern(static_cast<long double>(distance), lengthScale_, signalVariance_);
  }
  const Vector solved = inverse_ * k;
  return {solved.dot(labels_), static_cast<long double>(signalVariance_) - solved.dot(k)};
}

double OracleGp::distanceTo(const Eigen::Vector3d& place_map) const
{
  double nearest = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& place : points_.places_map)
    nearest = std::min(nearest, (place - place_map).norm());
  return nearest;
}

namespace
{
/// What a BGK map would be taught by the same rules.
TrainingSet taughtBy(const Scan& scan, const GpStructure& structure, const GpInference& resolved)
{
  BgkStructure cells;
  cells.resolution = structure.resolution;
  cells.planar = structure.planar;
  cells.planarHeight = structure.planarHeight;
  BgkInference rules;
  rules.freeSpace = resolved.freeSpace == GpFreeSpace::Samples ? FreeSpace::Samples : FreeSpace::None;
  rules.trainingPoints = resolved.trainingPoints;
  rules.protectHits = resolved.protectHits;
  rules.freeResolution = resolved.freeResolution;
  rules.freeMargin = resolved.freeMargin;
  rules.freeDownsampling = resolved.freeDownsampling;
  rules.hitDownsampling = resolved.hitDownsampling;
  rules.minRange = resolved.minRange;
  rules.maxRange = resolved.maxRange;
  rules.considerInvalidRangesAsFreeSpace = resolved.considerInvalidRangesAsFreeSpace;
  rules.rayDecimation = resolved.rayDecimation;
  return trainingSetOf(scan, cells, rules);
}

}  // namespace

OraclePoints gpTrainingSetOf(const Scan& scan, const GpStructure& structure, const GpInference& inference)
{
  const GpInference resolved = inference.resolved(structure.resolution);
  const TrainingSet set = taughtBy(scan, structure, resolved);
  OraclePoints points;
  for (const Eigen::Vector3d& hit : set.hits_map) points.add(hit, 1.0);
  for (const Eigen::Vector3d& place : set.frees_map)
  {
    const auto raw = set.rawHits.find(cellOf(place, structure.resolution));
    const bool isProtected =
        resolved.protectHits > 0 && raw != set.rawHits.end() && raw->second >= resolved.protectHits;
    if (!isProtected) points.add(place, -1.0);
  }
  return points;
}

namespace
{
/// What one fan of rays saw, by the map's axes in a planar map, else by the sensor's.
struct OracleView
{
  Eigen::Vector3d origin_map;
  OpenSpace space;
};

std::vector<OracleView> viewsOf(const Scan& scan, bool planar, const GpInference& resolved)
{
  std::vector<OracleView> views;
  const Eigen::Matrix3d turn = scan.sensorPose_map.linear();
  for (const RayFan& fan : selectRays(scan, resolved).scan.fans)
  {
    std::vector<Eigen::Vector3d> ends;
    for (const Ray& ray : fan.rays)
    {
      Eigen::Vector3d end = ray.end;
      if (ray.meaning == RayEnd::Return) end -= fan.centre;
      if (planar) end = turn * end;
      if (planar) end.z() = 0;
      ends.push_back(end);
    }
    if (!ends.empty())
      views.push_back({turn * fan.centre + scan.sensorPose_map.translation(), OpenSpace::between(ends)});
  }
  return views;
}

/// Cells that are called free though no ray passes through them nor do all rays beside them reach farther.
void forgetUnseen(const Scan& scan, const GpStructure& structure, const GpInference& resolved,
                  std::map<Cell, GpSums>& sums)
{
  const TrainingSet taught = taughtBy(scan, structure, resolved);
  std::set<Cell> passed;
  if (resolved.trainingPoints == TrainingPoints::Cells)
    for (const Eigen::Vector3d& place : taught.frees_map) passed.insert(cellOf(place, structure.resolution));
  const std::vector<OracleView> views = viewsOf(scan, structure.planar, resolved);
  const Eigen::Matrix3d turnBack = scan.sensorPose_map.linear().transpose();
  for (auto& [cell, sum] : sums)
  {
    if (!sum.reached || passed.count(cell) > 0) continue;
    constexpr long double kUnsure = 1e-5L;
    if (std::abs(sum.weighted) < kUnsure) sum.undecided = true;
    if (sum.weighted >= 0) continue;
    const Eigen::Vector3d centre = centreOf(cell, structure.resolution);
    const auto isSeen = [&](const Eigen::Vector3d& shift)
    {
      return std::any_of(views.begin(), views.end(),
                         [&](const OracleView& view)
                         {
                           Eigen::Vector3d place = centre - view.origin_map;
                           if (structure.planar) place.z() = 0;
                           if (!structure.planar) place = turnBack * place;
                           return view.space.reaches(place + shift);
                         });
    };
    const bool seen = isSeen(Eigen::Vector3d::Zero());
    for (int corner = 0; corner < 8; ++corner)
    {
      const auto along = [&](int axis) { return (corner >> axis & 1) != 0 ? 1e-6 : -1e-6; };
      const Eigen::Vector3d shift(along(0), along(1), structure.planar ? 0 : along(2));
      if (isSeen(shift) != seen) sum.undecided = true;  // next to the edge of a bin or the end of a ray
    }
    const bool undecided = sum.undecided;
    if (!seen) sum = {};
    sum.undecided = undecided;
  }
}
}  // namespace

std::set<Cell> gpHitCellsOf(const Scan& scan, const GpStructure& structure, const GpInference& inference)
{
  std::set<Cell> cells;
  if (inference.protectHits == 0) return cells;
  for (const auto& [cell, count] :
       taughtBy(scan, structure, inference.resolved(structure.resolution)).rawHits)
    cells.insert(cell);
  return cells;
}

std::map<Cell, GpSums> gpSumsOf(const Scan& scan, const GpStructure& structure, const GpInference& inference)
{
  const OraclePoints all = gpTrainingSetOf(scan, structure, inference);
  const GpInference resolved = inference.resolved(structure.resolution);
  const double r = structure.resolution;
  const double support = *resolved.kernelSupport;
  const Cell edges = edgesOf(structure);
  const auto reach = static_cast<int64_t>(support / r) + 2;
  const Cell reaches = {reach, reach, structure.planar ? 0 : reach};

  // Every block that may be reached, with the points of its own.
  std::map<Cell, OraclePoints> blocks;
  for (size_t i = 0; i < all.labels.size(); ++i)
  {
    const Cell cell = cellOf(all.places_map[i], r);
    Cell low = cell;
    Cell high = cell;
    for (size_t axis = 0; axis < 3; ++axis)
    {
      low[axis] -= reaches[axis];
      high[axis] += reaches[axis];
    }
    forEachCell(blockOf(low, edges), blockOf(high, edges), [&](const Cell& block) { blocks[block]; });
    blocks[blockOf(cell, edges)].add(all.places_map[i], all.labels[i]);
  }

  std::map<Cell, GpSums> sums;
  const auto gpOf = [&](const OraclePoints& points)
  { return OracleGp(points, resolved.lengthScale, structure.signalVariance, structure.noiseVariance); };
  for (const auto& [block, own] : blocks)
  {
    Cell first;
    Cell last;
    for (size_t axis = 0; axis < 3; ++axis)
    {
      first[axis] = block[axis] * edges[axis];
      last[axis] = first[axis] + edges[axis] - 1;
    }
    if (resolved.nested)
    {
      if (own.labels.empty()) continue;
      Cell low = first;
      Cell high = last;
      for (size_t axis = 0; axis < 3; ++axis)
      {
        low[axis] -= reaches[axis];
        high[axis] += reaches[axis];
      }
      addSums(gpOf(own), low, high, structure, support, sums);
      continue;
    }
    // All points within the support of the box that the centres of the block's cells span.
    const Eigen::Vector3d low = centreOf(first, r);
    const Eigen::Vector3d high = centreOf(last, r);
    OraclePoints extended;
    for (size_t i = 0; i < all.labels.size(); ++i)
    {
      const Eigen::Vector3d& place = all.places_map[i];
      const double distance = (place - place.cwiseMax(low).cwiseMin(high)).norm();
      if (distance < support * (1 - kBorder)) extended.add(place, all.labels[i]);
    }
    if (!extended.labels.empty()) addSums(gpOf(extended), first, last, structure, support, sums);
  }
  if (resolved.protectHits > 0) forgetUnseen(scan, structure, resolved, sums);
  // A cell with a hit: at least what a GP says of it that knows nothing but three hits at its centre.
  OraclePoints hit;
  for (int copy = 0; copy < 3; ++copy) hit.add(Eigen::Vector3d::Zero(), 1.0);
  const auto [mean, variance] = gpOf(hit).at(Eigen::Vector3d::Zero());
  for (const Cell& cell : gpHitCellsOf(scan, structure, inference))
  {
    GpSums& sum = sums[cell];
    sum.precision =
        std::max(sum.precision, 1 / variance - 1 / static_cast<long double>(structure.signalVariance));
    sum.weighted = std::max(sum.weighted, mean / variance);
    sum.reached = true;
  }
  return sums;
}

std::string differenceFromOracle(const GpMap& map, const std::vector<Scan>& scans,
                                 const GpInference& inference)
{
  std::map<Cell, GpSums> expected;
  for (const Scan& scan : scans)
  {
    for (const auto& [cell, sums] : gpSumsOf(scan, map.structure(), inference))
    {
      GpSums& sum = expected[cell];
      sum.precision += sums.precision;
      sum.weighted += sums.weighted;
      sum.reached |= sums.reached;
      sum.undecided |= sums.undecided;
    }
  }
  std::ostringstream text;
  size_t there = 0;
  const double tolerance = 1e-6 * static_cast<double>(scans.size());
  for (const auto& [cell, sums] : expected)
  {
    const CellSums evidence = map.evidence().at(
        {static_cast<int32_t>(cell[0]), static_cast<int32_t>(cell[1]), static_cast<int32_t>(cell[2])});
    there += evidence.any() ? 1 : 0;
    if (sums.undecided) continue;
    const auto precision = SignedSums::decoded(evidence.first);
    const auto weighted = SignedSums::decoded(evidence.second);
    text.precision(12);
    if (sums.reached != (precision.has_value() && weighted.has_value()))
    {
      text << "cell (" << cell[0] << ", " << cell[1] << ", " << cell[2] << ") is "
           << (sums.reached ? "missing" : "there though nothing reaches it");
      return text.str();
    }
    if (!sums.reached) continue;
    const double p = static_cast<double>(*precision) * kEvidenceUnit;
    const double w = static_cast<double>(*weighted) * kEvidenceUnit;
    if (std::abs(p - static_cast<double>(sums.precision)) <= tolerance &&
        std::abs(w - static_cast<double>(sums.weighted)) <= tolerance)
      continue;
    text << "cell (" << cell[0] << ", " << cell[1] << ", " << cell[2] << ") holds " << p << ", " << w
         << "; expected " << static_cast<double>(sums.precision) << ", "
         << static_cast<double>(sums.weighted);
    return text.str();
  }
  const size_t count = cellsOf(map.evidence()).size();
  if (count != there) text << count - there << " cells are there that nothing reaches";
  return text.str();
}

}  // namespace lamap::test
