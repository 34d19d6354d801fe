#pragma once

#include <Eigen/Core>

namespace lamap::sim
{
/// Written out, because Eigen's products may be fused on some processors, and worlds must be the same on all.
[[nodiscard]] inline double dot(const Eigen::Vector3d& a, const Eigen::Vector3d& b)
{
  return a.x() * b.x() + a.y() * b.y() + a.z() * b.z();
}

}  // namespace lamap::sim
