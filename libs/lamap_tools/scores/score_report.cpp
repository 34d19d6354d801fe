#include <lamap_tools/scores/score_report.h>

#include <lamap_tools/files/file_output.h>
#include <lamap_tools/report/text_table.h>
#include <mrpt/core/format.h>

#include <ostream>

namespace lamap::tools
{
namespace
{
void printBlock(const std::vector<MapScores>& maps, const std::string& title, Scores MapScores::*set,
                std::ostream& out)
{
  out << title << "\n";
  TextTable table;
  table.add({"map", "cells", "occupied", "AUC", "avg. precision", "log loss", "Brier", "calibration error"});
  for (const MapScores& map : maps)
  {
    const Scores& scores = map.*set;
    table.add({map.name, std::to_string(scores.cells()), std::to_string(scores.occupied),
               numberText(scores.areaUnderRoc), numberText(scores.averagePrecision),
               numberText(scores.logLoss), numberText(scores.brier), numberText(scores.calibrationError)});
  }
  table.print(out);
}

void printThresholds(const std::vector<MapScores>& maps, const std::string& title, Scores MapScores::*set,
                     std::ostream& out)
{
  const auto& thresholds = (maps.front().*set).thresholds;
  if (thresholds.empty()) return;
  out << title << "\n";
  TextTable table;
  std::vector<std::string> head{"map"};
  for (const ThresholdScore& score : thresholds)
  {
    head.push_back(mrpt::format("p > %g", score.threshold));
    head.push_back(mrpt::format("p >= %g", score.threshold));
  }
  table.add(head);
  const auto pair = [](const PrecisionRecall& score)
  { return numberText(score.precision) + " / " + numberText(score.recall); };
  for (const MapScores& map : maps)
  {
    std::vector<std::string> row{map.name};
    for (const ThresholdScore& score : (map.*set).thresholds)
    {
      row.push_back(pair(score.above));
      row.push_back(pair(score.atLeast));
    }
    table.add(row);
  }
  table.print(out);
}

void printGeometry(const std::vector<MapScores>& maps, std::ostream& out)
{
  if (!maps.front().geometry) return;
  out << mrpt::format("shape (occupied: the map's own state; called free: p < %g; distances",
                      kCalledFreeBelow)
      << " from the centres of occupied cells to the nearest "
      << (maps.front().geometry->toPoints ? "point on a surface" : "centre of an occupied cell of the truth")
      << ")\n";
  TextTable table;
  table.add({"map", "distance, mean [cm]", "95 % [cm]", "surface covered", "occupied per surface cell",
             "surface called free", "free called free", "F1"});
  for (const MapScores& map : maps)
  {
    const MapGeometry& shape = *map.geometry;
    table.add({map.name, centimetreText(shape.meanDistance_m), centimetreText(shape.distance95_m),
               percentText(shape.covered), numberText(shape.occupiedPerSurfaceCell),
               percentText(shape.surfaceCalledFree), percentText(shape.freeCalledFree),
               numberText(shape.f1)});
  }
  table.print(out);
}

/// Why scores are undefined.
std::string oneClassNote(const Scores& scores, const char* which)
{
  if (scores.cells() == 0 || (scores.occupied > 0 && scores.free > 0)) return "";
  return mrpt::format("%s are all %s: AUC and average precision are undefined", which,
                      scores.occupied > 0 ? "occupied" : "free");
}

using tools::jsonOf;

Json jsonOf(const PrecisionRecall& score)
{
  return {{"precision", jsonOf(score.precision)}, {"recall", jsonOf(score.recall)}};
}

Json jsonOf(const MapGeometry& shape)
{
  return {{"distancesTo", shape.toPoints ? "points" : "cells"},
          {"occupiedCells", shape.occupiedCells},
          {"surfaceCells", shape.surfaceCells},
          {"meanDistance", jsonOf(shape.meanDistance_m)},
          {"distance95", jsonOf(shape.distance95_m)},
          {"covered", jsonOf(shape.covered)},
          {"occupiedPerSurfaceCell", jsonOf(shape.occupiedPerSurfaceCell)},
          {"surfaceCalledFree", jsonOf(shape.surfaceCalledFree)},
          {"freeCalledFree", jsonOf(shape.freeCalledFree)},
          {"f1", jsonOf(shape.f1)}};
}

Json jsonOf(const Scores& scores)
{
  Json json{{"cells", scores.cells()},
            {"occupied", scores.occupied},
            {"free", scores.free},
            {"auc", jsonOf(scores.areaUnderRoc)},
            {"averagePrecision", jsonOf(scores.averagePrecision)},
            {"logLoss", jsonOf(scores.logLoss)},
            {"brier", jsonOf(scores.brier)},
            {"calibrationError", jsonOf(scores.calibrationError)}};
  json["thresholds"] = Json::array();
  for (const ThresholdScore& score : scores.thresholds)
    json["thresholds"].push_back(
        {{"threshold", score.threshold}, {"above", jsonOf(score.above)}, {"atLeast", jsonOf(score.atLeast)}});
  return json;
}
}  // namespace

void printScores(const std::vector<MapScores>& maps, const std::string& cells, std::ostream& out)
{
  if (maps.empty()) return;
  printBlock(
      maps,
      "all " + cells + mrpt::format(" (one that the map has not observed counts as %g)", kUnobservedProb),
      &MapScores::all, out);
  printThresholds(maps, "  precision / recall", &MapScores::all, out);
  printBlock(maps, "observed " + cells, &MapScores::observed, out);
  printThresholds(maps, "  precision / recall", &MapScores::observed, out);
  printGeometry(maps, out);
  for (const MapScores& map : maps)
  {
    out << mrpt::format("%s: %s, %g m; %.1f %% of the cells observed\n", map.name.c_str(),
                        map.className.c_str(), map.resolution_m, 100 * map.observedShare());
    for (const std::string& note : map.notes) out << "  " << note << "\n";
    for (const std::string& note :
         {oneClassNote(map.all, "the cells"), oneClassNote(map.observed, "the observed cells")})
      if (!note.empty()) out << "  " << note << "\n";
  }
  out << mrpt::format(
      "log loss in nats, probabilities clipped to [%g, 1 - %g]; calibration error over %zu bins\n",
      kLogLossClip, kLogLossClip, kCalibrationBins);
}

Json scoresJson(const MapScores& map)
{
  Json json{{"map", map.name},
            {"class", map.className},
            {"resolution", map.resolution_m},
            {"observedShare", map.observedShare()},
            {"notes", map.notes},
            {"all", jsonOf(map.all)},
            {"observed", jsonOf(map.observed)}};
  if (map.geometry) json["geometry"] = jsonOf(*map.geometry);
  return json;
}

Json scoringJson()
{
  return {{"unobservedProb", kUnobservedProb},
          {"logLossClip", kLogLossClip},
          {"calibrationBins", kCalibrationBins},
          {"thresholdTolerance", kThresholdTolerance},
          {"calledFreeBelow", kCalledFreeBelow}};
}

}  // namespace lamap::tools
