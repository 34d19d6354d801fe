#include <gtest/gtest.h>
#include <lamap_core/training/scan_labels.h>
#include <lamap_mrpt/observations/observation_rays.h>
#include <lamap_tools/commands/held_out.h>
#include <lamap_tools/commands/tune.h>
#include <lamap_tools/config/map_setup.h>
#include <lamap_tools/files/usage_error.h>

#include <cmath>
#include <sstream>
#include <stdexcept>

#include "support/small_logs.h"
#include "support/temporary_folder.h"

namespace
{
using namespace lamap;
using namespace lamap::tools;
using namespace lamap::test;

class Tune : public testing::Test
{
 protected:
  Tune()
  {
    Objects log;
    for (int i = 0; i < 9; ++i)
    {
      log.push_back(odometry(at(i), 0.1 * i, 0, 0));
      log.push_back(scanAt(i));
    }
    writeLog(folder_ / "a.rawlog", log);
  }

  static mrpt::obs::CObservation2DRangeScan::Ptr scanAt(int i)
  {
    return laser(at(i), 2 + 0.02F * static_cast<float>(i));
  }

  TuneOptions optionsFor(const std::vector<std::string>& settings, const std::string& map = "bgkMap") const
  {
    TuneOptions options;
    options.inputs.paths = {folder_ / "a.rawlog"};
    options.map.mapName = map;
    options.map.settings = settings;
    options.every = 3;
    return options;
  }

  template <class Error>
  static std::string complaint(const TuneOptions& options)
  {
    try
    {
      (void)tuneMap(options);
    }
    catch (const Error& error)
    {
      return error.what();
    }
    return "";
  }

