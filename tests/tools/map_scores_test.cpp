#include <gtest/gtest.h>
#include <lamap_mrpt/files/map_file.h>
#include <lamap_mrpt/maps/CBGKMap.h>
#include <lamap_tools/cells/octomap_file.h>
#include <lamap_tools/files/usage_error.h>
#include <lamap_tools/pictures/gnuplot.h>
#include <lamap_tools/scores/map_scores.h>
#include <lamap_tools/scores/score_report.h>
#include <mrpt/img/CImage.h>
#include <mrpt/maps/COccupancyGridMap2D.h>

#include <cmath>
#include <cstdlib>
#include <sstream>
#include <stdexcept>

#include "support/temporary_folder.h"
#include "tools/hand_made_cells.h"

namespace
{
using namespace lamap;
using namespace lamap::tools;
using test::HandMadeCells;

Truth truth(const std::string& text)
{
  std::istringstream in(text);
  return readTruthCsv(in, "t.csv");
}

OpenedMap opened(const HandMadeCells& cells)
{
  return {nullptr, std::make_unique<HandMadeCells>(cells), std::nullopt};
}

MapScores score(const HandMadeCells& cells, const std::string& text,
                const std::vector<double>& thresholds = {0.7})
{
  return scoreMap(opened(cells), "a", truth(text), thresholds);
}

std::string errorOf(const OpenedMap& map, const std::string& text)
{
  try
  {
    (void)scoreMap(map, "a.ot", truth(text), {});
  }
  catch (const std::runtime_error& error)
  {
    return error.what();
  }
  return "";
}

HandMadeCells threeCells()
{
  HandMadeCells map(0.1);
  map.put({0, 0, 0}, 0.9, CellState::Occupied).put({1, 0, 0}, 0.2, CellState::Free);
  map.put({2, 0, 1}, 0.6, CellState::Unknown);
  return map;
}

// Occupied .9, free .2 and .6, occupied and unobserved.
const std::string kFourCells =
    "x,y,z,label\n0.05,0.05,0.05,1\n0.15,0.05,0.05,0\n0.25,0.05,0.15,0\n0.35,0.05,0.05,1\n";

TEST(ScoreMap, OverAllCellsAndOverObservedOnesByHand)
{
  const MapScores scores = score(threeCells(), kFourCells, {0.5, 0.9});
  EXPECT_EQ(scores.all.cells(), 4U);
  EXPECT_EQ(scores.all.occupied, 2U);
  EXPECT_EQ(scores.observed.cells(), 3U);
  EXPECT_DOUBLE_EQ(scores.observedShare(), 0.75);
  EXPECT_DOUBLE_EQ(*scores.observed.areaUnderRoc, 1);
  EXPECT_DOUBLE_EQ(*scores.all.areaUnderRoc, 0.75) << "the unobserved 0.5 is below 0.6, above 0.2";
  EXPECT_DOUBLE_EQ(*scores.all.logLoss, -(std::log(0.9) + std::log(0.8) + std::log(0.4) + std::log(0.5)) / 4);
  EXPECT_DOUBLE_EQ(*scores.all.brier, (0.01 + 0.04 + 0.36 + 0.25) / 4);
  ASSERT_EQ(scores.all.thresholds.size(), 2U);
  EXPECT_DOUBLE_EQ(*scores.all.thresholds[0].above.precision, 0.5);
  EXPECT_DOUBLE_EQ(*scores.all.thresholds[0].above.recall, 0.5);
  EXPECT_DOUBLE_EQ(*scores.all.thresholds[0].atLeast.precision, 2.0 / 3);
  EXPECT_DOUBLE_EQ(*scores.all.thresholds[0].atLeast.recall, 1);
  EXPECT_EQ(scores.all.thresholds[1].above.precision, std::nullopt);
  EXPECT_TRUE(scores.notes.empty());
}

TEST(ScoreMap, ATruthOfSmallerCellsIsAskedAtItsCentresAndThatIsSaid)
{
  const MapScores scores =
      score(threeCells(), "0.025,0.025,0.025,1\n0.075,0.025,0.025,1\n0.125,0.075,0.075,0\n");
  EXPECT_EQ(scores.all.cells(), 3U);
  EXPECT_EQ(scores.observed.occupied, 2U);
  EXPECT_NEAR(*scores.all.brier, (0.01 + 0.01 + 0.04) / 3, 1e-12);
  ASSERT_EQ(scores.notes.size(), 1U);
  EXPECT_NE(scores.notes[0].find("resampled"), std::string::npos);
}

// Two parts of the cell [0, 0.2)³ are observed, (0,0,0) and (1,0,0); the other cell is not observed at all.
TEST(ScoreMap, ATruthOfLargerCellsCountsAsItsParts)
{
  const MapScores scores = score(threeCells(), "0.1,0.1,0.1,1\n0.1,0.3,0.3,0\n");
  EXPECT_EQ(scores.all.cells(), 16U);
  EXPECT_EQ(scores.all.occupied, 8U);
  EXPECT_EQ(scores.observed.occupied, 2U);
  EXPECT_EQ(scores.observed.free, 0U);
  ASSERT_EQ(scores.notes.size(), 1U);
  EXPECT_NE(scores.notes[0].find("2 along an edge"), std::string::npos) << scores.notes[0];
  EXPECT_EQ(score(threeCells(), "0.1,0.1,0.05,1\n0.1,0.3,0.05,0\n").all.cells(), 8U)
      << "of one layer, in the plane";
}

TEST(ScoreMap, OddCellsThatFitTheMapsAreAskedAtTheirCentres)
{
  const MapScores scores = score(threeCells(), "0.15,0.15,0.15,1\n0.15,0.45,0.45,0\n0.15,0.05,0.05,0\n");
  EXPECT_EQ(scores.all.cells(), 3U);
  EXPECT_TRUE(scores.notes.empty());
}

TEST(ScoreMap, RefusesATruthBetweenTheCells)
{
  const std::string error = errorOf(opened(threeCells()), "0,0,0,1\n0.1,0,0,0\n0.1,0.1,0.1,0\n");
  for (const std::string word : {"t.csv", "a.ot", "grid", "(i + 1/2)"})
    EXPECT_NE(error.find(word), std::string::npos) << error;
  const std::string coarse = errorOf(opened(threeCells()), "2.5,2.5,2.5,1\n7.5,2.5,7.5,0\n12.5,7.5,7.5,1\n");
  EXPECT_NE(coarse.find("finer truth"), std::string::npos) << coarse;
}

TEST(ScoreMap, RefusesAnEmptyMapAndATruthElsewhere)
{
  EXPECT_EQ(errorOf(opened(HandMadeCells(0.1)), kFourCells), "a.ot: is empty, there is nothing to score");
  const std::string error = errorOf(opened(threeCells()), "7.05,0.05,0.05,1\n8.05,0.05,0.05,0\n");
  for (const std::string word : {"none of the cells", "0.05 to 0.25", "7.05 to 8.05"})
    EXPECT_NE(error.find(word), std::string::npos) << error;
}

TEST(ScoreMap, OfOneClassGivesWhatIsDefinedAndSaysWhatIsNot)
{
  const MapScores scores = score(threeCells(), "0.05,0.05,0.05,1\n0.15,0.05,0.05,1\n");
  EXPECT_FALSE(scores.all.areaUnderRoc || scores.all.averagePrecision);
  EXPECT_TRUE(scores.all.logLoss && scores.all.brier && scores.all.calibrationError);
  std::ostringstream text;
  printScores({scores}, "cells", text);
  EXPECT_NE(text.str().find("all occupied: AUC and average precision are undefined"), std::string::npos)
      << text.str();
  const auto json = scoresJson(scores);
  EXPECT_TRUE(json["all"]["auc"].is_null());
  EXPECT_TRUE(json["all"]["logLoss"].is_number());
  const test::TemporaryFolder folder;
  EXPECT_THROW(writeRocCurves({scores}, folder / "r.csv"), std::runtime_error);
  EXPECT_EQ(folder.size(), 0U);
}

TEST(ScoreMap, OfOneLayerCountsThatLayerAlone)
{
  CBGKMap::TCreationOptions creation;
  creation.planar = true;
  creation.planarHeight = 0.52;
  auto map = std::make_shared<CBGKMap>(creation);
  map->updateVoxel(0.05, 0.05, 0.55, true);
  OpenedMap planar;
  planar.map = map;
  planar.cells = cellsOf(map);
  const MapScores inLayer =
      scoreMap(planar, "p", truth("0.05,0.05,0.05,0\n0.05,0.05,0.55,1\n0.05,0.05,0.65,0\n"), {});
  EXPECT_EQ(inLayer.all.cells(), 1U);
  EXPECT_EQ(inLayer.observed.occupied, 1U);
  ASSERT_EQ(inLayer.notes.size(), 1U);
  EXPECT_EQ(scoreMap(planar, "p", truth("0.05,0.05,7,1\n0.35,0.05,7,0\n"), {}).observed.occupied, 1U)
      << "a truth of one layer is that layer, at whatever height";

  auto grid = mrpt::maps::COccupancyGridMap2D::Create(-1.0F, 1.0F, -1.0F, 1.0F, 0.1F);
  grid->setCell(grid->x2idx(0.05F), grid->y2idx(0.05F), 0.1F);
  OpenedMap flat;
  flat.map = grid;
  flat.cells = cellsOf(grid);
  EXPECT_EQ(scoreMap(flat, "g", truth("0.05,0.05,0.45,1\n0.35,0.05,0.45,0\n"), {}).observed.occupied, 1U);
}

TEST(ScoreReport, JsonHasTheScoresAsNumbers)
{
  const auto json = scoresJson(score(threeCells(), kFourCells));
  EXPECT_EQ(json["map"], "a");
  EXPECT_EQ(json["all"]["cells"], 4);
  EXPECT_EQ(json["all"]["auc"], 0.75);
  EXPECT_EQ(json["observedShare"], 0.75);
  EXPECT_EQ(json["all"]["thresholds"][0]["threshold"], 0.7);
  EXPECT_EQ(json["all"]["thresholds"][0]["above"]["precision"], 1.0);
  EXPECT_EQ(scoringJson()["unobservedProb"], 0.5);
}

TEST(ScoreReport, OneTableHoldsAllMaps)
{
  MapScores first = score(threeCells(), kFourCells);
  MapScores second = first;
  second.name = "a much longer name.lamap.gz";
  std::ostringstream text;
  printScores({first, second}, "cells", text);
  EXPECT_NE(text.str().find("0.7500"), std::string::npos);
  EXPECT_NE(text.str().find("1.0000 / 0.5000"), std::string::npos) << text.str();
  EXPECT_NE(text.str().find("p >= 0.7"), std::string::npos);
  EXPECT_NE(text.str().find("75.0 %"), std::string::npos);
}

TEST(ScoreCurves, AsCsv)
{
  const test::TemporaryFolder folder;
  MapScores scores = score(threeCells(), kFourCells);
  scores.name = "odd, \"name\".ot";
  writeRocCurves({scores}, folder / "r.csv");
  EXPECT_EQ(test::fileContent(folder / "r.csv"),
            "map,cells,threshold,false_positive_rate,true_positive_rate\n"
            "\"odd, \"\"name\"\".ot\",all,inf,0,0\n"
            "\"odd, \"\"name\"\".ot\",all,0.9,0,0.5\n"
            "\"odd, \"\"name\"\".ot\",all,0.6,0.5,0.5\n"
            "\"odd, \"\"name\"\".ot\",all,0.5,0.5,1\n"
            "\"odd, \"\"name\"\".ot\",all,0.2,1,1\n"
            "\"odd, \"\"name\"\".ot\",observed,inf,0,0\n"
            "\"odd, \"\"name\"\".ot\",observed,0.9,0,1\n"
            "\"odd, \"\"name\"\".ot\",observed,0.2,1,1\n");
  writeCalibration({score(threeCells(), kFourCells)}, folder / "c.csv");
  const std::string bins = test::fileContent(folder / "c.csv");
  EXPECT_EQ(
      bins.rfind("map,cells,low,high,count,mean_prob,occupied_share\na,all,0,0.1,0,,\na,all,0.1,0.2,0,,\n"
                 "a,all,0.2,0.3,1,0.2,0\n",
                 0),
      0U)
      << bins;
  EXPECT_NE(bins.find("a,all,0.5,0.6,1,0.5,1\n"), std::string::npos) << bins;
  EXPECT_NE(bins.find("a,observed,0.9,1,1,0.9,1\n"), std::string::npos) << bins;
}

TEST(ScoreCurves, AsPlots)
{
  if (std::system("gnuplot --version > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "gnuplot is not installed (Debian package gnuplot-nox)";
  const test::TemporaryFolder folder;
  MapScores scores = score(threeCells(), kFourCells);
  scores.name = "it's 100% {odd}_name";
  writeRocCurves({scores}, folder / "r'1.png");
  writeCalibration({scores}, folder / "c.png");
  for (const char* name : {"r'1.png", "c.png"})
  {
    mrpt::img::CImage picture;
    ASSERT_TRUE(picture.loadFromFile(folder / name)) << name;
    EXPECT_GT(picture.getWidth(), 1000U);
    size_t coloured = 0;
    for (int y = 0; y < static_cast<int>(picture.getHeight()); ++y)
      for (int x = 0; x < static_cast<int>(picture.getWidth()); ++x)
      {
        const auto* pixel = picture.ptr<uint8_t>(x, y);
        coloured += std::abs(pixel[0] - pixel[1]) > 60 ? 1 : 0;
      }
    EXPECT_GT(coloured, 300U) << "no curve in " << name;
  }
  EXPECT_EQ(folder.size(), 2U) << "temporary files are left";
}

TEST(ScoreCurves, FilesThatCannotBeWrittenAreRefusedBeforeTheWork)
{
  const test::TemporaryFolder folder;
  EXPECT_THROW(requireCurveFile(folder / "r.pdf"), UsageError);
  EXPECT_THROW(requireCurveFile(folder / "none/r.csv"), std::runtime_error);
  EXPECT_NO_THROW(requireCurveFile(folder / "r.CSV"));
  EXPECT_EQ(folder.size(), 0U);
  const std::string before = std::getenv("PATH");
  setenv("PATH", folder.path().c_str(), 1);
  try
  {
    requireCurveFile(folder / "r.png");
    ADD_FAILURE() << "there is no gnuplot";
  }
  catch (const std::runtime_error& error)
  {
    EXPECT_NE(std::string(error.what()).find("gnuplot-nox"), std::string::npos) << error.what();
  }
  setenv("PATH", before.c_str(), 1);
}

TEST(Gnuplot, SaysWhatIsWrongAndLeavesNothing)
{
  if (std::system("gnuplot --version > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "gnuplot is not installed (Debian package gnuplot-nox)";
  const test::TemporaryFolder folder;
  try
  {
    drawWithGnuplot("plot nonsense(\n", folder / "p.png", 100, 100);
    ADD_FAILURE() << "taken";
  }
  catch (const std::runtime_error& error)
  {
    EXPECT_NE(std::string(error.what()).find("nonsense"), std::string::npos) << error.what();
  }
  EXPECT_EQ(folder.size(), 0U);
}
}  // namespace
