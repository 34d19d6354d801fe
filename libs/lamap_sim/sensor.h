#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace lamap::sim
{
/// What a sensor's readings are.
enum class SensorKind
{
  Cloud,   ///< a 3D laser: a point for each beam
  Planar,  ///< a 2D laser: a range for each beam of a fan in the plane of x and y
  Sonar    ///< one wide beam that is turned step by step: ranges of the echoes of each ping
};

/** A range sensor. Its frame: x forward, y left, z up; its beams leave from the origin. */
struct SensorModel
{
  std::string name;
  SensorKind kind = SensorKind::Cloud;
  double rangeMax_m = 0;
  /** Unit directions. Planar: from right to left, at equal angles over `aperture_rad`. Sonar: rays that fill
   * the beam about the x axis. */
  std::vector<Eigen::Vector3d> beams;
  double aperture_rad = 0;  ///< Planar: of the whole fan; Sonar: of the beam's cone, edge to edge
  int headingsPerStop = 1;  ///< scans at one stop, turned by equal parts of a full turn
  int pingsPerScan = 1;     ///< Sonar: steps of a sweep all around
  int echoRanks = 0;        ///< Sonar: how many echoes of a ping are kept
  double height_m = 0;      ///< above the floor, where the world does not say
  double period_s = 1;      ///< between scans, or between pings
  int defaultScans = 12;
};

/// All names that makeSensor() knows.
[[nodiscard]] const std::vector<std::string>& sensorNames();

/** A sensor by its name.
 *
 *   sector-laser    3,500 points over 120° × 60°, 8 m; three headings a stop
 *   pan-tilt-laser  89,000 points over 360° × 150°, 30 m
 *   lidar16         16 beams from -15° to 15°, 1,800 steps all around, 100 m
 *   planar-laser    361 beams over 180°, 30 m
 *   sonar           one beam of 15°, 15 m, 120 pings a sweep, up to three echoes a ping with intensities
 *   sonar-range     the same with the first echo alone and no intensity
 *
 * @throws std::invalid_argument for any other name */
[[nodiscard]] SensorModel makeSensor(const std::string& name);

/// How a sonar's head is turned in the frame of what it is mounted on.
struct HeadTurn
{
  double yaw_rad = 0;
  double pitch_rad = 0;  ///< positive: looks down
};
/// Step by step all around in each sweep; every other sweep looks 20° down, at the bottom.
/// @param shot  number of the ping from 0 on
[[nodiscard]] HeadTurn headTurn(const SensorModel& sensor, int shot);

}  // namespace lamap::sim
