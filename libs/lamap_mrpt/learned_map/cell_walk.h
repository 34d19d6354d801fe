#pragma once

#include <lamap_core/grid/cell.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

namespace lamap
{
/** The cells that a ray passes through, in order (Amanatides and Woo 1987).
 *
 * Each crossing is computed from the cell's own faces, not accumulated, so that errors do not grow along the
 * ray. Of crossings at the same place, that along x comes first, then y, then z. */
class CellWalk
{
 public:
  /// @param origin_m, direction  the ray; the direction may have any length > 0, which is the unit of t
  CellWalk(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction, double resolution_m)
  {
    for (size_t axis = 0; axis < 3; ++axis)
    {
      const int i = static_cast<int>(axis);
      origin_[axis] = origin_m[i] / resolution_m;
      direction_[axis] = direction[i] / resolution_m;
      step_[axis] = direction_[axis] > 0 ? 1 : -1;
      toFace_[axis] = direction_[axis] > 0 ? 1 : 0;
    }
  }

  void start(const CellIndex& cell)
  {
    cell_ = {cell.x, cell.y, cell.z};
    for (size_t axis = 0; axis < 3; ++axis) findCrossing(axis);
  }
  [[nodiscard]] CellIndex cell() const
  {
    return {static_cast<int32_t>(cell_[0]), static_cast<int32_t>(cell_[1]), static_cast<int32_t>(cell_[2])};
  }

  /// Goes on to the next cell. @param tLast finite
  /// @return false if it is not entered by tLast, or cannot be addressed
  [[nodiscard]] bool advance(double tLast)
  {
    size_t axis = next_[1] < next_[0] ? 1 : 0;
    axis = next_[2] < next_[axis] ? 2 : axis;
    if (!(next_[axis] <= tLast)) return false;
    cell_[axis] += step_[axis];
    next_[axis] = following_[axis];
    following_[axis] = crossingOf(axis, cell_[axis] + step_[axis]);
    return isAddressable(cell_[axis]);
  }

  /// Goes on to the first cell outside a cube of 2^n cells around this one, aligned to its size. @return
  /// false, at the last cell that is entered by tLast, if that one is not; or, where it was, if it cannot be
  /// addressed
  [[nodiscard]] bool leaveCube(int n, double tLast)
  {
    const int64_t edge = int64_t{1} << n;
    std::array<int64_t, 3> last{};  // the last cell in the cube along each axis
    size_t axis = 0;
    std::array<double, 3> leaving{};
    for (size_t i = 0; i < 3; ++i)
    {
      last[i] = (cell_[i] & ~(edge - 1)) + (step_[i] > 0 ? edge - 1 : 0);
      leaving[i] = crossingOf(i, last[i]);
      if (leaving[i] < leaving[axis]) axis = i;
    }
    const double t = leaving[axis];
    const bool isLeft = t <= tLast;
    if (isLeft && !isAddressable(last[axis] + step_[axis])) return false;
    for (size_t i = 0; i < 3; ++i)
    {
      if (isLeft && i == axis)
        cell_[i] = last[i] + step_[i];
      else if (isLeft)
        advanceWithin(i, last[i], t, i < axis);
      else
        advanceWithin(i, last[i], tLast, true);
      findCrossing(i);
    }
    return isLeft;
  }

 private:
  /// Where the ray leaves a cell along an axis.
  [[nodiscard]] double crossingOf(size_t axis, int64_t cell) const
  {
    if (direction_[axis] == 0) return std::numeric_limits<double>::infinity();
    return (static_cast<double>(cell + toFace_[axis]) - origin_[axis]) / direction_[axis];
  }
  void findCrossing(size_t axis)
  {
    next_[axis] = crossingOf(axis, cell_[axis]);
    following_[axis] = crossingOf(axis, cell_[axis] + step_[axis]);
  }

  /// Goes on along one axis, as single steps would until t. @param alsoAt crossings at t itself are before it
  void advanceWithin(size_t axis, int64_t last, double t, bool alsoAt)
  {
    if (direction_[axis] == 0) return;
    const int64_t step = step_[axis];
    const auto isBefore = [&](int64_t cell)
    {
      const double crossing = crossingOf(axis, cell);
      return alsoAt ? crossing <= t : crossing < t;
    };
    const auto [low, high] = std::minmax(cell_[axis], last);
    const double place = std::floor(origin_[axis] + t * direction_[axis]);
    int64_t cell =
        static_cast<int64_t>(std::clamp(place, static_cast<double>(low), static_cast<double>(high)));
    while (cell != last && isBefore(cell)) cell += step;
    while (cell != cell_[axis] && !isBefore(cell - step)) cell -= step;
    cell_[axis] = cell;
  }

