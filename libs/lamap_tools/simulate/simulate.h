#pragma once

#include <lamap_sim/scanner.h>
#include <lamap_tools/report/progress_bar.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

namespace lamap::tools
{
struct SimulateOptions
{
  std::string world;  ///< one of sim::worldNames()
  uint64_t seed = 1;  ///< of the world and of all noise
  /// `.rawlog` or `.simplemap`. Beside it come a `.tum` with the true poses and an `.ini` for `lamap build`.
  std::string outPath;
  std::vector<std::string> truthPaths;  ///< each `.csv` or `.bt`; none: no truth is written
  /// "solids": cells that are wholly solid or open, see sim::truthOf(). "surfaces": cells with a surface and
  /// open ones, of those that the sensor could see from the log's poses, see sim::surfaceTruthOf().
  std::string truthOf = "solids";
  std::string surfacePath;  ///< `.csv` for points on all surfaces, see sim::surfacePointsOf(); empty: none

  std::string sensor;                ///< one of sim::sensorNames(); empty: the world's own
  std::optional<int> scans;          ///< ≥ 1; for a sonar sweeps; without it the world's own number
  std::optional<double> rangeMax_m;  ///< > 0; without it the sensor's own
  /// "stops", "driving" or a file of poses (TUM, or MRPT's path text), one per scan; empty: the world's own.
  std::string trajectory;
  /// "x,y,z" or "x,y,z,yaw" [m, degrees]: the sensor stands there for all scans. Empty: it does not.
  std::string standAt;

  sim::NoiseOptions noise;
  std::string missingAs = "open";  ///< what the log says of a lost return, one of missingAsNames()
  /// Of each movement that the log reports, as a share of its length and turn: adds up along the way. ≥ 0.
  double odometryNoise = 0;

  double resolution_m = 0.1;           ///< of the truth's cells and of the maps in the .ini
  std::optional<double> truthDepth_m;  ///< how deep behind a surface solid cells count; without it one cell
  std::function<bool()> shouldStop = [] { return false; };
};

struct SimulateReport
{
  bool stopped = false;  ///< because it was asked to: then nothing is written
  std::string sensor;
  double rangeMax_m = 0;
  size_t scans = 0;
  size_t returns = 0;    ///< rays with a return, or echoes
  size_t noReturns = 0;  ///< rays, or pings, without one
  size_t lost = 0;       ///< returns, or echoes, that got lost
  size_t freeCells = 0;
  size_t occupiedCells = 0;
  size_t surfacePoints = 0;
  std::vector<std::string> files;  ///< what was written
};

/** Makes a world, sends a sensor through it and writes what it reads as a log, and the truth.
 *
 * The same options give the same bytes of every file. All files are put in place at the end.
 * @param progress  of the scans, with the log as its input, then of the cells of each CSV
 * @throws UsageError for names and values that cannot be; std::runtime_error naming the file if one cannot be
 * read or written, or if a sensor on a file's way would stand in a solid: then nothing is written */
SimulateReport simulate(const SimulateOptions& options, const ProgressSink& progress = nullptr);

void printReport(const SimulateReport& report, const SimulateOptions& options, std::ostream& out);

}  // namespace lamap::tools
