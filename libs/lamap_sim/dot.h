#pragma once

#include <Eigen/Core>

namespace lamap::sim
{
/// Written out: Eigen's products may be fused on some processors, and worlds are to be the same on all.
[[nodiscard]] inline double dot(const Eigen::Vector3d& a, const Eigen::Vector3d& b)
{
  return a.x() * b.x() + a.y() * b.y() + a.z() * b.z();
}

}  // namespace lamap::sim
