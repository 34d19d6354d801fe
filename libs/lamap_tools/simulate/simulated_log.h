#pragma once

#include <lamap_sim/scanner.h>
#include <mrpt/poses/CPose3D.h>

#include <memory>
#include <string>
#include <vector>

namespace lamap::tools
{
class FileOutput;

/// What a log says where a return got lost.
enum class MissingAs
{
  Open,    ///< the same as where nothing returns
  Zero,    ///< range 0; the point (0, 0, 0)
  Nan,     ///< not a number, in all coordinates of a point
  Inf,     ///< infinite, in all coordinates of a point in which the beam extends
  Max,     ///< the maximum range; the point there
  Invalid  ///< the range, marked invalid; a point, or a CObservationRange's measurement, is left out
};

/// All names for missingAs(), in the order of the enumeration.
[[nodiscard]] const std::vector<std::string>& missingAsNames();
/// @throws std::out_of_range for any other name
[[nodiscard]] MissingAs missingAs(const std::string& name);

/// How a log reports readings and poses.
struct LogOptions
{
  sim::SensorModel sensor;
  sim::NoiseOptions noise;
  double odometryNoise = 0;  ///< share of each movement
  uint64_t seed = 0;         ///< of the odometry's noise
  MissingAs missingAs = MissingAs::Open;
};

/// The time of a shot (a scan, or a ping of a sonar), in seconds since 1970.
[[nodiscard]] double timeOfShot(const sim::SensorModel& sensor, size_t shot);

/// The robot's pose in the log: the sensor's own, but on the ground below a planar sensor.
[[nodiscard]] sim::Pose robotPose(const sim::SensorModel& sensor, const sim::Pose& sensorPose);

/** Writes a log shot by shot, with MRPT's observation classes.
 *
 * A 3D laser's scan is a CObservationPointCloud in the sensor's frame, which is the robot's; a planar one's a
 * CObservation2DRangeScan; a ping's echoes are CObservation2DRangeScans of one beam, or a CObservationRange
 * if only one echo is kept. */
class SimulatedLog
{
 public:
  virtual ~SimulatedLog() = default;
  /// @param reported  the sensor's pose according to the log
  virtual void addScan(const sim::Pose& reported, const std::vector<sim::BeamReading>& readings) = 0;
  virtual void addPing(const sim::Pose& reported, const sim::HeadTurn& head,
                       const std::vector<sim::Echo>& echoes) = 0;
  /// Writes the rest; the file is not yet at its destination.
  virtual void finish() = 0;
};

/// `.rawlog`: a movement and a sensory frame for each shot. The first movement leads from the identity to the
/// first pose.
[[nodiscard]] std::unique_ptr<SimulatedLog> makeRawlog(FileOutput& file, const LogOptions& options);
/// `.simplemap`: a pose with the covariance of the pose noise and a sensory frame for each shot.
[[nodiscard]] std::unique_ptr<SimulatedLog> makeSimplemap(FileOutput& file, const LogOptions& options);

}  // namespace lamap::tools
