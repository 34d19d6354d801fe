#pragma once

#include <lamap_tools/report/json.h>
#include <lamap_tools/scores/map_scores.h>

#include <iosfwd>
#include <string>
#include <vector>

namespace lamap::tools
{
/** The scores of several maps as tables: over all cells, over observed ones, precision and recall at each
 * threshold, and the shape of the map, if it was scored against a truth. "-" stands for what is undefined,
 * and notes say why. Every map must have been scored with the same thresholds.
 * @param cells  what the cells are, e.g. "cells of the truth" */
void printScores(const std::vector<MapScores>& maps, const std::string& cells, std::ostream& out);

/// The same of one map, lengths in metres; null stands for what is undefined. Curves are left out.
[[nodiscard]] Json scoresJson(const MapScores& map);

/** How scores are made: what an unobserved cell counts as, the clip of the log loss, the number of bins, the
 * tolerance of thresholds. */
[[nodiscard]] Json scoringJson();

/** Refuses a file for curves that cannot be written, before any work.
 * @throws UsageError unless its name ends in .csv or .png; std::runtime_error naming it if it is a .png and
 * gnuplot is missing, or if nothing can be written there. */
void requireCurveFile(const std::string& path);

/** Writes the ROC curves of all maps, over all cells and over observed ones: as CSV
 * `map,cells,threshold,false_positive_rate,true_positive_rate` with `all` or `observed` for cells, or as a
 * plot.
 * @throws std::runtime_error naming the file if it cannot be written or if there is no curve, as the truth
 * has one class only. */
void writeRocCurves(const std::vector<MapScores>& maps, const std::string& path);

/** Writes how often cells of each bin of probability are occupied: as CSV
 * `map,cells,low,high,count,mean_prob,occupied_share` (the last two empty for an empty bin), or as a plot.
 * @throws std::runtime_error naming the file if it cannot be written. */
void writeCalibration(const std::vector<MapScores>& maps, const std::string& path);

}  // namespace lamap::tools
