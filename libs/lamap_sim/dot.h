#pragma once

#include <Eigen/Core>

namespace lamap::sim
{
/// Written out, because Eigen's products may be fused on some processors, and worlds must be the same on all.
[[nodiscard]] inline double dot(const Eigen::Vector3d& a, const Eigen::Vector3d& b)
{
  return a.x() * b.x() + a.y() * b.y() + a.z() * b.z();
}

/// A vector rotated, likewise.
inline Eigen::Vector3d turned(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& v)
{
  Eigen::Vector3d result;
  for (int row = 0; row < 3; ++row)
    result[row] = rotation(row, 0) * v.x() + rotation(row, 1) * v.y() + rotation(row, 2) * v.z();
  return result;
}

}  // namespace lamap::sim
