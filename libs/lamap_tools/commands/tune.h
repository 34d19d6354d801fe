#pragma once

#include <lamap_tools/config/map_setup.h>
#include <lamap_tools/inputs/scan_inserter.h>
#include <lamap_tools/inputs/scan_loop.h>
#include <lamap_tools/report/json.h>
#include <lamap_tools/scores/map_scores.h>

#include <iosfwd>
#include <string>
#include <vector>

namespace lamap::tools
{
struct TuneOptions
{
  InputOptions inputs;
  /// The map and its settings. A setting with several values separated by commas,
  /// "insertOpts.kernelSupport=0.1,0.2,0.3", is searched; the others are fixed.
  MapRequest map;
  /// Every Nth scan of each sensor is kept from the maps and scored, ≥ 2.
  size_t every = 10;
  /// Instead: every scan is scored by what the map knows before it is given the scan.
  bool prequential = false;
  /// Ranks by all rays of the scored scans, instead of only those that returned.
  bool rankByAllRays = false;
  /// As HeldOutOptions::maxRange_m; must be given where the search changes how far the map inserts rays.
  double maxRange_m = 0;
  /// The best settings, as an .ini file for `lamap build -c`; empty: none is written.
  std::string outPath;
  /// 0: as many as the machine has. Never changes a score.
  unsigned threads = 0;
};

/// One combination of the values that are searched.
struct TunedMap
{
  std::vector<std::string> settings;  ///< "section.key=value" of what is searched, in the order given
  MapScores scores;                   ///< by all rays
  MapScores scoresOfReturned;         ///< by those that returned, see ScoredRays
};

struct TuneReport
{
  std::string mapName;
  std::vector<TunedMap> maps;  ///< the best first
  bool rankedByAllRays = false;
  size_t scored = 0;     ///< scans
  InsertionTally scans;  ///< that the best map was given
  std::vector<InputReport> inputs;
  std::vector<std::string> inputNotes;
  std::string outPath;
  bool stopped = false;  ///< because it was asked to: there are no scores, and no file, then
};

/** Searches options by how well scans predict each other: every combination of the values is a map, all are
 * built in parallel from one reading of the input, and ranked by log loss over the cells that the scored
 * scans show by their rays that returned, or by all (see labelCells(); cells that a map has not observed
 * count as P = 0.5). Missing returns do not count unless asked for, because where they are failures of the
 * sensor, the best score goes to the map that believes them.
 *
 * All maps are in memory at once, and must have the same cells: neither resolution nor layer can be searched,
 * for scores of different cells cannot be compared.
 * @throws UsageError if the options do not go together: nothing or more than 1000 combinations to search,
 * maps of different cells or ranges; std::runtime_error as scoreHeldOut(), and if the file cannot be written
 */
[[nodiscard]] TuneReport tuneMap(const TuneOptions& options, const ProgressSink& progress = nullptr);

/// The combinations with their scores, best first.
void printTuning(const TuneReport& report, std::ostream& out);
[[nodiscard]] Json tuningJson(const TuneReport& report);

}  // namespace lamap::tools
