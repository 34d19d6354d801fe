#include <gtest/gtest.h>
#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <lamap_tools/commands/compare.h>
#include <lamap_tools/commands/comparison_page.h>
#include <lamap_tools/commands/held_out.h>
#include <lamap_tools/files/usage_error.h>
#include <lamap_tools/report/text_table.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationPointCloud.h>

#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>

#include "support/small_logs.h"
#include "support/temporary_folder.h"

namespace
{
using namespace lamap;
using namespace lamap::tools;
using namespace lamap::test;

/// A log of 9 laser scans along a wall, and a truth of three cells around it.
class Compare : public testing::Test
{
 protected:
  Compare()
  {
    Objects log;
    for (int i = 0; i < 9; ++i)
    {
      log.push_back(odometry(at(i), 0.05 * i, 0, 0));
      log.push_back(laser(at(i), 2));
    }
    writeLog(folder_ / "log.rawlog", log);
    options_.inputs.paths = {folder_ / "log.rawlog"};
    options_.threads = 1;
  }

  template <class Error>
  std::string complaint(const CompareOptions& options) const
  {
    try
    {
      (void)compareMaps(options);
    }
    catch (const Error& error)
    {
      return error.what();
    }
    return "";
  }

  TemporaryFolder folder_;
  CompareOptions options_;
};

// What it finds is what `lamap eval` finds of maps that `lamap build` made of the same log.
TEST_F(Compare, ScoresAsEvalDoesOfMapsBuiltOneByOne)
{
  options_.maps = {"bgkMap", "bgkMap insertOpts.freeWeight=0.25", "octoMap"};
  options_.heldOutEvery = 3;
  options_.maxRange_m = 10;
  const Comparison comparison = compareMaps(options_);
  ASSERT_EQ(comparison.maps.size(), 3U);
  for (const ComparedMap& compared : comparison.maps)
  {
    SCOPED_TRACE(compared.name);
    HeldOutOptions one;
    one.inputs = options_.inputs;
    one.map.mapName = compared.name.substr(0, compared.name.find(' '));
    if (compared.name.find(' ') != std::string::npos)
      one.map.settings = {compared.name.substr(compared.name.find(' ') + 1)};
    one.every = 3;
    one.maxRange_m = 10;
    const HeldOutReport expected = scoreHeldOut(one);
    ASSERT_TRUE(compared.scores);
    EXPECT_EQ(compared.scores->all.cells(), expected.scores.all.cells());
    EXPECT_EQ(compared.scores->all.logLoss, expected.scores.all.logLoss);
    EXPECT_EQ(compared.scores->observed.areaUnderRoc, expected.scores.observed.areaUnderRoc);
    EXPECT_EQ(compared.scans.usedCount(), 6U);
    EXPECT_GT(compared.insertion_s, 0);
    EXPECT_GT(compared.memoryBytes.value_or(0), 1000U);
  }
  EXPECT_NE(comparison.maps[0].scores->all.logLoss, comparison.maps[1].scores->all.logLoss);
  EXPECT_TRUE(comparison.notes.empty());
}

TEST_F(Compare, MapsAreThoseThatTheConfigurationCountsAndElseTheUsualFour)
{
  folder_.write("maps.ini",
                "[map]\nbgkMap_count = 1\noctoMap_count = 1\n[map_bgkMap_00_creationOpts]\nresolution = 0.2\n"
                "[map_octoMap_00_creationOpts]\nresolution = 0.25\n");
  options_.configPath = folder_ / "maps.ini";
  options_.settings = {"insertOpts.maxRange=5"};
  options_.heldOutEvery = 3;
  const Comparison counted = compareMaps(options_);
  ASSERT_EQ(counted.maps.size(), 2U);
  EXPECT_EQ(counted.maps[0].cells->resolution(), 0.2);
  EXPECT_EQ(counted.maps[1].cells->resolution(), 0.25);
  EXPECT_EQ(dynamic_cast<const CLearnedMap&>(*counted.maps[0].map).rangeLimits().maxRange, 5);
  ASSERT_EQ(counted.notes.size(), 1U) << "cells of two sizes";
  EXPECT_NE(counted.notes[0].find("different sizes"), std::string::npos);
  options_.configPath.clear();
  options_.settings.clear();
  options_.heldOutEvery = 0;
  const Comparison usual = compareMaps(options_);
  ASSERT_EQ(usual.maps.size(), 4U);
  EXPECT_FALSE(usual.maps[0].scores);
}

TEST_F(Compare, ThePageHoldsTableAndPicturesOfTruthAndMaps)
{
  std::string truth = "x,y,z,label\n";
  for (const char* cell : {"0.55,0.05,0.05,0", "0.65,0.05,0.05,0", "1.95,0.05,0.05,1", "2.05,0.05,0.05,1"})
    truth += std::string(cell) + "\n";
  folder_.write("truth.csv", truth);
  options_.maps = {"bgkMap creationOpts.planar=true", "occupancyGrid",
                   "strict: bgkMap insertOpts.freeThreshold=0.2"};
  options_.truthPath = folder_ / "truth.csv";
  options_.pagePath = folder_ / "page.html";
  options_.tablePath = folder_ / "table.md";
  const Comparison comparison = compareMaps(options_);
  EXPECT_EQ(comparison.pagePath, options_.pagePath);
  const std::string page = fileContent(options_.pagePath);
  const auto countOf = [&](const std::string& text)
  {
    size_t count = 0;
    for (size_t at = page.find(text); at != std::string::npos; at = page.find(text, at + 1)) ++count;
    return count;
  };
  EXPECT_EQ(countOf("<tr>"), 4U);
  EXPECT_EQ(comparison.maps[2].name, "strict");
  std::istringstream table(fileContent(options_.tablePath));
  std::string line;
  std::getline(table, line);
  EXPECT_EQ(line.rfind("| map | AUC |", 0), 0U) << line;
  std::getline(table, line);
  EXPECT_EQ(line.rfind("|---|---:|", 0), 0U) << line;
  std::getline(table, line);
  EXPECT_EQ(line.rfind("| bgkMap creationOpts.planar=true | ", 0), 0U) << line;
  const MapGeometry& shape = *comparison.maps[0].scores->geometry;
  EXPECT_NE(line.find(" | " + centimetreText(shape.meanDistance_m) + " / " +
                      centimetreText(shape.distance95_m) + " | " + percentText(shape.covered) + " | "),
            std::string::npos)
      << line;
  EXPECT_EQ(countOf("src=\"data:image/png;base64,iVBORw0KGgo"), 4U + 4U) << page.substr(0, 2000);
  EXPECT_EQ(countOf("\n\"") + countOf("No picture"), 0U);
  EXPECT_NE(page.find("</html>"), std::string::npos);
  size_t files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder_.path())) ++files;
  EXPECT_EQ(files, 4U) << "nothing is left beside log, truth, page and table";
}

