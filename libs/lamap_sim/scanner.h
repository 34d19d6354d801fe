#pragma once

#include <lamap_sim/sensor.h>
#include <lamap_sim/trajectory.h>
#include <lamap_sim/world.h>

#include <cstdint>
#include <optional>
#include <vector>

namespace lamap::sim
{
/** What makes readings differ from the truth. All zero: exact readings. Standard deviations of Gaussians;
 * each kind draws from its own stream of the seed, so that one changes nothing of the others. */
struct NoiseOptions
{
  double range_m = 0;     ///< along the ray
  double angle_rad = 0;   ///< of the ray's true direction against the one that is reported, about each axis
  double point_m = 0;     ///< of each coordinate of a point (clouds only)
  double missing = 0;     ///< share of the returns that get lost: they read as rays without return, in [0, 1]
  double position_m = 0;  ///< of each coordinate of the reported pose
  double turn_rad = 0;    ///< of each angle of the reported pose

  /// @throws std::invalid_argument naming the member, its value and the legal range
  void requireLegal() const;
};

/// What one beam of a laser reads.
struct BeamReading
{
  /// Measured along the beam as it is reported; nothing: no return.
  std::optional<double> range_m;
  /// The measured point in the sensor's frame, errors of single points included; where there was no return, a
  /// point on the beam at 1.5 times the maximum range.
  Eigen::Vector3d point_sensor = Eigen::Vector3d::Zero();
};

/// What comes back of a sonar's ping, from one distance.
struct Echo
{
  double range_m = 0;  ///< of its front
  int intensity = 0;   ///< 1 .. 255: the share of the beam that comes back, weaker at a slant
};

/** Measures a world. Every reading depends on the seed and on the number of its scan only, so that scans may
 * be made in any order. Immutable: may be shared between threads. */
class Scanner
{
 public:
  /// @throws std::invalid_argument for illegal noise, and for point noise where the sensor reads no points
  Scanner(const World& world, const SensorModel& sensor, const NoiseOptions& noise, uint64_t seed);

  /** Refuses a place where no sensor can stand.
   * @throws std::invalid_argument naming the place, if it lies in a solid or beyond the world */
  void requireOpen(const Eigen::Vector3d& position_map) const;

  /// A laser's scan from a pose: one reading a beam.
  [[nodiscard]] std::vector<BeamReading> scan(const Pose& pose, uint64_t number) const;

  /** A sonar's ping: its echoes, the nearest first, at most echoRanks. Echoes nearer to each other than 0.3 m
   * are one. */
  [[nodiscard]] std::vector<Echo> ping(const Pose& pose, const HeadTurn& head, uint64_t number) const;

  /// The pose as it is reported. A planar sensor errs in x, y and yaw only.
  [[nodiscard]] Pose reportedPose(const Pose& pose, uint64_t number) const;

 private:
  /// The ray as it really goes, turned into the map.
  [[nodiscard]] Eigen::Vector3d trueDirection(const Eigen::Vector3d& beam, const Eigen::Matrix3d& rotation,
                                              Random& random) const;

  World world_;
  SensorModel sensor_;
  NoiseOptions noise_;
  uint64_t seed_;
};

}  // namespace lamap::sim
