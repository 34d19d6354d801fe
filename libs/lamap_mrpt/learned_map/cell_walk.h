#pragma once

#include <lamap_core/grid/cell.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
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
 * @param emptyAround int(const CellIndex&): the cell lies in a cube of 2^n cells, aligned to its size, of
 * which no other cell need be visited but the one where the walk ends; 0 for the cell alone Does nothing for
 * a ray that is not finite or that starts beyond addressable cells. */
template <typename Visit, typename EmptyAround>
void walkCells(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction, double resolution_m,
               double tFirst, double tLast, Visit&& visit, EmptyAround&& emptyAround)
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
    const int64_t edge = int64_t{1} << emptyAround(*cell);
    const auto lowOf = [&](int32_t index) { return int64_t{index} & ~(edge - 1); };
    const std::array<int64_t, 3> low{lowOf(cell->x), lowOf(cell->y), lowOf(cell->z)};
    size_t nextAxis = 0;
    double nextT = std::numeric_limits<double>::infinity();
    for (size_t axis = 0; axis < 3; ++axis)
    {
      const double step = direction_cells[static_cast<int>(axis)];
      if (step == 0) continue;
      const auto face = static_cast<double>(step > 0 ? low[axis] + edge : low[axis]);
      const double crossing = (face - origin_cells[static_cast<int>(axis)]) / step;
      if (crossing >= nextT) continue;
      nextT = crossing;
      nextAxis = axis;
    }
    if (!std::isfinite(nextT)) return;
    // Where the ray leaves the cube, or ends in it.
    const double leftAt = std::min(nextT, tLast);
    std::array<int64_t, 3> next{cell->x, cell->y, cell->z};
    for (size_t axis = 0; axis < 3 && edge > 1; ++axis)
    {
      const int i = static_cast<int>(axis);
      const double place = std::floor(origin_cells[i] + leftAt * direction_cells[i]);
      next[axis] = static_cast<int64_t>(
          std::clamp(place, static_cast<double>(low[axis]), static_cast<double>(low[axis] + edge - 1)));
    }
    if (nextT <= tLast)
      next[nextAxis] =
          direction_cells[static_cast<int>(nextAxis)] > 0 ? low[nextAxis] + edge : low[nextAxis] - 1;
    constexpr int64_t kLimit = 2147000000;
    if (std::any_of(next.begin(), next.end(), [](int64_t i) { return i < -kLimit || i > kLimit; })) return;
    cell = {static_cast<int32_t>(next[0]), static_cast<int32_t>(next[1]), static_cast<int32_t>(next[2])};
    if (nextT > tLast)
    {
      if (edge > 1) visit(*cell);
      return;
    }
    t = nextT;
  }
}

/// Visits every cell.
template <typename Visit>
void walkCells(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction, double resolution_m,
               double tFirst, double tLast, Visit&& visit)
{
  walkCells(origin_m, direction, resolution_m, tFirst, tLast, visit, [](const CellIndex&) { return 0; });
}

}  // namespace lamap
