#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

namespace lamap
{
/// Log-odds at a point, and whether any feature reaches it; exactly 0 where none does.
struct ReachedLogodds
{
  float logodds = 0;
  bool reached = false;
};

/// Points at regular distances along the axes, e.g. centres of cells: first + step·(i, j, k).
struct RegularPoints
{
  Eigen::Vector3d first;  ///< [m]
  double step_m = 0;
  std::array<int, 3> counts{};

  [[nodiscard]] size_t size() const
  {
    return static_cast<size_t>(counts[0]) * static_cast<size_t>(counts[1]) * static_cast<size_t>(counts[2]);
  }
};

}  // namespace lamap
