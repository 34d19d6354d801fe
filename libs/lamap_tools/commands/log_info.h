#pragma once

#include <lamap_tools/inputs/scan_inserter.h>
#include <lamap_tools/inputs/scan_look.h>
#include <lamap_tools/inputs/scan_loop.h>
#include <lamap_tools/report/json.h>
#include <mrpt/core/Clock.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

namespace lamap::tools
{
/// First and last time stamp.
struct TimeSpan
{
  mrpt::Clock::time_point first;
  mrpt::Clock::time_point last;

  void include(mrpt::Clock::time_point time);
  [[nodiscard]] double seconds() const;
};

/// What a log holds of one sensor.
struct SensorInfo
{
  std::string name;       ///< its label, or its class where it has none
  std::string className;  ///< without its namespace, or the kind of input
  size_t scans = 0;
  std::optional<TimeSpan> time;  ///< of the scans that have one
  size_t withoutTime = 0;
  bool hasRays = true;        ///< false: a class that no map of this library takes
  size_t unreadable = 0;      ///< scans whose rays cannot be read,
  std::string whyUnreadable;  ///< and what is wrong with the first of them
  ScanLook look;              ///< of all its scans together; of the farthest returns, nothing
  EmptyScans emptyScans;
  double illegalAperture_rad = 0;  ///< opening angle of beams that is none; 0: all are
  size_t phantomShells = 0;        ///< scans that seem to have one
  PhantomShells shells;            ///< of those that are worth a look
};

/// Where a robot was.
struct PathInfo
{
  double length_m = 0;  ///< through the poses in the order of their times
  double farthestFromStart_m = 0;
  Eigen::AlignedBox3d box_m;
};

/// Everything that `lamap info` reports of a log.
struct LogInfo
{
  std::string path;
  uint64_t fileBytes = 0;  ///< of a folder: its PCD files together
  /// Of all that the log holds but odometry.
  std::optional<mrpt::Clock::time_point> firstTime;
  std::optional<TimeSpan> time;       ///< of the observations that were chosen
  std::vector<SensorInfo> sensors;    ///< by name
  std::string choice;                 ///< what of the log was chosen; empty: all
  std::vector<std::string> readings;  ///< how they were understood
  std::vector<std::string> poses;     ///< where they come from, and remarks
  bool posesAreOdometry = false;      ///< see ScanSource
  std::optional<PathInfo> robotPath;  ///< nothing where no observation has a pose
  /// What a build would use and leave out, whatever the kind of map. (A map may leave out more.)
  InsertionTally build;
  std::vector<std::string> notes;  ///< what to do about it
  InputReport input;
  bool stopped = false;  ///< because it was asked to: the log was not read to its end
};

/** Reads a log to its end and describes it.
 * @param options  with one path; poses that are missing are no error
 * @throws UsageError and std::runtime_error as openInputs() */
[[nodiscard]] LogInfo readLogInfo(InputOptions options, const ProgressSink& progress = nullptr);

/// For people: one fact per line, with units.
void printLogInfo(const LogInfo& info, std::ostream& out);

/// For scripts: the same facts. Lengths in metres; times in seconds since 1970, those of a sensor since the
/// log's first time stamp.
[[nodiscard]] Json logInfoJson(const LogInfo& info);

}  // namespace lamap::tools
