#pragma once

#include <lamap_sim/random.h>
#include <lamap_sim/sensor.h>
#include <lamap_sim/world.h>

#include <Eigen/Core>
#include <vector>

namespace lamap::sim
{
/** A pose in the map: turned by the roll about x, then the pitch about y, then the yaw about z (positive
 * pitch looks down), then moved. */
struct Pose
{
  Eigen::Vector3d position_map = Eigen::Vector3d::Zero();
  double yaw_rad = 0;
  double pitch_rad = 0;
  double roll_rad = 0;
};

/// The rotation of a pose, from its own frame to the map's; the same bits on every processor.
[[nodiscard]] Eigen::Matrix3d rotationOf(const Pose& pose);

/// A unit quaternion, w not negative.
struct Quaternion
{
  double w = 1, x = 0, y = 0, z = 0;
};
[[nodiscard]] Quaternion quaternionOf(const Pose& pose);

/// How a sensor goes along a world's path.
enum class Motion
{
  Stops,   ///< stands still at places equally far apart and scans there, a full turn where its view is a
           ///< sector
  Driving  ///< scans at equal distances, looking ahead
};

/** Where the sensor stands in each scan, from the first corner of the world's path to its last. For sonars
 * one pose a ping, `scans` × pingsPerScan. Where the path is a single place, all poses are equal.
 * @param scans  ≥ 1
 * @throws std::invalid_argument if scans < 1 */
[[nodiscard]] std::vector<Pose> makeTrajectory(const World& world, const SensorModel& sensor, Motion motion,
                                               int scans);

/// The height at which a sensor stands in a world, z in the map [m].
[[nodiscard]] double sensorHeight(const World& world, const SensorModel& sensor);

}  // namespace lamap::sim
