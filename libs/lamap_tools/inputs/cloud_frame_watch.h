#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace lamap::tools
{
/** Watches clouds that are taken to be in the map's frame, and tells if they look as if they were in the
 * sensor's.
 *
 * A sensor sends its rays in much the same directions in each scan. Seen from the poses, points in the map's
 * frame therefore lie in the same directions, and seen from the file's origin they do not, if the sensor has
 * moved. For points in the sensor's frame it is the other way round. */
class CloudFrameWatch
{
 public:
  /** One cloud.
   * @param pose_map       of the frame in which the sensor is at sensorOrigin [m]
   * @param points         as the file gives them [m] */
  void add(const Eigen::Isometry3d& pose_map, const Eigen::Vector3d& sensorOrigin,
           const std::vector<Eigen::Vector3d>& points);

  /// What to say about all clouds so far; nothing if they may well be in the map's frame.
  [[nodiscard]] std::optional<std::string> suspicion() const;

 private:
  static constexpr size_t kBins = 24 * 12;  // of 15 degrees
  /// Share of a cloud's points in each direction.
  using Directions = std::array<double, kBins>;
  /// A cloud as a sensor has it.
  struct View
  {
    Directions directions{};
    double meanRange_m = 0;
  };
  template <class Vector>
  static View viewOf(const std::vector<Eigen::Vector3d>& points, const Vector& fromSensor);

  struct FirstCloud
  {
    Eigen::Isometry3d pose_map;
    Directions ifInSensorFrame;
    Directions ifInMapFrame;
  };
  std::optional<FirstCloud> first_;
  size_t clouds_ = 0;
  double moved_m_ = 0;          ///< farthest from the first pose
  double turned_rad_ = 0;       ///< the largest turn from the first pose
  double ifInSensorFrame_ = 0;  ///< differences to the first cloud's directions, summed
  double ifInMapFrame_ = 0;
  double rangesIfInSensorFrame_m_ = 0;  ///< of all clouds, summed
  double rangesIfInMapFrame_m_ = 0;
};

}  // namespace lamap::tools
