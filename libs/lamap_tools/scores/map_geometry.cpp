#include <lamap_tools/scores/map_geometry.h>

#include <nanoflann.hpp>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <vector>

namespace lamap::tools
{
namespace
{
using Eigen::Vector3d;

/// Finds the nearest of some points.
class NearestPoint
{
 public:
  /// @param points at least one
  explicit NearestPoint(std::vector<Vector3d> points) : points_{std::move(points)}, tree_(3, points_)
  {
    tree_.buildIndex();
  }

  [[nodiscard]] double distanceFrom(const Vector3d& point) const
  {
    size_t index = 0;
    double squared = 0;
    nanoflann::KNNResultSet<double> nearest(1);
    nearest.init(&index, &squared);
    tree_.findNeighbors(nearest, point.data(), nanoflann::SearchParams());
    return std::sqrt(squared);
  }

 private:
  /// The data set interface that nanoflann expects.
  struct Points
  {
    std::vector<Vector3d> points;

    [[nodiscard]] size_t kdtree_get_point_count() const { return points.size(); }
    [[nodiscard]] double kdtree_get_pt(size_t index, size_t axis) const
    {
      return points[index][static_cast<Eigen::Index>(axis)];
    }
    template <class Box>
    bool kdtree_get_bbox(Box&) const
    {
      return false;
    }
  };

  Points points_;
  nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Points>, Points, 3, size_t> tree_;
};

/// What counts of a map and a truth, and in which plane.
class Scope
{
 public:
  Scope(const CellMap& map, std::optional<int32_t> layer, const Truth& truth)
      : resolution_m_(map.resolution()), layer_(layer), truthIsOneLayer_(truth.isOneLayer())
  {
    if (!layer_ && truthIsOneLayer_) layerInMap_ = layerAt(truth.cells.front().centre_map.z());
  }

  [[nodiscard]] bool holdsCell(const CellIndex& cell) const { return !layerInMap_ || cell.z == *layerInMap_; }
  /// Of the truth.
  [[nodiscard]] bool holdsPoint(const Vector3d& point) const
  {
    return !layer_ || truthIsOneLayer_ || layerAt(point.z()) == *layer_;
  }
  [[nodiscard]] Vector3d inPlane(Vector3d point) const
  {
    if (layer_ || truthIsOneLayer_) point.z() = 0;
    return point;
  }

 private:
  [[nodiscard]] int32_t layerAt(double z) const
  {
    return static_cast<int32_t>(std::floor(z / resolution_m_));
  }

  double resolution_m_;
  std::optional<int32_t> layer_;
  bool truthIsOneLayer_;
  std::optional<int32_t> layerInMap_;  ///< the only one that counts of a map in 3D
};

std::vector<Vector3d> occupiedCentres(const CellMap& map, const Scope& scope)
{
  std::vector<Vector3d> centres;
  map.visitCells(
      [&](const CellIndex& cell, const CellEstimate& estimate)
      {
        if (estimate.state == CellState::Occupied && scope.holdsCell(cell))
          centres.push_back(scope.inPlane(cellCentre(cell, map.resolution())));
      });
  return centres;
}

std::vector<Vector3d> surfaceCentres(const Truth& truth, const Scope& scope)
{
  std::vector<Vector3d> centres;
  for (const TrueCell& cell : truth.cells)
    if (cell.occupied && scope.holdsPoint(cell.centre_map)) centres.push_back(scope.inPlane(cell.centre_map));
  return centres;
}

std::vector<Vector3d> surfacePoints(const Truth& truth, const Scope& scope)
{
  std::vector<Vector3d> points;
  for (const Vector3d& point : truth.surface_map)
    if (scope.holdsPoint(point)) points.push_back(scope.inPlane(point));
  return points;
}

std::optional<double> share(uint64_t part, uint64_t whole)
{
  if (whole == 0) return std::nullopt;
  return static_cast<double>(part) / static_cast<double>(whole);
}

/// The least of them that at least 95 % do not exceed.
double percentile95(std::vector<double> distances)
{
  const size_t rank = (distances.size() * 95 + 99) / 100;  // from 1
  const auto at = distances.begin() + static_cast<std::ptrdiff_t>(rank - 1);
  std::nth_element(distances.begin(), at, distances.end());
  return *at;
}
}  // namespace

void StateCounts::add(const std::optional<CellEstimate>& estimate, uint64_t occupiedCells, uint64_t freeCells)
{
  occupied += occupiedCells;
  free += freeCells;
  if (!estimate) return;
  if (estimate->state == CellState::Occupied)
  {
    occupiedCalledOccupied += occupiedCells;
    freeCalledOccupied += freeCells;
  }
  else if (estimate->prob < kCalledFreeBelow)
  {
    occupiedCalledFree += occupiedCells;
    freeCalledFree += freeCells;
  }
}

MapGeometry geometryOf(const CellMap& map, std::optional<int32_t> layer, const Truth& truth,
                       const StateCounts& states)
{
  const Scope scope(map, layer, truth);
  const std::vector<Vector3d> occupied = occupiedCentres(map, scope);
  const std::vector<Vector3d> surface = surfaceCentres(truth, scope);
  MapGeometry geometry;
  geometry.occupiedCells = occupied.size();
  geometry.surfaceCells = surface.size();
  geometry.surfaceCalledFree = share(states.occupiedCalledFree, states.occupied);
  geometry.freeCalledFree = share(states.freeCalledFree, states.free);
  geometry.f1 = share(2 * states.occupiedCalledOccupied,
                      states.occupiedCalledOccupied + states.freeCalledOccupied + states.occupied);
  const double edge_m = std::max(map.resolution(), truth.spacing_m.value_or(0));
  constexpr double kRounding = 1e-6;
  if (!truth.spacing_m || std::abs(*truth.spacing_m - map.resolution()) < kRounding)
    geometry.occupiedPerSurfaceCell = share(occupied.size(), surface.size());

  geometry.toPoints = !truth.surface_map.empty();
  std::vector<Vector3d> targets = geometry.toPoints ? surfacePoints(truth, scope) : surface;
  if (!occupied.empty() && !targets.empty())
  {
    const NearestPoint nearest(std::move(targets));
    std::vector<double> distances;
    distances.reserve(occupied.size());
    for (const Vector3d& centre : occupied) distances.push_back(nearest.distanceFrom(centre));
    geometry.meanDistance_m =
        std::accumulate(distances.begin(), distances.end(), 0.0) / static_cast<double>(distances.size());
    geometry.distance95_m = percentile95(std::move(distances));
  }
  if (occupied.empty())
  {
    geometry.covered = share(0, surface.size());
    return geometry;
  }
  const NearestPoint nearest(occupied);
  const auto isCovered = [&](const Vector3d& centre)
  { return nearest.distanceFrom(centre) <= edge_m + kRounding; };
  geometry.covered =
      share(static_cast<uint64_t>(std::count_if(surface.begin(), surface.end(), isCovered)), surface.size());
  return geometry;
}

}  // namespace lamap::tools
