#include <lamap_mrpt/observations/pose_covariance.h>

#include <cmath>

namespace lamap
{
Scan::PoseCovariance covarianceOfSensor(const mrpt::poses::CPose3DPDFGaussian& robotPose_map,
                                        const Eigen::Vector3d& sensor_map)
{
  const mrpt::poses::CPose3D& mean = robotPose_map.mean;
  const double yaw = mean.yaw();
  const double pitch = mean.pitch();
  // A small change of an angle turns about the axis that the rotations before it have brought there.
  Eigen::Matrix3d turn;
  turn.col(0) = Eigen::Vector3d::UnitZ();
  turn.col(1) = Eigen::Vector3d(-std::sin(yaw), std::cos(yaw), 0);
  turn.col(2) =
      Eigen::Vector3d(std::cos(yaw) * std::cos(pitch), std::sin(yaw) * std::cos(pitch), -std::sin(pitch));
  // The turn ω moves the sensor by ω × arm.
  const Eigen::Vector3d arm = sensor_map - Eigen::Vector3d(mean.x(), mean.y(), mean.z());
  Eigen::Matrix<double, 6, 6> jacobian = Eigen::Matrix<double, 6, 6>::Identity();
  jacobian.block<3, 3>(3, 3) = turn;
  for (int angle = 0; angle < 3; ++angle)
    jacobian.block<3, 1>(0, 3 + angle) = Eigen::Vector3d(turn.col(angle)).cross(arm);
  const Eigen::Matrix<double, 6, 6> ofAngles = robotPose_map.cov.asEigen();
  const Eigen::Matrix<double, 6, 6> covariance = jacobian * ofAngles * jacobian.transpose();
  // Exactly symmetric, whatever rounding did.
  return 0.5 * (covariance + covariance.transpose());
}

}  // namespace lamap
