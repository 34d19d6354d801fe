#include <lamap_core/grid/cell.h>

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
  std::array<int32_t, 3> index{};
  for (int axis = 0; axis < 3; ++axis)
  {
    const double coordinate = std::floor(point_m[axis] / resolution_m);
    // Leaves room for a kernel's reach around every valid cell.
    constexpr double kLimit = 2140000000.0;
    if (!(coordinate > -kLimit && coordinate < kLimit)) return std::nullopt;
    index[static_cast<size_t>(axis)] = static_cast<int32_t>(coordinate);
  }
  return CellIndex{index[0], index[1], index[2]};
}

}  // namespace lamap
