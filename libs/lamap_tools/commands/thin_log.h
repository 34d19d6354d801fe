#pragma once

#include <lamap_tools/inputs/scan_choice.h>
#include <lamap_tools/report/progress_bar.h>
#include <mrpt/obs/CObservation.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <iosfwd>
#include <map>
#include <optional>
#include <string>

namespace lamap::tools
{
/** A scan as a sensor with fewer beams would have taken it: every Nth ray, equally far apart as
 * before.
 *
 * Of a CObservation2DRangeScan the rays in the middle of its fan are kept; where these are not symmetric
 * about its axis, sensorPose turns by less than the angle between two of its rays. Of a
 * CObservationPointCloud every Nth point is kept, and it no longer is stored externally.
 * @param every ≥ 1. @return nothing for an observation that has no rays (odometry, IMU, an image …)
 * @throws std::runtime_error naming the class of an observation whose rays cannot be taken out */
[[nodiscard]] std::optional<mrpt::obs::CObservation::Ptr> thinned(const mrpt::obs::CObservation& observation,
                                                                  size_t every);

struct ThinOptions
{
  std::string inPath;   ///< .rawlog, .simplemap or .simplemap.gz
  std::string outPath;  ///< of the same kind
  size_t every = 1;     ///< keep every Nth ray, ≥ 1; 1: observations as they are
  ScanChoice choice;    ///< the observations to keep; odometry is always kept
  /// Looked at from time to time.
  std::function<bool()> shouldStop = [] { return false; };
};

struct ThinReport
{
  std::map<std::string, size_t> thinned;    ///< scans by class
  std::map<std::string, size_t> asTheyAre;  ///< observations without rays by class
  std::string choice;                       ///< how many observations were chosen; empty: all
  std::optional<std::string> damage;        ///< why the input could not be read to its end
  bool saved = false;
  bool stopped = false;  ///< because it was asked to: nothing is saved then
};

/** Writes a log again with every Nth ray of its scans, and without what is not chosen; poses, actions,
 * odometry and all else stay, as do frames of a rawlog that lost all observations: each goes with an action.
 * Poses of a simple map go with their last observation.
 * @throws UsageError if the options do not go together; std::runtime_error naming the file if one cannot be
 * read at all or written, or a scan in it cannot be thinned, or nothing is chosen: then nothing is written */
[[nodiscard]] ThinReport thinLog(const ThinOptions& options, const ProgressSink& progress = nullptr);

void printReport(const ThinReport& report, const ThinOptions& options, std::ostream& out);

}  // namespace lamap::tools
