#include <lamap_core/scan/scan.h>

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

}  // namespace lamap
