#pragma once

#include <mrpt/poses/CPose3D.h>

#include <Eigen/Geometry>

namespace lamap
{
/// Conversions between MRPT's poses and Eigen's.
[[nodiscard]] inline Eigen::Isometry3d isometryOf(const mrpt::poses::CPose3D& pose)
{
  Eigen::Isometry3d isometry = Eigen::Isometry3d::Identity();
  isometry.linear() = pose.getRotationMatrix().asEigen();
  isometry.translation() = Eigen::Vector3d(pose.x(), pose.y(), pose.z());
  return isometry;
}

[[nodiscard]] inline mrpt::poses::CPose3D poseOf(const Eigen::Isometry3d& isometry)
{
  const Eigen::Matrix3d rotation = isometry.linear();
  const Eigen::Vector3d translation = isometry.translation();
  return {mrpt::math::CMatrixDouble33(rotation), mrpt::math::CVectorFixedDouble<3>(translation)};
}

}  // namespace lamap