TEST_F(Compare, TheTableForProgramsHasANumberAField)
{
  options_.maps = {"bgkMap", "a, b: octoMap"};
  options_.heldOutEvery = 3;
  options_.thresholds = {0.999999};
  options_.tablePath = folder_ / "table.csv";
  const Comparison comparison = compareMaps(options_);
  std::istringstream table(fileContent(options_.tablePath));
  std::string line;
  std::getline(table, line);
  EXPECT_EQ(line,
            "map,auc,average_precision,log_loss,brier,observed_calibration_error,observed_share,"
            "precision_at_0.999999,recall_at_0.999999,auc_of_returned,log_loss_of_returned,scans,ms_per_scan,"
            "memory_bytes");
  std::getline(table, line);
  std::vector<std::string> fields;
  std::istringstream row(line);
  for (std::string field; std::getline(row, field, ',');) fields.push_back(field);
  ASSERT_EQ(fields.size(), 14U) << line;
  const MapScores& scores = *comparison.maps[0].scores;
  EXPECT_EQ(std::stod(fields[3]), *scores.all.logLoss);
  EXPECT_EQ(std::stod(fields[5]), *scores.observed.calibrationError);
  EXPECT_EQ(std::stod(fields[6]), scores.observedShare());
  EXPECT_EQ(fields[7], "") << "no cell is called occupied";
  EXPECT_EQ(fields[8], "0");
  EXPECT_EQ(std::stod(fields[10]), *comparison.maps[0].scoresOfReturned->all.logLoss);
  EXPECT_EQ(std::stoull(fields[13]), *comparison.maps[0].memoryBytes);
  std::getline(table, line);
  EXPECT_EQ(line.rfind("\"a, b\",", 0), 0U) << line;
}

TEST_F(Compare, AMapThatRefusesASettingOfAllIsARowThatSaysWhy)
{
  options_.maps = {"octoMap", "bgkMap"};
  options_.settings = {"creationOpts.planar=true"};
  options_.heldOutEvery = 3;
  const Comparison comparison = compareMaps(options_);
  ASSERT_EQ(comparison.maps.size(), 1U);
  EXPECT_EQ(comparison.maps[0].name, "bgkMap");
  EXPECT_TRUE(comparison.maps[0].scores);
  ASSERT_EQ(comparison.refused.size(), 1U);
  EXPECT_EQ(comparison.refused[0].name, "octoMap");
  EXPECT_EQ(comparison.refused[0].reason.rfind("-s creationOpts.planar: no such key", 0), 0U)
      << comparison.refused[0].reason;

  const auto people = comparisonTable(comparison, ForWhom::People).rows();
  ASSERT_EQ(people.size(), 3U);
  EXPECT_EQ(people[1].back(), "");
  EXPECT_EQ(people[2].front(), "octoMap");
  EXPECT_EQ(people[2].back(), comparison.refused[0].reason);
  EXPECT_EQ(people[2].size(), people[0].size());
  EXPECT_EQ(comparisonJson(comparison)["refused"][0]["map"], "octoMap");

  options_.maps = {"bgkMap", "octoMap creationOpts.planar=false"};
  EXPECT_NE(complaint<UsageError>(options_).find("planar"), std::string::npos) << "its own setting";
  options_.settings = {"insertOpts.maxRange=3", "insertOpts.maxrange=4"};
  options_.maps = {"bgkMap"};
  EXPECT_NE(complaint<UsageError>(options_).find("given twice"), std::string::npos);
  options_.settings.pop_back();
  options_.maps = {"bgkMap insertOpts.maxrange=4"};
  EXPECT_EQ(complaint<UsageError>(options_), "") << "a map's own setting goes over that of all";
}

