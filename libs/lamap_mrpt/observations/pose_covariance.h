#pragma once

#include <lamap_core/scan/scan.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>

#include <Eigen/Core>

namespace lamap
{
/** The covariance of a sensor's pose as a Scan has it.
 * @param robotPose_map with MRPT's covariance of (x, y, z, yaw, pitch, roll) [m, rad]
 * @param sensor_map where the sensor is, rigidly on the robot [m] */
[[nodiscard]] Scan::PoseCovariance covarianceOfSensor(const mrpt::poses::CPose3DPDFGaussian& robotPose_map,
                                                      const Eigen::Vector3d& sensor_map);

}  // namespace lamap
