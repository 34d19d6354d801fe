#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <lamap_tools/cells/cell_table.h>
#include <lamap_tools/scores/map_scores.h>
#include <mrpt/core/format.h>
#include <mrpt/maps/COccupancyGridMap2D.h>

#include <cmath>
#include <stdexcept>

namespace lamap::tools
{
namespace
{
/// Where a map is asked about the cells of a truth.
struct Sampling
{
  size_t partsAlongEdge = 1;
  std::string note;
};

Sampling samplingOf(const Truth& truth, double resolution_m, const std::string& name)
{
  if (!truth.spacing_m || truth.isOnGrid(resolution_m)) return {};
  const double edge_m = *truth.spacing_m;
  if (!truth.isOnGrid(edge_m))
    throw std::runtime_error(truth.name + ": its cells, " + mrpt::format("%g", edge_m) +
                             " m apart, are on another grid than those of " + name + " (" +
                             mrpt::format("%g", resolution_m) +
                             " m): centres are expected at (i + 1/2) times the cells' edge");
  const double ratio = edge_m / resolution_m;
  if (ratio < 1.001)
    return {1, mrpt::format("resampled: the truth's cells have %g m, the map's %g m; each cell of the truth "
                            "is asked at its centre",
                            edge_m, resolution_m)};
  constexpr double kMostParts = 16;
  const double parts = std::ceil(ratio - 1e-3);
  if (parts > kMostParts)
    throw std::runtime_error(truth.name +
                             mrpt::format(": its cells of %g m are more than %g times larger "
                                          "than those of ",
                                          edge_m, kMostParts) +
                             name + mrpt::format(" (%g m): a finer truth is needed", resolution_m));
  return {
      static_cast<size_t>(parts),
      mrpt::format("resampled: the truth's cells have %g m, the map's %g m; each cell of the truth counts "
                   "as its parts, %g along an edge",
                   edge_m, resolution_m, parts)};
}

/// @param parts  along an edge, as which each cell of the truth counts
void askAboutTruth(const CellMap& map, const Truth& truth, size_t parts, std::optional<int32_t> layer,
                   PredictionTally& tally, const CountSink& progress)
{
  constexpr size_t kBetweenReports = 1U << 16U;
  const double r = map.resolution();
  const double part_m = truth.spacing_m.value_or(r) / static_cast<double>(parts);
  const bool oneLayer = truth.isOneLayer();
  const size_t layers = oneLayer ? 1 : parts;
  const auto offset = [&](size_t part, size_t count)
  { return (static_cast<double>(part) - (static_cast<double>(count) - 1) / 2) * part_m; };
  const auto askAt = [&](Eigen::Vector3d point, bool occupied)
  {
    if (layer && !oneLayer && std::floor(point.z() / r) != *layer) return;
    if (layer) point.z() = (*layer + 0.5) * r;
    tally.add(map.estimateAt({point.x(), point.y(), point.z()}), occupied ? 1U : 0U, occupied ? 0U : 1U);
  };
  for (size_t i = 0; i < truth.cells.size(); ++i)
  {
    const TrueCell& cell = truth.cells[i];
    for (size_t x = 0; x < parts; ++x)
      for (size_t y = 0; y < parts; ++y)
        for (size_t z = 0; z < layers; ++z)
          askAt(cell.centre_map + Eigen::Vector3d(offset(x, parts), offset(y, parts), offset(z, layers)),
                cell.occupied);
    if (progress && (i + 1) % kBetweenReports == 0) progress(i + 1, truth.cells.size());
  }
}

std::string extentText(const Eigen::AlignedBox3d& box)
{
  const auto& [low, high] = std::pair(box.min(), box.max());
  return mrpt::format("x %g to %g, y %g to %g, z %g to %g m", low.x(), high.x(), low.y(), high.y(), low.z(),
                      high.z());
}

/// Both by the centres of their cells.
[[noreturn]] void failWithoutOverlap(const CellMap& map, const std::string& name, const Truth& truth)
{
  const auto extent = cellExtent(map);
  if (!extent) throw std::runtime_error(name + ": is empty, there is nothing to score");
  Eigen::AlignedBox3d ofTruth;
  for (const TrueCell& cell : truth.cells) ofTruth.extend(cell.centre_map);
  const Eigen::AlignedBox3d ofMap(cellCentre(extent->first, map.resolution()),
                                  cellCentre(extent->last, map.resolution()));
  throw std::runtime_error(name + ": has observed none of the cells of " + truth.name + "; the map reaches " +
                           extentText(ofMap) + ", the truth " + extentText(ofTruth));
}
}  // namespace

Scores scoresOf(const RankedPredictions& predictions, const std::vector<double>& thresholds)
{
  Scores scores;
  scores.occupied = predictions.occupied();
  scores.free = predictions.free();
  scores.areaUnderRoc = areaUnderRoc(predictions);
  scores.averagePrecision = averagePrecision(predictions);
  scores.logLoss = logLoss(predictions);
  scores.brier = brierScore(predictions);
  scores.calibrationError = expectedCalibrationError(predictions);
  for (const double threshold : thresholds)
    scores.thresholds.push_back({threshold, precisionRecall(predictions, threshold, ThresholdRule::Above),
                                 precisionRecall(predictions, threshold, ThresholdRule::AtLeast)});
  scores.roc = rocCurve(predictions);
  scores.calibration = calibrationBins(predictions);
  return scores;
}

void PredictionTally::add(const std::optional<CellEstimate>& estimate, uint64_t occupied, uint64_t free)
{
  states_.add(estimate, occupied, free);
  if (estimate)
  {
    observed_.push_back({estimate->prob, occupied, free});
    return;
  }
  unobserved_.occupied += occupied;
  unobserved_.free += free;
}

void PredictionTally::join()
{
  observed_ = RankedPredictions(std::move(observed_)).ascending();
}

MapScores PredictionTally::scores(const std::string& name, const CellMap& map,
                                  const std::vector<double>& thresholds)
{
  MapScores scores;
  scores.name = name;
  scores.className = map.className();
  scores.resolution_m = map.resolution();
  RankedPredictions observed(std::move(observed_));
  observed_.clear();
  scores.observed = scoresOf(observed, thresholds);
  std::vector<PredictedCells> all = observed.ascending();
  all.push_back(unobserved_);
  unobserved_ = {kUnobservedProb, 0, 0};
  states_ = {};
  scores.all = scoresOf(RankedPredictions(std::move(all)), thresholds);
  return scores;
}

std::optional<int32_t> layerOf(const mrpt::maps::CMetricMap* map)
{
  if (const auto* learned = dynamic_cast<const CLearnedMap*>(map)) return learned->planarLayer();
  if (dynamic_cast<const mrpt::maps::COccupancyGridMap2D*>(map)) return 0;
  return std::nullopt;
}

MapScores scoreMap(const OpenedMap& map, const std::string& name, const Truth& truth,
                   const std::vector<double>& thresholds, const CountSink& progress)
{
  const double resolution_m = map.cells->resolution();
  const Sampling sampling = samplingOf(truth, resolution_m, name);
  std::vector<std::string> notes;
  if (!sampling.note.empty()) notes.push_back(sampling.note);
  const auto layer = layerOf(map.map.get());
  if (layer && !truth.isOneLayer())
    notes.push_back(mrpt::format("a map of one layer: only the truth's cells around z = %g m count",
                                 (*layer + 0.5) * resolution_m));

  PredictionTally tally;
  askAboutTruth(*map.cells, truth, sampling.partsAlongEdge, layer, tally, progress);
  if (tally.size() == 0) failWithoutOverlap(*map.cells, name, truth);
  const MapGeometry geometry = geometryOf(*map.cells, layer, truth, tally.states());
  MapScores scores = tally.scores(name, *map.cells, thresholds);
  scores.geometry = geometry;
  scores.notes = std::move(notes);
  return scores;
}

}  // namespace lamap::tools
