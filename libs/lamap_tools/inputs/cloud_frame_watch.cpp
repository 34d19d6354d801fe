#include <lamap_tools/inputs/cloud_frame_watch.h>
#include <mrpt/core/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace lamap::tools
{
namespace
{
/// 0: the same; 1: nothing in common.
template <class Shares>
double difference(const Shares& a, const Shares& b)
{
  double common = 0;
  for (size_t i = 0; i < a.size(); ++i) common += std::min(a[i], b[i]);
  return 1 - common;
}
}  // namespace

template <class Vector>
CloudFrameWatch::View CloudFrameWatch::viewOf(const std::vector<Eigen::Vector3d>& points,
                                              const Vector& fromSensor)
{
  constexpr size_t kMostPoints = 4096;
  constexpr double kBin_rad = M_PI / 12;
  // Sensors like round angles: the bins begin beside them, so that rounding does not move points to others.
  constexpr double kBeside_rad = 0.1234;
  View view;
  const size_t step = points.size() / kMostPoints + 1;
  double count = 0;
  for (size_t i = 0; i < points.size(); i += step)
  {
    const Eigen::Vector3d ray = fromSensor(points[i]);
    if (!ray.allFinite() || ray.isZero(1e-3)) continue;
    const double azimuth = std::atan2(ray.y(), ray.x()) + M_PI + kBeside_rad;
    const double elevation = std::atan2(ray.z(), ray.head<2>().norm()) + M_PI / 2 + kBeside_rad;
    const auto column = static_cast<size_t>(azimuth / kBin_rad) % 24;
    const auto row = std::min<size_t>(static_cast<size_t>(elevation / kBin_rad), 11);
    ++view.directions[24 * row + column];
    view.meanRange_m += ray.norm();
    ++count;
  }
  if (count == 0) return view;
  for (double& share : view.directions) share /= count;
  view.meanRange_m /= count;
  return view;
}

void CloudFrameWatch::add(const Eigen::Isometry3d& pose_map, const Eigen::Vector3d& sensorOrigin,
                          const std::vector<Eigen::Vector3d>& points)
{
  const Eigen::Isometry3d toFrame = pose_map.inverse();
  const View ifInSensorFrame =
      viewOf(points, [&](const Eigen::Vector3d& point) { return (point - sensorOrigin).eval(); });
  const View ifInMapFrame =
      viewOf(points, [&](const Eigen::Vector3d& point) { return (toFrame * point - sensorOrigin).eval(); });
  if (ifInSensorFrame.meanRange_m == 0) return;  // not a single point
  ++clouds_;
  rangesIfInSensorFrame_m_ += ifInSensorFrame.meanRange_m;
  rangesIfInMapFrame_m_ += ifInMapFrame.meanRange_m;
  if (!first_)
  {
    first_ = FirstCloud{pose_map, ifInSensorFrame.directions, ifInMapFrame.directions};
    return;
  }
  const Eigen::Isometry3d motion = first_->pose_map.inverse() * pose_map;
  moved_m_ = std::max(moved_m_, motion.translation().norm());
  turned_rad_ = std::max(turned_rad_, std::abs(Eigen::AngleAxisd(motion.linear()).angle()));
  ifInSensorFrame_ += difference(ifInSensorFrame.directions, first_->ifInSensorFrame);
  ifInMapFrame_ += difference(ifInMapFrame.directions, first_->ifInMapFrame);
}

std::optional<std::string> CloudFrameWatch::suspicion() const
{
  constexpr double kStands_m = 0.1;
  constexpr double kStands_rad = 0.1;
  if (clouds_ < 2 || (moved_m_ < kStands_m && turned_rad_ < kStands_rad)) return std::nullopt;
  // Clouds far from the origin all lie in the same direction from it.
  constexpr double kFarther = 2;
  if (rangesIfInSensorFrame_m_ > kFarther * rangesIfInMapFrame_m_) return std::nullopt;
  constexpr double kChance = 0.1;  // how far the directions of any two scans may differ
  constexpr double kClearly = 1.5;
  const double compared = static_cast<double>(clouds_ - 1);
  if (ifInMapFrame_ < kChance * compared || ifInMapFrame_ < kClearly * ifInSensorFrame_) return std::nullopt;
  return mrpt::format(
      "all %zu clouds lie about their own origin while the poses move by %.1f m and turn by %.0f degrees, "
      "but their points were taken to be in the map's frame: if they are in the sensor's frame, give "
      "--cloud-frame sensor",
      clouds_, moved_m_, turned_rad_ * 180 / M_PI);
}

}  // namespace lamap::tools
