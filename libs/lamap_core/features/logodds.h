#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace lamap
{
/// Log-odds at a point, and whether any feature reaches it; exactly 0 where none does.
struct ReachedLogodds
{
  float logodds = 0;
  bool reached = false;
};

/// A weight that was learned, finite and so small that sums of any of them are.
[[nodiscard]] inline float boundedWeight(float weight)
{
  constexpr float kLargestWeight = 1e6f;
  return std::isnan(weight) ? 0.0f : std::clamp(weight, -kLargestWeight, kLargestWeight);
}
/// Whether a weight of a file can be used: earlier versions did not bound them.
[[nodiscard]] inline bool isLegalWeight(float weight)
{
  constexpr float kMost = 1e25f;
  return std::abs(weight) <= kMost;
}

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
