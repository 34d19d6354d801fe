#pragma once

#include <lamap_core/training/scan_labels.h>
#include <lamap_tools/cells/cell_map.h>
#include <lamap_tools/config/map_setup.h>
#include <lamap_tools/inputs/scan_inserter.h>
#include <lamap_tools/scores/held_out_cells.h>
#include <lamap_tools/scores/map_scores.h>

#include <memory>
#include <string>
#include <vector>

namespace lamap::tools
{
/// A map that is built from a log to be scored. Used by one thread at a time.
struct ScoredMap
{
  /** @param shownName   in messages and scores
   *  @param maxRange_m  rays are scored up to here; 0: as far as the map inserts them
   *  @param purpose     what the map must have cells for: "score", "compare"
   *  @throws std::runtime_error if the map cannot be made so, UsageError if it has no cells */
  ScoredMap(const std::string& shownName, const MapDefinition& definition, unsigned threads,
            double maxRange_m, const std::string& purpose);

  /// What `tally` holds, which is empty afterwards.
  [[nodiscard]] MapScores scores(const std::vector<double>& thresholds);

  /// By the cells that scans held out show.
  [[nodiscard]] MapScores heldOutScores(ScoredRays rays, const HeldOutCells& shown,
                                        const std::vector<double>& thresholds);

  std::string name;
  mrpt::maps::CMetricMap::Ptr map;
  std::shared_ptr<CellMap> cells;
  LabelRules rules;  ///< how the scans that score it label its cells
  std::unique_ptr<ScanInserter> inserter;
  PredictionTally tally;
};

/// @throws UsageError unless every ≥ 2 and the range is a length or 0
void requireLegalScoring(size_t every, double maxRange_m);

}  // namespace lamap::tools
