#include <lamap_sim/trajectory.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace lamap::sim
{
namespace
{
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kTwoPi = 6.283185307179586;

double lengthOf(const Vector2d& v)
{
  return std::sqrt(v.x() * v.x() + v.y() * v.y());
}

/// A polyline, parametrized by the distance from its start.
class Path
{
 public:
  explicit Path(const World& world) : corners_(world.path_map), heading_(world.heading_rad)
  {
    for (size_t i = 1; i < corners_.size(); ++i)
      distances_.push_back(distances_.back() + lengthOf(corners_[i] - corners_[i - 1]));
  }

  [[nodiscard]] double length() const { return distances_.back(); }

  [[nodiscard]] Vector2d at(double distance) const
  {
    if (corners_.size() < 2) return corners_.front();
    const size_t piece = pieceAt(distance);
    const double pieceLength = distances_[piece + 1] - distances_[piece];
    const double share =
        pieceLength > 0 ? std::clamp((distance - distances_[piece]) / pieceLength, 0.0, 1.0) : 0;
    return corners_[piece] + share * (corners_[piece + 1] - corners_[piece]);
  }

  /// Direction of the point half a metre ahead; at the end, and where the path turns back, that of the
  /// segment.
  [[nodiscard]] double headingAt(double distance) const
  {
    if (corners_.size() < 2) return heading_;
    constexpr double kAhead_m = 0.5;
    constexpr double kTooNear_m = 0.3;
    Vector2d ahead = at(distance + kAhead_m) - at(distance);
    const size_t piece = pieceAt(distance);
    if (lengthOf(ahead) < kTooNear_m) ahead = corners_[piece + 1] - corners_[piece];
    // Rounded to a grid of angles, so that it does not depend on the last bit of the processor's atan2.
    return std::ldexp(std::nearbyint(std::ldexp(std::atan2(ahead.y(), ahead.x()), 20)), -20);
  }

 private:
  [[nodiscard]] size_t pieceAt(double distance) const
  {
    size_t piece = 0;
    while (piece + 2 < corners_.size() && distances_[piece + 1] <= distance) ++piece;
    return piece;
  }

  const std::vector<Vector2d>& corners_;
  double heading_;
  std::vector<double> distances_{0.0};
};

Pose poseOn(const Path& path, double share, double z)
{
  Pose pose;
  const double distance = share * path.length();
  const Vector2d place = path.at(distance);
  pose.position_map = {place.x(), place.y(), z};
  pose.yaw_rad = path.headingAt(distance);
  return pose;
}
}  // namespace

Eigen::Matrix3d rotationOf(const Pose& pose)
{
  const auto [sy, cy] = sineCosine(pose.yaw_rad);
  const auto [sp, cp] = sineCosine(pose.pitch_rad);
  const auto [sr, cr] = sineCosine(pose.roll_rad);
  Eigen::Matrix3d rotation;
  rotation << cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr,  //
      sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr,          //
      -sp, cp * sr, cp * cr;
  return rotation;
}

Quaternion quaternionOf(const Pose& pose)
{
  const auto [sy, cy] = sineCosine(pose.yaw_rad / 2);
  const auto [sp, cp] = sineCosine(pose.pitch_rad / 2);
  const auto [sr, cr] = sineCosine(pose.roll_rad / 2);
  Quaternion q{cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy,
               cr * cp * sy - sr * sp * cy};
  if (q.w < 0) q = {-q.w, -q.x, -q.y, -q.z};
  return q;
}

double sensorHeight(const World& world, const SensorModel& sensor)
{
  return world.sensorZ_map.value_or(world.interior_map.min().z() + sensor.height_m);
}

std::vector<Pose> makeTrajectory(const World& world, const SensorModel& sensor, Motion motion, int scans)
{
  if (scans < 1) throw std::invalid_argument("scans = " + std::to_string(scans) + ": must be 1 or more");
  const Path path(world);
  const double z = sensorHeight(world, sensor);
  const int shots = scans * sensor.pingsPerScan;
  // At a single place there is no path to follow: all scans have the same pose.
  const int headings = world.path_map.size() > 1 ? sensor.headingsPerStop : 1;
  const int perPlace = motion == Motion::Driving ? 1 : sensor.pingsPerScan * headings;
  const int places = (shots + perPlace - 1) / perPlace;
  std::vector<Pose> poses;
  poses.reserve(static_cast<size_t>(shots));
  for (int i = 0; i < shots; ++i)
  {
    const int place = i / perPlace;
    const double share = places > 1 ? static_cast<double>(place) / (places - 1) : 0;
    Pose pose = poseOn(path, share, z);
    if (motion == Motion::Stops && headings > 1)
    {
      const int turn = i / sensor.pingsPerScan % headings;
      pose.yaw_rad = std::remainder(pose.yaw_rad + kTwoPi * turn / headings, kTwoPi);
    }
    poses.push_back(pose);
  }
  return poses;
}

}  // namespace lamap::sim
