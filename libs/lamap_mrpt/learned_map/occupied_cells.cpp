#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <lamap_mrpt/learned_map/occupied_cells.h>

#include <algorithm>
#include <tuple>

namespace lamap
{
std::vector<CellIndex> sortedOccupiedCells(const CLearnedMap& map)
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
  return cells;
}

OccupiedCells::OccupiedCells(const CLearnedMap& map) : thresholds_(map.stateThresholds())
{
  const std::vector<CellIndex> cells = sortedOccupiedCells(map);
  points_.reserve(cells.size());
  for (const CellIndex& cell : cells)
  {
    const Eigen::Vector3f centre = cellCentre(cell, map.resolution()).cast<float>();
    points_.insertPoint(centre.x(), centre.y(), centre.z());
  }
  points_.boundingBox();
}

std::shared_ptr<const mrpt::maps::CSimplePointsMap> OccupiedCells::searchable(bool plane) const
{
  return searchable_[plane ? 0 : 1].get(
      [&]
      {
        auto copy = std::make_shared<mrpt::maps::CSimplePointsMap>(points_);
        // Computes the tree and the box, so that const methods only read.
        float squaredDistance = 0;
        if (plane && !copy->empty()) copy->kdTreeClosestPoint2D(0, 0, squaredDistance);
        if (!plane && !copy->empty()) copy->kdTreeClosestPoint3D(0, 0, 0, squaredDistance);
        copy->boundingBox();
        return copy;
      });
}

ObservedBox::ObservedBox(const CLearnedMap& map)
{
  const auto bounds = map.cellBounds();
  if (!bounds) return;
  any = true;
  std::tie(low, high) = *bounds;
}

}  // namespace lamap
