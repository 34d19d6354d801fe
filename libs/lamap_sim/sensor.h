#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace lamap::sim
{
/// Kinds of readings.
enum class SensorKind
{
  Cloud,   ///< a 3D laser: one point per beam
  Planar,  ///< a 2D laser: one range per beam of a fan in the x-y plane
  Sonar    ///< one wide beam that is turned step by step: ranges of the echoes of each ping
};

/** A range sensor. Its frame: x forward, y left, z up; its beams start at the origin. */
struct SensorModel
{
  std::string name;
  SensorKind kind = SensorKind::Cloud;
  double rangeMax_m = 0;
  /** Unit directions. Planar: from right to left, at equal angles over `aperture_rad`. Sonar: rays that fill
   * the beam about the x axis. */
  std::vector<Eigen::Vector3d> beams;
  double aperture_rad = 0;  ///< Planar: of the whole fan; Sonar: of the beam's cone, edge to edge
  // Cloud: the whole field that the beams sample.
  double azimuthSpan_rad = 0;  ///< centred on the x axis
  double elevationLow_rad = 0;
  double elevationHigh_rad = 0;
  int headingsPerStop = 1;  ///< scans per stop, at headings that divide a full turn equally
  int pingsPerScan = 1;     ///< Sonar: steps of a full sweep
  int echoRanks = 0;        ///< Sonar: number of echoes kept per ping
  double height_m = 0;      ///< above the floor, if the world does not set it
  double period_s = 1;      ///< between scans, or between pings
  int defaultScans = 12;
};

/// All names for makeSensor().
[[nodiscard]] const std::vector<std::string>& sensorNames();

/** A sensor by its name.
 *
 *   sector-laser    3,500 points over 120° × 60°, 8 m; three headings per stop
 *   pan-tilt-laser  89,000 points over 360° × 150°, 30 m
 *   lidar16         16 beams from -15° to 15°, 1,800 steps all around, 100 m
 *   planar-laser    361 beams over 180°, 30 m
 *   sonar           one beam of 15°, 15 m, 120 pings per sweep, up to three echoes per ping with intensities
 *   sonar-range     the same with the first echo only and no intensity
 *
 * @throws std::invalid_argument for any other name */
[[nodiscard]] SensorModel makeSensor(const std::string& name);

/** All directions that a sensor can look in, its beams and what lies between them. Immutable. */
class FieldOfView
{
 public:
  explicit FieldOfView(const SensorModel& sensor);

  /// @param direction_sensor  of length 1; for a planar sensor, in its plane
  [[nodiscard]] bool contains(const Eigen::Vector3d& direction_sensor) const;

 private:
  SensorKind kind_;
  double edgeCosine_;    ///< of half the azimuths, or of the half angle of a cone
  double lowSine_ = -1;  ///< of the elevations
  double highSine_ = 1;
};

/// The orientation of a sonar's head in the frame of its mount.
struct HeadTurn
{
  double yaw_rad = 0;
  double pitch_rad = 0;  ///< positive: looks down
};
/// Each sweep is a full turn in equal steps; every other sweep looks 20° down, at the bottom.
/// @param shot  number of the ping, from 0
[[nodiscard]] HeadTurn headTurn(const SensorModel& sensor, int shot);

}  // namespace lamap::sim