  static bool isAddressable(int64_t index)
  {
    constexpr int64_t kLimit = 2147000000;
    return index >= -kLimit && index <= kLimit;
  }

  std::array<double, 3> origin_;     ///< [cells]
  std::array<double, 3> direction_;  ///< [cells]
  std::array<int64_t, 3> step_;
  std::array<int64_t, 3> toFace_;  ///< from a cell to the face by which the ray leaves it
  std::array<int64_t, 3> cell_{};
  std::array<double, 3> next_{};  ///< t where the ray leaves the cell along each axis
  /// The same of the cell after this one: found a step ahead, so that no step waits for a division.
  std::array<double, 3> following_{};
};

/** Visits the cells that a ray passes through, in order.
 *
 * @param origin_m, direction  the ray; the direction may have any length > 0, which is the unit of t
 * @param tFirst, tLast  the part of origin + t·direction to follow; a cell is visited if it is entered at t ≤
 * tLast
 * @param visit bool(const CellIndex&): false ends the walk
 * @param emptyAround int(const CellIndex&): the cell lies in a cube of 2^n cells, aligned to its size, of
 * which no other cell need be visited but the one where the walk ends; 0 for the cell alone. Does nothing for
 * a ray that is not finite or that starts beyond addressable cells. */
template <typename Visit, typename EmptyAround>
void walkCells(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction, double resolution_m,
               double tFirst, double tLast, Visit&& visit, EmptyAround&& emptyAround)
{
  if (!origin_m.allFinite() || !direction.allFinite() || !(direction.squaredNorm() > 0)) return;
  const auto first = cellAt(origin_m + tFirst * direction, resolution_m);
  if (!first || !(tFirst <= tLast)) return;
  const double tEnd = std::min(tLast, std::numeric_limits<double>::max());
  CellWalk walk(origin_m, direction, resolution_m);
  walk.start(*first);
  while (true)
  {
    const CellIndex cell = walk.cell();
    if (!visit(cell)) return;
    const int empty = emptyAround(cell);
    if (empty == 0)
    {
      if (!walk.advance(tEnd)) return;
    }
    else if (!walk.leaveCube(empty, tEnd))
    {
      if (walk.cell() != cell) visit(walk.cell());
      return;
    }
  }
}

/// Visits every cell.
template <typename Visit>
void walkCells(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction, double resolution_m,
               double tFirst, double tLast, Visit&& visit)
{
  walkCells(origin_m, direction, resolution_m, tFirst, tLast, visit, [](const CellIndex&) { return 0; });
}

/// What came of following a ray.
struct RayWalk
{
  std::optional<CellIndex> last;  ///< the cell visited last; nothing if none was
  bool isMet = false;             ///< it is occupied
};

/// A part of a ray in the map.
struct RayStretch
{
  Eigen::Vector3d origin_m;
  Eigen::Vector3d direction;
  double tFirst = 0;
  double tLast = 0;
  bool ignoreUnknownCells = false;  ///< if false, a cell without evidence ends it
};

/** Follows a ray to the first occupied cell.
 * @param stateOf std::optional<CellState>(const CellIndex&); nothing without evidence
 * @param emptyAround as walkCells() */
template <typename StateOf, typename EmptyAround>
RayWalk followRay(const RayStretch& ray, double resolution_m, StateOf&& stateOf, EmptyAround&& emptyAround)
{
  RayWalk followed;
  const auto visit = [&](const CellIndex& cell)
  {
    followed.last = cell;
    const std::optional<CellState> state = stateOf(cell);
    followed.isMet = state == CellState::Occupied;
    return !followed.isMet && (state || ray.ignoreUnknownCells);
  };
  if (ray.ignoreUnknownCells)
    walkCells(ray.origin_m, ray.direction, resolution_m, ray.tFirst, ray.tLast, visit, emptyAround);
  else
    walkCells(ray.origin_m, ray.direction, resolution_m, ray.tFirst, ray.tLast, visit);
  return followed;
}

}  // namespace lamap
