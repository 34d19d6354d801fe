#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace lamap::tools
{
/// In which frame the points of PCD files are.
enum class CloudFrame
{
  Map,
  Sensor  ///< and the pose of the scan turns them into the map's
};

/** Watches clouds that are taken to be in one frame, and tells if they look as if they were in the other.
 *
 * Two things tell the frames apart. A sensor sends its rays in much the same directions in each scan, or in
 * those of some earlier scan: seen from where the sensor was, clouds are alike. And what one scan has seen
 * through holds no point of another. Both hold in the right frame only, once the sensor has moved.
 *
 * Keeps a sample of clouds from all along the way. */
class CloudFrameWatch
{
 public:
  explicit CloudFrameWatch(CloudFrame taken) : taken_(taken) {}

  /** One cloud.
   * @param pose_map       of the frame in which the sensor is at sensorOrigin [m]
   * @param points         as the file gives them [m] */
  void add(const Eigen::Isometry3d& pose_map, const Eigen::Vector3d& sensorOrigin,
           const std::vector<Eigen::Vector3d>& points);

  /// What to say about all clouds so far; nothing if they may well be in the frame that they are taken to be.
  [[nodiscard]] std::optional<std::string> suspicion() const;

 private:
  using Pose = Eigen::Transform<double, 3, Eigen::Isometry, Eigen::DontAlign>;

  /// A part of a cloud's points.
  struct Sample
  {
    Pose pose_map;
    Eigen::Vector3d sensorOrigin;
    std::vector<Eigen::Vector3d> points;
  };

  void keep(const Sample& sample);

  CloudFrame taken_;
  size_t clouds_ = 0;
  std::optional<Pose> first_map_;
  double moved_m_ = 0;     ///< farthest from the first pose
  double turned_rad_ = 0;  ///< the largest turn from the first pose
  std::vector<Sample> samples_;
  size_t stride_ = 1;   ///< every Nth of the clouds from other poses is kept
  size_t offered_ = 0;  ///< of those
};

}  // namespace lamap::tools
