#pragma once

#include <lamap_core/scan/ray_selection.h>
#include <lamap_tools/config/map_setup.h>
#include <lamap_tools/inputs/scan_inserter.h>
#include <lamap_tools/inputs/scan_loop.h>
#include <lamap_tools/report/json.h>

#include <functional>
#include <ostream>
#include <string>
#include <vector>

namespace lamap::tools
{
struct BuildOptions
{
  InputOptions inputs;
  MapRequest map;
  /// A saved map of this library to continue, exactly as if there had been no pause; empty: a new map.
  std::string ontoPath;
  /// `.lamap.gz`, or for MRPT's octoMap also `.ot`. May be the file of ontoPath.
  std::string outPath;
  /// 0: as many as the machine has. Never changes the map.
  unsigned threads = 0;
  /// Stop at the first scan or file that cannot be read or learned; nothing is saved then. Else it is left
  /// out.
  bool strict = false;
};

struct BuildReport
{
  std::string mapClass;
  std::string outPath;
  bool saved = false;
  bool stopped = false;  ///< before the end, because it was asked to
  InsertionTally scans;
  std::vector<InputReport> inputs;
  RayCounts rays;                  ///< of all scans; of this library's maps only
  std::vector<std::string> notes;  ///< on the output, and on what would make a better map
  double seconds = 0;              ///< of reading and inserting
};

/** Builds a map from logs, or continues a saved one, and saves it.
 *
 * The output's place and the configuration are checked before any work. Where an input is cut short, what
 * could be read is saved. Asked to stop (BuildOptions::inputs.shouldStop), it finishes the scan and saves
 * what there is.
 * @throws UsageError if the options do not go together; std::runtime_error naming the file and the reason if
 * something cannot be read or saved, or if there was not one usable scan: then nothing is written */
BuildReport buildMap(const BuildOptions& options, const ProgressSink& progress = nullptr);

/// A map in memory, and how it came about.
struct BuiltMap
{
  mrpt::maps::CMetricMap::Ptr map;  ///< never null
  BuildReport report;               ///< saved is false; stopped before the first usable scan: no scans
};

/** The same map, not saved; BuildOptions::outPath does not count.
 * @param prepare  called with the map before the first scan
 * @throws as buildMap() */
[[nodiscard]] BuiltMap buildInMemory(const BuildOptions& options, const ProgressSink& progress = nullptr,
                                     const std::function<void(mrpt::maps::CMetricMap&)>& prepare = nullptr);

/// The report for people: what was used, what was left out and why, what could not be read.
void printReport(const BuildReport& report, std::ostream& out);
[[nodiscard]] Json reportJson(const BuildReport& report);

}  // namespace lamap::tools
