#include <lamap_core/scan/scan.h>

#include <stdexcept>

// Here and not in the header: the flags of whoever includes it must not change a bit of a coordinate.
namespace lamap
{
Eigen::Vector3d Scan::inMap(const Eigen::Vector3d& point) const
{
  return sensorPose_map * point;
}

Eigen::Vector3d Scan::turnedToMap(const Eigen::Vector3d& vector) const
{
  return sensorPose_map.linear() * vector;
}

bool isLegalBeam(const Beam& beam)
{
  constexpr double kMost = 1e6;
  const auto isLegal = [](double number) { return number >= 0 && number <= kMost; };
  return isLegal(beam.halfWidth_rad) && isLegal(beam.halfHeight_rad) && isLegal(beam.rangeStd_m) &&
         (beam.up.array().abs() <= kMost).all();
}

void Scan::requireRigidPose() const
{
  if (sensorPose_map.matrix().allFinite() && !isRotation(sensorPose_map.linear()))
    throw std::invalid_argument("the pose of the scan has a rotation matrix that is not orthonormal");
}

bool isRotation(const Eigen::Matrix3d& matrix)
{
  constexpr double kTolerance = 1e-6;
  return (matrix.transpose() * matrix - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < kTolerance &&
         matrix.determinant() > 0;
}

}  // namespace lamap
