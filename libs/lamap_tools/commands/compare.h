#pragma once

#include <lamap_tools/config/map_setup.h>
#include <lamap_tools/inputs/scan_inserter.h>
#include <lamap_tools/inputs/scan_loop.h>
#include <lamap_tools/report/json.h>
#include <lamap_tools/scores/map_scores.h>
#include <mrpt/maps/CMetricMap.h>

#include <algorithm>
#include <cstdint>
#include <iosfwd>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace lamap::tools
{
struct CompareOptions
{
  InputOptions inputs;
  /** What to build: "bgkMap", or with settings of its own "bgkMap insertOpts.kernelSupport=0.3 ...", or with
   * a label to name it by "wide: bgkMap insertOpts.kernelSupport=0.3 ...". Empty: the maps that configPath
   * counts, and without it bgkMap, overlappingHilbertMap, hilbertMap and octoMap. */
  std::vector<std::string> maps;
  /// As MapRequest::configPath, for all maps; empty: none.
  std::string configPath;
  /// As MapRequest::settings, for all maps; those of a map itself come after them.
  std::vector<std::string> settings;
  /// As of readTruth(); empty: none.
  std::string truthPath;
  /// As of readSurface(), with a truth; empty: none.
  std::string surfacePath;
  /// Instead of a truth: every Nth scan of each sensor is kept from the maps and scored, ≥ 2; 0: none.
  size_t heldOutEvery = 0;
  /// With heldOutEvery, as HeldOutOptions::maxRange_m; 0: the farthest that one of the maps inserts.
  double maxRange_m = 0;
  std::vector<double> thresholds{0.7};
  /// A page with the table and pictures of all maps, `.html`; empty: none.
  std::string pagePath;
  /// The table in a file, `.csv` or `.md` (Markdown); empty: none.
  std::string tablePath;
  /// Of this library's maps; 0: as many as the machine has. Never changes a map.
  unsigned threads = 0;
};

struct ComparedMap
{
  std::string name;  ///< its label, or as it was asked for
  mrpt::maps::CMetricMap::Ptr map;
  std::shared_ptr<CellMap> cells;
  InsertionTally scans;
  /// Of all scans, and of the first question to the map, at which some train their model.
  double insertion_s = 0;
  std::optional<uint64_t> memoryBytes;  ///< as the map counts it itself; nothing where it does not
  std::optional<MapScores> scores;
  std::optional<MapScores> scoresOfReturned;  ///< with scans held out: by the rays that returned

  [[nodiscard]] double insertionOfOne_s() const
  {
    return insertion_s / static_cast<double>(std::max<size_t>(1, scans.usedCount()));
  }
};

/// A map that cannot be compared with the others.
struct RefusedMap
{
  std::string name;
  std::string reason;  ///< why it does not take a setting for all maps, the log, or what scores it
};

struct Comparison
{
  std::vector<ComparedMap> maps;  ///< at least one, unless it was stopped
  std::vector<RefusedMap> refused;
  std::string scoredBy;  ///< what the scores are over, in words; empty: there are none
  std::vector<std::string> notes;
  std::vector<InputReport> inputs;
  std::vector<std::string> inputNotes;
  std::string pagePath;
  bool stopped = false;  ///< because it was asked to: nothing is scored or written then
};

/** Builds several maps from one reading of the inputs, scores them alike, and takes the time that each needs
 * for a scan: only insertion counts, and each map gets a copy of the scan that no other has prepared for it.
 * A map that does not take a setting for all maps, a single scan of the log, or what scores it is left out
 * with the reason, as long as another one does.
 *
 * @throws UsageError if the options do not go together or there is no such map; std::runtime_error as
 * buildMap(), scoreMap() and scoreHeldOut(), and if the page cannot be written */
[[nodiscard]] Comparison compareMaps(const CompareOptions& options, const ProgressSink& progress = nullptr);

/// The maps in one table: quality over all cells, time for a scan, memory; after them, why others are not.
void printComparison(const Comparison& comparison, std::ostream& out);
[[nodiscard]] Json comparisonJson(const Comparison& comparison);

}  // namespace lamap::tools