TEST_F(Compare, AMapThatTakesNoScanOfTheLogIsARowThatSaysWhy)
{
  auto points = mrpt::maps::CSimplePointsMap::Create();
  points->insertPoint(2, 0.1F, 0.2F);
  auto cloud = mrpt::obs::CObservationPointCloud::Create();
  cloud->pointcloud = points;
  cloud->timestamp = at(0);
  writeLog(folder_ / "clouds.rawlog", {odometry(at(0), 0, 0, 0), cloud});
  options_.inputs.paths = {folder_ / "clouds.rawlog"};
  options_.maps = {"occupancyGrid", "bgkMap"};
  const Comparison comparison = compareMaps(options_);
  ASSERT_EQ(comparison.maps.size(), 1U);
  EXPECT_EQ(comparison.maps[0].name, "bgkMap");
  ASSERT_EQ(comparison.refused.size(), 1U);
  EXPECT_NE(comparison.refused[0].reason.find("not one scan that the map takes; 1 CObservationPointCloud"),
            std::string::npos)
      << comparison.refused[0].reason;
  options_.maps = {"occupancyGrid"};
  EXPECT_NE(complaint<std::runtime_error>(options_).find("occupancyGrid: not one scan"), std::string::npos);
}

TEST_F(Compare, RefusesByName)
{
  CompareOptions wrong = options_;
  wrong.maps = {"bgkMap", "bgkMop"};
  EXPECT_NE(complaint<UsageError>(wrong).find("did you mean bgkMap"), std::string::npos);
  wrong.maps = {"bgkMap", "bgkMap"};
  EXPECT_NE(complaint<UsageError>(wrong).find("twice"), std::string::npos);
  wrong.maps = {"bgkMap insertOpts.maxRnge=3"};
  EXPECT_NE(complaint<UsageError>(wrong).find("maxRnge"), std::string::npos);
  EXPECT_EQ(complaint<UsageError>(wrong).rfind("-m 'bgkMap insertOpts.maxRnge=3': ", 0), 0U);
  wrong.maps = {"octoMap"};
  wrong.settings = {"creationOpts.planar=true"};
  EXPECT_NE(complaint<UsageError>(wrong).find("of one map only stands after its name"), std::string::npos);
  wrong.settings.clear();
  wrong.maps = {": bgkMap"};
  EXPECT_NE(complaint<UsageError>(wrong).find("label is empty"), std::string::npos);
  for (const char* unspaced : {"wide:bgkMap", "wide:", "wide:bgkMap insertOpts.maxRange=3"})
  {
    wrong.maps = {unspaced};
    EXPECT_NE(complaint<UsageError>(wrong).find("a space after the colon"), std::string::npos) << unspaced;
  }
  wrong.maps = {"pointsMap"};
  EXPECT_NE(complaint<UsageError>(wrong).find("no cells"), std::string::npos);
  wrong.maps = {" "};
  EXPECT_NE(complaint<UsageError>(wrong), "");
  wrong.maps = {"bgkMap"};
  wrong.pagePath = folder_ / "page.pdf";
  EXPECT_NE(complaint<UsageError>(wrong).find(".html"), std::string::npos);
  wrong.pagePath = folder_ / "none/page.html";
  EXPECT_NE(complaint<std::runtime_error>(wrong).find("none"), std::string::npos);
  wrong.pagePath.clear();
  wrong.heldOutEvery = 20;
  EXPECT_NE(complaint<std::runtime_error>(wrong).find("9 usable scans"), std::string::npos);
  wrong.heldOutEvery = 3;
  wrong.truthPath = "truth.csv";
  EXPECT_NE(complaint<UsageError>(wrong).find("--held-out"), std::string::npos);
  wrong.truthPath.clear();
  wrong.inputs.paths = {folder_ / "none.rawlog"};
  EXPECT_NE(complaint<std::runtime_error>(wrong).find("none.rawlog"), std::string::npos);
}
}  // namespace
