#include <lamap_core/grid/cell.h>

#include <lamap_core/grid/cell_place.h>

#include <algorithm>
#include <cmath>

// Here and not in the header: the flags of whoever includes it must not change a bit of a coordinate.
namespace lamap
{
int32_t heldCell(double coordinate)
{
  if (std::isnan(coordinate)) return 0;
  constexpr double kLast = kLastCell;
  return static_cast<int32_t>(std::clamp(std::floor(coordinate), -kLast, kLast));
}

Eigen::Vector3d cellCentre(const CellIndex& cell, double resolution_m)
{
  return {(cell.x + 0.5) * resolution_m, (cell.y + 0.5) * resolution_m, (cell.z + 0.5) * resolution_m};
}

std::optional<CellIndex> cellAt(const Eigen::Vector3d& point_m, double resolution_m)
{
  CellIndex cell;
  if (!CellFinder(resolution_m).find(point_m, cell)) return std::nullopt;
  return cell;
}

}  // namespace lamap