  TemporaryFolder folder_;
};

TEST_F(Tune, EveryCombinationHasTheScoresOfItsOwnEvaluation)
{
  const auto report = tuneMap(optionsFor(
      {"insertOpts.kernelSupport=0.15,0.3", "insertOpts.maxRange=6", "insertOpts.freeWeight=0.25,0.5,1"}));
  ASSERT_EQ(report.maps.size(), 6U);
  EXPECT_EQ(report.scored, 3U);
  double last = 0;
  for (const TunedMap& map : report.maps)
  {
    EXPECT_GE(*map.scores.all.logLoss, last) << "the best stands first";
    last = *map.scores.all.logLoss;
    HeldOutOptions alone;
    alone.inputs.paths = {folder_ / "a.rawlog"};
    alone.map.mapName = "bgkMap";
    alone.map.settings = map.settings;
    alone.map.settings.push_back("insertOpts.maxRange=6");
    alone.every = 3;
    const MapScores scores = scoreHeldOut(alone).scores;
    EXPECT_EQ(*map.scores.all.logLoss, *scores.all.logLoss);
    EXPECT_EQ(map.scores.all.areaUnderRoc, scores.all.areaUnderRoc);
    EXPECT_EQ(map.scores.all.cells(), scores.all.cells());
  }
  EXPECT_LT(*report.maps.front().scores.all.logLoss, last) << "all settings are equally good";
}

// By hand: each scan but the first is asked of a map of those before it.
TEST_F(Tune, PrequentialScoresAScanByWhatCameBefore)
{
  TuneOptions options = optionsFor({"insertOpts.freeWeight=0.5,1", "insertOpts.maxRange=6"});
  options.prequential = true;
  const auto report = tuneMap(options);
  EXPECT_EQ(report.scored, 8U);
  MapRequest request = options.map;
  request.settings = {report.maps.front().settings.front(), "insertOpts.maxRange=6"};
  const auto map = createMap(readMapDefinition(request));
  const auto cells = cellsOf(map);
  LabelRules rules;
  rules.maxRange_m = 6;
  double sum = 0, count = 0;
  for (int i = 0; i < 9; ++i)
  {
    const mrpt::poses::CPose3D pose(mrpt::poses::CPose2D(0.1 * i, 0, 0));
    const ScanLabels labels = labelCells(*raysOf(*scanAt(i), pose), rules);
    const auto ask = [&](const CellIndex& cell, double label)
    {
      const Eigen::Vector3d centre = cellCentre(cell, 0.1);
      const auto estimate = cells->estimateAt({centre.x(), centre.y(), centre.z()});
      sum += std::pow((estimate ? estimate->prob : 0.5) - label, 2);
      ++count;
    };
    if (i > 0)
    {
      for (const CellIndex& cell : labels.occupied) ask(cell, 1);
      for (const CellIndex& cell : labels.free) ask(cell, 0);
    }
    map->insertObservation(*scanAt(i), pose);
  }
  EXPECT_EQ(static_cast<double>(report.maps.front().scores.all.cells()), count);
  EXPECT_NEAR(*report.maps.front().scores.all.brier, sum / count, 1e-12);
}

// The sensor loses every ray of most scans, to a wall that it sees in the others: a map that takes lost rays
// for open space predicts lost rays best, and returns worst.
TEST_F(Tune, GoesByTheRaysThatReturnedUnlessToldOtherwise)
{
  Objects log;
  for (int i = 0; i < 9; ++i)
  {
    log.push_back(odometry(at(i), 0.01 * i, 0, 0));
    auto scan = laser(at(i), 1);
    for (size_t ray = 0; ray < 9; ++ray)
    {
      scan->setScanRangeValidity(ray, i % 4 == 1);
      if (!scan->getScanRangeValidity(ray)) scan->setScanRange(ray, scan->maxRange);
    }
    log.push_back(scan);
  }
  writeLog(folder_ / "a.rawlog", log);
  TuneOptions options = optionsFor({"insertOpts.considerInvalidRangesAsFreeSpace=true,false",
                                    "insertOpts.maxRange=6", "insertOpts.freeWeight=20"});
  for (const bool prequential : {false, true})
  {
    SCOPED_TRACE(prequential);
    options.prequential = prequential;
    options.rankByAllRays = false;
    const TuneReport byReturned = tuneMap(options);
    EXPECT_FALSE(byReturned.rankedByAllRays);
    EXPECT_EQ(byReturned.maps.front().settings.front(), "insertOpts.considerInvalidRangesAsFreeSpace=false");
    EXPECT_LT(*byReturned.maps[0].scoresOfReturned.all.logLoss,
              *byReturned.maps[1].scoresOfReturned.all.logLoss);
    options.rankByAllRays = true;
    const TuneReport byAll = tuneMap(options);
    EXPECT_EQ(byAll.maps.front().settings.front(), "insertOpts.considerInvalidRangesAsFreeSpace=true");
    EXPECT_EQ(*byAll.maps[0].scores.all.logLoss, *byReturned.maps[1].scores.all.logLoss);
    std::ostringstream text;
    printTuning(byAll, text);
    EXPECT_NE(text.str().find("(all rays)"), std::string::npos) << text.str();
    EXPECT_EQ(tuningJson(byAll)["rankedBy"], "allRays");
    EXPECT_EQ(tuningJson(byReturned)["rankedBy"], "returned");
  }
}

TEST_F(Tune, TheNumberOfThreadsChangesNothing)
{
  for (const std::string map : {"bgkMap", "octoMap"})
  {
    TuneOptions options = optionsFor(
        {map == "bgkMap" ? "insertOpts.freeWeight=0.25,0.5,1" : "insertOpts.probHit=0.6,0.7,0.8"}, map);
    options.threads = 1;
    const auto one = tuneMap(options);
    options.threads = 3;
    const auto three = tuneMap(options);
    for (size_t i = 0; i < 3; ++i)
    {
      EXPECT_EQ(one.maps[i].settings, three.maps[i].settings);
      EXPECT_EQ(one.maps[i].scores.all.logLoss, three.maps[i].scores.all.logLoss);
    }
  }
}

TEST_F(Tune, TheBestSettingsAreAConfigurationOfTheMap)
{
  TuneOptions options = optionsFor({"insertOpts.maxRange=7", "insertOpts.freeWeight=0.25,1"});
  options.map.configPath =
      folder_.write("start.ini",
                    "[map]\nbgkMap_count = 1\n[map_bgkMap_00_creationOpts]\nblockDepth = 3 // small\n"
                    "[map_bgkMap_00_insertOpts]\nFREEWEIGHT = 0.75\nkernelSupport = 0.25\n");
  options.map.mapName = "";
  options.outPath = folder_ / "best.ini";
  const auto report = tuneMap(options);
  const std::string text = fileContent(options.outPath);
  EXPECT_EQ(text.rfind("# The best of 2 settings by held-out log loss: ", 0), 0U) << text;
  EXPECT_NE(text.find("blockDepth = 3\n"), std::string::npos) << text;
  EXPECT_NE(text.find("kernelSupport = 0.25\n"), std::string::npos) << text;
  EXPECT_NE(text.find("maxRange = 7\n"), std::string::npos) << text;
  EXPECT_EQ(text.find("0.75"), std::string::npos) << text;
  HeldOutOptions best;
  best.inputs.paths = options.inputs.paths;
  best.map.configPath = options.outPath;
  best.every = 3;
  EXPECT_EQ(scoreHeldOut(best).scores.all.logLoss, report.maps.front().scores.all.logLoss);
}

TEST_F(Tune, RefusesSearchesThatSayNothing)
{
  const auto usage = [&](const std::vector<std::string>& settings)
  { return complaint<UsageError>(optionsFor(settings)); };
  EXPECT_NE(usage({"insertOpts.freeWeight=0.5"}).find("nothing to search"), std::string::npos);
  EXPECT_NE(usage({"insertOpts.freeWeight=0.5,"}).find("empty"), std::string::npos);
  EXPECT_NE(usage({"insertOpts.freeWeight=0.5,,1"}).find("empty"), std::string::npos);
  EXPECT_NE(usage({"insertOpts.freeWeight=0.5,1", "insertopts.freeweight=2,3"}).find("twice"),
            std::string::npos);
  EXPECT_NE(usage({"insertOpts.freeWeight=0.5,1,0.5"}).find("twice"), std::string::npos);
  EXPECT_NE(usage({"insertOpts.freeWeihgt=0.5,1"}).find("freeWeight"), std::string::npos);
  EXPECT_NE(usage({"insertOpts.minRange=1,9", "insertOpts.maxRange=5"})
                .find("(the combination insertOpts.minRange=9)"),
            std::string::npos);
  EXPECT_NE(usage({"creationOpts.resolution=0.1,0.2"}).find("cannot be compared"), std::string::npos);
  EXPECT_NE(usage({"insertOpts.maxRange=5,6"}).find("--max-range"), std::string::npos);
  std::string many = "insertOpts.freeWeight=0.001";
  for (int i = 2; i < 1100; ++i) many += "," + std::to_string(0.0005 * i);
  EXPECT_NE(usage({many}).find("1000 combinations"), std::string::npos);
  TuneOptions ranges = optionsFor({"insertOpts.maxRange=5,6"});
  ranges.maxRange_m = 6;
  EXPECT_EQ(complaint<std::exception>(ranges), "");
  TuneOptions textFile = optionsFor({"insertOpts.freeWeight=0.5,1"});
  textFile.outPath = folder_ / "best.txt";
  EXPECT_NE(complaint<UsageError>(textFile).find(".ini"), std::string::npos);
  TuneOptions few = optionsFor({"insertOpts.freeWeight=0.5,1"});
  few.every = 20;
  EXPECT_NE(complaint<std::runtime_error>(few).find("9 usable"), std::string::npos);
  few.outPath = folder_ / "none/best.ini";
  EXPECT_NE(complaint<std::runtime_error>(few).find("none"), std::string::npos);
  EXPECT_EQ(folder_.size(), 1U);
}

TEST_F(Tune, ReportsForPeopleAndScripts)
{
  const auto report = tuneMap(optionsFor({"insertOpts.freeWeight=0.5,1"}));
  std::ostringstream text;
  printTuning(report, text);
  EXPECT_NE(text.str().find("insertOpts.freeWeight=1"), std::string::npos) << text.str();
  const auto json = tuningJson(report);
  EXPECT_EQ(json["candidates"].size(), 2U);
  EXPECT_EQ(json["candidates"][0]["scores"]["all"]["logLoss"], *report.maps.front().scores.all.logLoss);
}
}  // namespace
