#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

namespace lamap
{
/** Angles of four vectors (x, y) from the x axis [rad], in [−π, π], error below 1e-5; 0 for the origin.
 *
 * Uses only additions, multiplications and divisions, each rounded separately: the same on every
 * processor. */
[[nodiscard]] Eigen::Array4f anglesOf(const Eigen::Array4f& y, const Eigen::Array4f& x);

/// Directions whose angles are found at once, which takes a fraction of the time.
struct DirectionBatch
{
  static constexpr size_t kMost = 64;
  using Numbers = std::array<float, kMost>;

  size_t count = 0;
  Numbers x, y, z;
  Numbers azimuth, elevation;  ///< [rad] set by findAngles()

  /// Its length does not matter. @param direction finite and not zero
  void add(const Eigen::Vector3d& direction);
  [[nodiscard]] bool full() const { return count == kMost; }
};

/// Sets azimuths and elevations, each as anglesOf() gives it.
void findAngles(DirectionBatch& directions);

}  // namespace lamap
