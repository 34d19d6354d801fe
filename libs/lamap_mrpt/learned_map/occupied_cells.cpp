#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <lamap_mrpt/learned_map/occupied_cells.h>

#include <algorithm>
#include <tuple>

namespace lamap
{
namespace
{
using mrpt::maps::CSimplePointsMap;

/// A copy with its tree and box already computed, so that its const methods only read.
template <typename BuildTree>
std::shared_ptr<const CSimplePointsMap> searchable(const CSimplePointsMap& points, BuildTree&& buildTree)
{
  auto copy = std::make_shared<CSimplePointsMap>(points);
  if (!copy->empty()) buildTree(*copy);
  copy->boundingBox();
  return copy;
}

constexpr auto kAlways = [](const CSimplePointsMap&) { return true; };
}  // namespace

OccupiedCells::OccupiedCells(const CLearnedMap& map) : thresholds_(map.stateThresholds())
{
  std::vector<CellIndex> cells;
  map.visitCells(
      [&](const CellIndex& cell, const CellEstimate& estimate)
      {
        if (estimate.state == CellState::Occupied) cells.push_back(cell);
      });
  std::sort(cells.begin(), cells.end(),
            [](const CellIndex& a, const CellIndex& b)
            { return std::tie(a.z, a.y, a.x) < std::tie(b.z, b.y, b.x); });
  points_.reserve(cells.size());
  for (const CellIndex& cell : cells)
  {
    const Eigen::Vector3f centre = cellCentre(cell, map.resolution()).cast<float>();
    points_.insertPoint(centre.x(), centre.y(), centre.z());
  }
  points_.boundingBox();
}

std::shared_ptr<const CSimplePointsMap> OccupiedCells::forPlane() const
{
  return forPlane_.get(kAlways,
                       [&]
                       {
                         return searchable(points_,
                                           [](const CSimplePointsMap& copy)
                                           {
                                             float squaredDistance = 0;
                                             copy.kdTreeClosestPoint2D(0, 0, squaredDistance);
                                           });
                       });
}

std::shared_ptr<const CSimplePointsMap> OccupiedCells::forSpace() const
{
  return forSpace_.get(kAlways,
                       [&]
                       {
                         return searchable(points_,
                                           [](const CSimplePointsMap& copy)
                                           {
                                             float squaredDistance = 0;
                                             copy.kdTreeClosestPoint3D(0, 0, 0, squaredDistance);
                                           });
                       });
}

ObservedBox::ObservedBox(const CLearnedMap& map)
{
  map.visitCells(
      [&](const CellIndex& cell, const CellEstimate&)
      {
        if (!any) low = high = cell;
        any = true;
        low = {std::min(low.x, cell.x), std::min(low.y, cell.y), std::min(low.z, cell.z)};
        high = {std::max(high.x, cell.x), std::max(high.y, cell.y), std::max(high.z, cell.z)};
      });
}

}  // namespace lamap
