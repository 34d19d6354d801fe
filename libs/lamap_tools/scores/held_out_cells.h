#pragma once

#include <lamap_core/training/scan_labels.h>
#include <lamap_mrpt/learned_map/cell_hash.h>
#include <lamap_tools/cells/cell_map.h>
#include <lamap_tools/inputs/scan_inserter.h>
#include <lamap_tools/inputs/scan_source.h>
#include <lamap_tools/scores/map_scores.h>
#include <tsl/robin_map.h>

#include <map>
#include <optional>
#include <string>

namespace lamap::tools
{
/// Chooses every Nth scan of each sensor. Belongs to one thread.
class HeldOutChoice
{
 public:
  /// @param every ≥ 2
  explicit HeldOutChoice(size_t every) : every_(every) {}

  /// To be asked once for each item whose rays can be read, in their order.
  [[nodiscard]] bool isHeldOut(const ScanItem& item);
  [[nodiscard]] size_t heldOut() const { return heldOut_; }
  /// Of the sensor that gave most.
  [[nodiscard]] size_t mostScans() const;

 private:
  size_t every_;
  size_t heldOut_ = 0;
  std::map<std::string, size_t> scansOf_;
};

/// Which rays of the scans held out score a map: a missing return may be open space or a failure of the
/// sensor, so that scores by all rays may reward maps that call lost walls free.
enum class ScoredRays
{
  All,
  Returned  ///< without those that did not return; a point beyond the maximum range counts as a return
};

/// What one scan shows by these rays.
[[nodiscard]] ScanLabels labelsBy(ScoredRays rays, const Scan& scan, LabelRules rules);

/** What scans show, counted cell by cell, so that the memory depends on the place and not on the number of
 * scans. Const methods may be called from several threads. */
class HeldOutCells
{
 public:
  explicit HeldOutCells(double resolution_m) : resolution_m_(resolution_m) {}

  void add(const Scan& scan, const LabelRules& rules);
  /// Asks a map about all cells that these rays show.
  void ask(ScoredRays rays, const CellMap& map, PredictionTally& tally) const;
  [[nodiscard]] bool empty() const { return byAll_.empty(); }

 private:
  /// How often scans showed a cell occupied and free.
  struct Votes
  {
    uint64_t occupied = 0;
    uint64_t free = 0;
  };

  using CellVotes = tsl::robin_map<CellIndex, Votes, CellIndexHash>;

  static void count(const ScanLabels& labels, CellVotes& votes);

  double resolution_m_;
  CellVotes byAll_;
  CellVotes byReturned_;
};

/// Asks a map about the cells that one scan shows.
void askAboutLabels(const CellMap& map, const ScanLabels& labels, PredictionTally& tally);

/// How the scans that score this map label its cells. @param maxRange_m as HeldOutOptions::maxRange_m
[[nodiscard]] LabelRules labelRulesFor(const mrpt::maps::CMetricMap& map, const CellMap& cells,
                                       double maxRange_m);

/** The rays of an item in the map frame; nothing where it has none that can be read, whatever the reason
 * (the inserter counts it). */
[[nodiscard]] std::optional<Scan> scanOf(const ScanItem& item);

/** How far the map's own insertion options let its rays reach [m]; 0: they say nothing. */
[[nodiscard]] double maxRangeOf(const mrpt::maps::CMetricMap& map);

}  // namespace lamap::tools
