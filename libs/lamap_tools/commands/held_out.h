#pragma once

#include <lamap_tools/config/map_setup.h>
#include <lamap_tools/inputs/scan_inserter.h>
#include <lamap_tools/inputs/scan_loop.h>
#include <lamap_tools/scores/map_scores.h>

#include <vector>

namespace lamap::tools
{
struct HeldOutOptions
{
  InputOptions inputs;
  MapRequest map;
  /// Every Nth scan of each sensor is kept from the map and scored, ≥ 2.
  size_t every = 10;
  /// Of the scans that are scored [m]; 0: the map's own insertion option, and what the observation states
  /// where that says nothing. To be given where maps are compared.
  double maxRange_m = 0;
  std::vector<double> thresholds{0.7};
  /// 0: as many as the machine has. Never changes a score.
  unsigned threads = 0;
};

struct HeldOutReport
{
  MapScores scores;            ///< by all rays
  MapScores scoresOfReturned;  ///< by those that returned, see ScoredRays
  InsertionTally scans;        ///< that the map was given
  size_t heldOut = 0;          ///< scans that were scored
  /// Up to here rays were scored [m]; 0: what the observations state.
  double maxRange_m = 0;
  std::vector<InputReport> inputs;
  std::vector<std::string> inputNotes;
  bool stopped = false;  ///< because it was asked to: there are no scores then
};

/** Scores a map without knowing the truth: it is built from all scans but every N-th, and asked about what
 * those show, see labelCells(): the cells of their hits and of their free space. A cell that several of them
 * show counts once for each; one that the map has not observed has P = 0.5. All scores are given twice: by
 * all rays, and without those that had no return.
 *
 * Scans of each sensor (by its label) are counted by themselves. What no ray can be read of is not counted.
 * @throws UsageError if the options do not go together; std::runtime_error naming the input if it has fewer
 * than N scans, or none that the map takes. */
[[nodiscard]] HeldOutReport scoreHeldOut(const HeldOutOptions& options,
                                         const ProgressSink& progress = nullptr);

}  // namespace lamap::tools
