#include <lamap_core/training/covariance.h>
#include <lamap_core/training/point_width.h>

namespace lamap
{
PoseWidth::PoseWidth(const Scan::PoseCovariance& pose, bool planar) : axes_(planar ? 2 : 3)
{
  requireCovariance(pose, "covariance of the pose");
  // A point at p from the sensor moves by t + ω × p.
  const Eigen::Matrix3d ofTranslation = pose.topLeftCorner<3, 3>();
  const Eigen::Matrix3d shared = pose.topRightCorner<3, 3>();
  Eigen::Matrix3d ofRotation = pose.bottomRightCorner<3, 3>();
  translation_ = ofTranslation(0, 0) + ofTranslation(1, 1) + (planar ? 0 : ofTranslation(2, 2));
  if (planar)
  {
    mixed_ = {shared(1, 2), -shared(0, 2), 0};
    rotation_.setZero();
    rotation_(0, 0) = rotation_(1, 1) = ofRotation(2, 2);
    return;
  }
  mixed_ = {shared(1, 2) - shared(2, 1), shared(2, 0) - shared(0, 2), shared(0, 1) - shared(1, 0)};
  rotation_ = -ofRotation;
  rotation_.diagonal().array() += ofRotation(0, 0) + ofRotation(1, 1) + ofRotation(2, 2);
}

RayWidth PoseWidth::along(const Eigen::Vector3d& centre_map, const Eigen::Vector3d& direction_map) const
{
  const auto product = [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b)
  {
    // Without Eigen's kernels, which may fuse where a processor can.
    double sum = 0;
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column) sum += a[row] * rotation_(row, column) * b[column];
    return sum;
  };
  const auto half = [&](const Eigen::Vector3d& p)
  { return p.x() * mixed_.x() + p.y() * mixed_.y() + p.z() * mixed_.z(); };
  RayWidth width;
  width.constant = (translation_ + 2 * half(centre_map) + product(centre_map, centre_map)) / axes_;
  width.linear = 2 * (half(direction_map) + product(direction_map, centre_map)) / axes_;
  width.square = product(direction_map, direction_map) / axes_;
  return width;
}

}  // namespace lamap
