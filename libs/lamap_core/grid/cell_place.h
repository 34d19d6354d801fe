#pragma once

#include <lamap_core/grid/cell.h>

namespace lamap
{
/** Finds the cells at points: as cellAt(), for sources of the library that ask for many. Multiplies where it
 * can be sure of the cell, which is quicker than to divide. */
class CellFinder
{
 public:
  explicit CellFinder(double resolution_m) : resolution_m_(resolution_m), perMetre_(1 / resolution_m) {}

  /// @return whether there is such a cell
  [[nodiscard]] bool find(const Eigen::Vector3d& point_m, CellIndex& cell) const
  {
    return find(point_m.x(), cell.x) && find(point_m.y(), cell.y) && find(point_m.z(), cell.z);
  }

 private:
  [[nodiscard]] bool find(double place_m, int32_t& index) const
  {
    // The product is off by less than three roundings, so that within 1e9 cells its floor is right unless it
    // is nearly a whole number.
    constexpr double kFar = 1e9;
    constexpr double kNearlyWhole = 1e-6;
    const double product = place_m * perMetre_;
    if (product > -kFar && product < kFar)
    {
      index = floorOf(product);
      const double past = product - index;
      if (past > kNearlyWhole && past < 1 - kNearlyWhole) return true;
    }
    const double coordinate = place_m / resolution_m_;
    // Leaves room for a kernel's reach around every valid cell.
    constexpr double kLimit = 2140000000.0;
    if (!(coordinate >= 1 - kLimit && coordinate < kLimit)) return false;
    index = floorOf(coordinate);
    return true;
  }

  /// std::floor() is a call where the architecture's baseline has no instruction for it.
  static int32_t floorOf(double coordinate)
  {
    const auto towardsZero = static_cast<int32_t>(coordinate);
    return towardsZero - (coordinate < towardsZero ? 1 : 0);
  }

  double resolution_m_;
  double perMetre_;
};

}  // namespace lamap
