#include <lamap_mrpt/maps/uncertain_inputs.h>
#include <lamap_mrpt/observations/isometry.h>
#include <lamap_mrpt/options/map_sections.h>

#include <cmath>

namespace lamap
{
HilbertUncertainty uncertaintyOf(const mrpt::poses::CPose3DPDFGaussian& pose_map)
{
  const mrpt::poses::CPose3D& mean = pose_map.mean;
  const double yaw = mean.yaw();
  const double pitch = mean.pitch();
  // A small change of an angle turns about the axis that the rotations before it have brought there.
  Eigen::Matrix<double, 6, 6> jacobian = Eigen::Matrix<double, 6, 6>::Identity();
  jacobian.block<3, 1>(3, 3) = Eigen::Vector3d::UnitZ();
  jacobian.block<3, 1>(3, 4) = Eigen::Vector3d(-std::sin(yaw), std::cos(yaw), 0);
  jacobian.block<3, 1>(3, 5) =
      Eigen::Vector3d(std::cos(yaw) * std::cos(pitch), std::sin(yaw) * std::cos(pitch), -std::sin(pitch));
  const Eigen::Matrix<double, 6, 6> ofAngles = pose_map.cov.asEigen();
  HilbertUncertainty uncertainty;
  uncertainty.pose = jacobian * ofAngles * jacobian.transpose();
  // Exactly symmetric, whatever rounding did.
  uncertainty.pose = (0.5 * (uncertainty.pose + uncertainty.pose.transpose())).eval();
  uncertainty.centre = {mean.x(), mean.y(), mean.z()};
  return uncertainty;
}

std::optional<HilbertUncertainty> uncertaintyOf(const UncertainInputs& inputs,
                                                const CLearnedMap::ScanPose& pose)
{
  if (inputs.usePoseCovariance && (!pose.robot_map || pose.robot_map->cov.asEigen().isZero(0)))
    warnOnce(
        "insertOpts.usePoseCovariance = true: the pose of a scan came without a covariance, or with one of "
        "zero; "
        "such scans count as certain");
  HilbertUncertainty uncertainty;
  // Where the pose is no place the rays are left out anyway.
  if (inputs.usePoseCovariance && pose.robot_map && isometryOf(pose.robot_map->mean).matrix().allFinite())
    uncertainty = uncertaintyOf(*pose.robot_map);
  uncertainty.rangeStd_m = inputs.rangeStd;
  uncertainty.point = Eigen::Matrix3d::Identity() * (inputs.pointStd * inputs.pointStd);
  if (!uncertainty.any()) return std::nullopt;
  return uncertainty;
}

}  // namespace lamap
