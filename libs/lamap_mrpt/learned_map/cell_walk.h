#pragma once

#include <lamap_core/grid/cell.h>

#include <Eigen/Core>
#include <cmath>
#include <limits>

namespace lamap
{
/** Visits the cells that a ray passes through, in order (Amanatides and Woo 1987).
 *
 * Each crossing is computed from the cell's own faces, not accumulated, so that errors do not grow along the
 * ray.
 *
 * @param origin_m, direction  the ray; the direction may have any length > 0, which is the unit of t
 * @param tFirst, tLast  the part of origin + t·direction to follow; a cell is visited if it is entered at t ≤
 * tLast
 * @param visit bool(const CellIndex&): false ends the walk
 * Does nothing for a ray that is not finite or that starts beyond addressable cells. */
template <typename Visit>
void walkCells(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction, double resolution_m,
               double tFirst, double tLast, Visit&& visit)
{
  if (!origin_m.allFinite() || !direction.allFinite() || !(direction.squaredNorm() > 0)) return;
  const Eigen::Vector3d start_m = origin_m + tFirst * direction;
  const Eigen::Vector3d origin_cells = origin_m / resolution_m;
  const Eigen::Vector3d direction_cells = direction / resolution_m;
  auto cell = cellAt(start_m, resolution_m);
  double t = tFirst;
  while (cell && t <= tLast)
  {
    if (!visit(*cell)) return;
    const Eigen::Vector3d lowFaces(cell->x, cell->y, cell->z);
    int nextAxis = 0;
    double nextT = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis)
    {
      const double step = direction_cells[axis];
      if (step == 0) continue;
      const double face = lowFaces[axis] + (step > 0 ? 1.0 : 0.0);
      const double crossing = (face - origin_cells[axis]) / step;
      if (crossing >= nextT) continue;
      nextT = crossing;
      nextAxis = axis;
    }
    if (!std::isfinite(nextT)) return;
    t = nextT;
    int32_t& index = nextAxis == 0 ? cell->x : (nextAxis == 1 ? cell->y : cell->z);
    constexpr int32_t kLimit = 2147000000;
    if (index <= -kLimit || index >= kLimit) return;
    index += direction_cells[nextAxis] > 0 ? 1 : -1;
  }
}

}  // namespace lamap
