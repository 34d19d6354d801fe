#pragma once

#include <lamap_sim/sensor.h>
#include <lamap_sim/trajectory.h>
#include <lamap_sim/world.h>

#include <cstdint>
#include <optional>
#include <vector>

namespace lamap::sim
{
/** Noise of the readings, as standard deviations of Gaussians. All zero: exact readings. Each kind draws from
 * its own stream of the seed, so that changing one does not change the others. */
struct NoiseOptions
{
  double range_m = 0;     ///< along the ray
  double angle_rad = 0;   ///< of the ray's true direction relative to the reported one, about each axis
  double point_m = 0;     ///< of each coordinate of a point (clouds only)
  double missing = 0;     ///< share of the returns that get lost, in [0, 1]
  double position_m = 0;  ///< of each coordinate of the reported pose
  double turn_rad = 0;    ///< of each angle of the reported pose
  /** Lost returns of a laser come in bursts of 1 to this many neighbouring beams, each length equally likely,
   * in the order of the beams, with at least one beam between bursts. 1: each beam is lost or not by itself.
   * With n > 1, `missing` can be (n + 1) / (n + 3) at most. */
  int longestBurst = 1;

  /// @throws std::invalid_argument naming the member, its value and the legal range
  void requireLegal() const;
};

/// The reading of one laser beam.
struct BeamReading
{
  /// Measured along the reported beam; empty: no return.
  std::optional<double> range_m;
  /// What a return that got lost would have read; empty: nothing got lost.
  std::optional<double> lost_m;
  /// The measured point in the sensor's frame, including point noise; without a return, a point on the beam
  /// at 1.5 times the maximum range.
  Eigen::Vector3d point_sensor = Eigen::Vector3d::Zero();
};

/// One echo of a sonar's ping.
struct Echo
{
  double range_m = 0;  ///< of its front
  int intensity = 0;   ///< 1 .. 255: the share of the beam that returns, weaker at oblique incidence
  bool lost = false;
};

/** Measures a world. A reading depends only on the seed and on the number of its scan, so scans may be made
 * in any order. Immutable: may be shared between threads. */
class Scanner
{
 public:
  /// @throws std::invalid_argument for illegal noise, for point noise if the sensor reads no points, and for
  /// bursts of a sonar
  Scanner(const World& world, const SensorModel& sensor, const NoiseOptions& noise, uint64_t seed);

  /** Refuses a place where no sensor can stand.
   * @throws std::invalid_argument naming the place, if it lies in a solid or beyond the world */
  void requireOpen(const Eigen::Vector3d& position_map) const;

  /// A laser's scan from a pose: one reading per beam.
  [[nodiscard]] std::vector<BeamReading> scan(const Pose& pose, uint64_t number) const;

  /** A sonar's ping: its echoes, also those that got lost, the nearest first, at most echoRanks. Echoes
   * closer together than 0.3 m are merged. */
  [[nodiscard]] std::vector<Echo> ping(const Pose& pose, const HeadTurn& head, uint64_t number) const;

  /// The reported pose. That of a planar sensor has noise in x, y and yaw only.
  [[nodiscard]] Pose reportedPose(const Pose& pose, uint64_t number) const;

 private:
  /// The actual direction of a ray, in the map.
  [[nodiscard]] Eigen::Vector3d trueDirection(const Eigen::Vector3d& beam, const Eigen::Matrix3d& rotation,
                                              Random& random) const;

  World world_;
  SensorModel sensor_;
  NoiseOptions noise_;
  uint64_t seed_;
};

}  // namespace lamap::sim
