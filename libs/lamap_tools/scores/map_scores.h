#pragma once

#include <lamap_core/metrics/metrics.h>
#include <lamap_tools/cells/cell_map.h>
#include <lamap_tools/cells/truth.h>
#include <lamap_tools/scores/map_geometry.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace lamap::tools
{
/// P(occupied) that counts where a map has observed nothing.
constexpr double kUnobservedProb = 0.5;

/// Precision and recall of "occupied" at a threshold, strict and not.
struct ThresholdScore
{
  double threshold = 0.7;
  PrecisionRecall above;    ///< prob > threshold
  PrecisionRecall atLeast;  ///< prob ≥ threshold
};

/// Every score over one set of cells; what is undefined there is nothing.
struct Scores
{
  uint64_t occupied = 0;  ///< of the cells, in truth
  uint64_t free = 0;
  std::optional<double> areaUnderRoc;
  std::optional<double> averagePrecision;
  std::optional<double> logLoss;
  std::optional<double> brier;
  std::optional<double> calibrationError;
  std::vector<ThresholdScore> thresholds;
  std::vector<RocPoint> roc;
  std::vector<CalibrationBin> calibration;

  [[nodiscard]] uint64_t cells() const { return occupied + free; }
};

/** @param thresholds each in [0, 1]. */
[[nodiscard]] Scores scoresOf(const RankedPredictions& predictions, const std::vector<double>& thresholds);

/// How well one map knows the truth.
struct MapScores
{
  std::string name;  ///< the file, or the kind of map
  std::string className;
  double resolution_m = 0;
  Scores all;       ///< over all cells; one the map has not observed counts as kUnobservedProb
  Scores observed;  ///< over those it has observed
  std::optional<MapGeometry> geometry;  ///< against a truth only
  std::vector<std::string> notes;

  /// Of all cells, in [0, 1]; 0 if there are none.
  [[nodiscard]] double observedShare() const
  {
    if (all.cells() == 0) return 0;
    return static_cast<double>(observed.cells()) / static_cast<double>(all.cells());
  }
};

/// Collects what a map says of cells whose truth is known. Belongs to one thread.
class PredictionTally
{
 public:
  /// @param estimate what the map says of the cells; nothing where it has observed nothing.
  void add(const std::optional<CellEstimate>& estimate, uint64_t occupied, uint64_t free);

  [[nodiscard]] size_t size() const { return observed_.size(); }
  [[nodiscard]] const StateCounts& states() const { return states_; }
  /// Joins cells of equal probability, to save memory. Changes no score.
  void join();
  /// What the cells come to, without notes. Leaves the tally empty.
  [[nodiscard]] MapScores scores(const std::string& name, const CellMap& map,
                                 const std::vector<double>& thresholds);

 private:
  std::vector<PredictedCells> observed_;
  PredictedCells unobserved_{kUnobservedProb, 0, 0};
  StateCounts states_;
};

/** The layer of cells that a map for 2D sensors consists of: of a planar map of this library, or 0 for a
 * COccupancyGridMap2D; nothing for a map in 3D. */
[[nodiscard]] std::optional<int32_t> layerOf(const mrpt::maps::CMetricMap* map);

/// How many of how many.
using CountSink = std::function<void(size_t done, size_t expected)>;

/** Scores a map against a truth.
 *
 * The map is asked at the centre of every cell of the truth. On another grid:
 * - a truth with smaller cells than the map's is asked at its centres all the same;
 * - a truth cell that is larger counts as several, its parts, each not larger than a cell of the map, asked
 * at their centres: all of them have its label;
 * - a truth whose centres are not at (i + 1/2)·edge is refused, as its cells would lie across the map's.
 * The first two are said in MapScores::notes. Of a map for 2D sensors only its own layer is scored, and the
 * truth's cells in it; all of them, if they are one layer too.
 *
 * The geometry is by the same answers, and by all occupied cells of the map.
 *
 * @param name for messages and for MapScores
 * @throws std::runtime_error naming the map if it is empty, observed none of the truth's cells or lies on
 * another grid */
[[nodiscard]] MapScores scoreMap(const OpenedMap& map, const std::string& name, const Truth& truth,
                                 const std::vector<double>& thresholds, const CountSink& progress = nullptr);

}  // namespace lamap::tools
