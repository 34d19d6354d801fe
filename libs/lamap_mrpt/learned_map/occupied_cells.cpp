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

namespace
{
BlockIndex cubeOf(const CellIndex& cell, int level)
{
  return {cell.x >> level, cell.y >> level, cell.z >> level};
}
}  // namespace

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
  for (const CellIndex& cell : cells)
    for (size_t i = 0; i < cubes_.size(); ++i) cubes_[i].insert(cubeOf(cell, kCubeLevels[i]));
}

int OccupiedCells::emptyAround(const CellIndex& cell) const
{
  int empty = 0;
  for (size_t i = 0; i < cubes_.size(); ++i)
  {
    const BlockIndex cube = cubeOf(cell, kCubeLevels[i]);
    for (int32_t z = cube.z - 1; z <= cube.z + 1; ++z)
      for (int32_t y = cube.y - 1; y <= cube.y + 1; ++y)
        for (int32_t x = cube.x - 1; x <= cube.x + 1; ++x)
          if (cubes_[i].count({x, y, z}) > 0) return empty;
    empty = kCubeLevels[i];
  }
  return empty;
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
