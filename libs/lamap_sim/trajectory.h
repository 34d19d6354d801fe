#pragma once

#include <lamap_sim/random.h>
#include <lamap_sim/sensor.h>
#include <lamap_sim/world.h>

#include <Eigen/Core>
#include <vector>

namespace lamap::sim
{
/** A pose in the map: rotated by the roll about x, then the pitch about y (positive looks down), then the yaw
 * about z, then translated. */
struct Pose
{
  Eigen::Vector3d position_map = Eigen::Vector3d::Zero();
  double yaw_rad = 0;
  double pitch_rad = 0;
  double roll_rad = 0;
};

/// The rotation of a pose, from its own frame to the map's; the same bits on every processor.
[[nodiscard]] Eigen::Matrix3d rotationOf(const Pose& pose);

/// A unit quaternion with w ≥ 0.
struct Quaternion
{
  double w = 1, x = 0, y = 0, z = 0;
};
[[nodiscard]] Quaternion quaternionOf(const Pose& pose);

/// How a sensor moves along a world's path.
enum class Motion
{
  Stops,   ///< stops at equal distances and scans there, all around if its field of view is a sector
  Driving  ///< scans at equal distances, looking ahead
};

/** The sensor's pose in each scan, from the first corner of the world's path to its last. For sonars, one
 * pose per ping, `scans` × pingsPerScan. If the path is a single place, all poses are equal.
 * @param scans  ≥ 1
 * @throws std::invalid_argument if scans < 1 */
[[nodiscard]] std::vector<Pose> makeTrajectory(const World& world, const SensorModel& sensor, Motion motion,
                                               int scans);

/// The height of a sensor in a world, z in the map [m].
[[nodiscard]] double sensorHeight(const World& world, const SensorModel& sensor);

}  // namespace lamap::sim
