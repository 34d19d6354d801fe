#include <gtest/gtest.h>
#include <lamap_mrpt/files/map_file.h>
#include <lamap_mrpt/maps/CBGKMap.h>
#include <lamap_tools/cells/cell_map.h>
#include <lamap_tools/commands/log_info.h>
#include <lamap_tools/commands/map_build.h>
#include <lamap_tools/files/usage_error.h>
#include <lamap_tools/report/counted.h>
#include <lamap_tools/report/progress_bar.h>
#include <mrpt/maps/COctoMap.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationComment.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>
#include <octomap/OcTree.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <set>
#include <sstream>
#include <stdexcept>

#include "support/small_logs.h"
#include "support/temporary_folder.h"

namespace
{
using namespace lamap::tools;
using namespace lamap::test;

BuildOptions optionsFor(const std::string& map, const std::vector<std::string>& inputs,
                        const std::string& output)
{
  BuildOptions options;
  options.map.mapName = map;
  options.inputs.paths = inputs;
  options.outPath = output;
  return options;
}

Objects logFrom(int first, int last)
{
  Objects objects;
  for (int i = first; i < last; ++i)
  {
    objects.push_back(odometry(at(i), 0.3 * i, 0.1, 0.02 * i));
    objects.push_back(laser(at(i), 1 + 0.1F * static_cast<float>(i)));
  }
  return objects;
}

template <class Error>
std::string complaint(const BuildOptions& options)
{
  try
  {
    (void)buildMap(options);
  }
  catch (const Error& error)
  {
    return error.what();
  }
  return "";
}

TEST(Build, GoingOnWithASavedMapGivesTheSameBytesAsOneBuild)
{
  const TemporaryFolder folder;
  writeLog(folder / "first.rawlog", logFrom(0, 6));
  writeLog(folder / "second.rawlog", logFrom(6, 12));
  auto whole =
      optionsFor("bgkMap", {folder / "first.rawlog", folder / "second.rawlog"}, folder / "whole.lamap.gz");
  whole.map.settings = {"insertOpts.maxRange=7.5"};
  EXPECT_EQ(buildMap(whole).scans.usedCount(), 12U);

  auto first = optionsFor("bgkMap", {folder / "first.rawlog"}, folder / "part.lamap.gz");
  first.map.settings = whole.map.settings;
  (void)buildMap(first);
  EXPECT_NE(fileContent(folder / "part.lamap.gz"), fileContent(folder / "whole.lamap.gz"));
  auto second = optionsFor("", {folder / "second.rawlog"}, folder / "part.lamap.gz");
  second.ontoPath = folder / "part.lamap.gz";
  (void)buildMap(second);
  EXPECT_EQ(fileContent(folder / "part.lamap.gz"), fileContent(folder / "whole.lamap.gz"));
}

TEST(Build, TheNumberOfThreadsDoesNotChangeAByte)
{
  const TemporaryFolder folder;
  writeLog(folder / "a.rawlog", logFrom(0, 6));
  for (const unsigned threads : {1U, 2U, 5U})
  {
    auto options =
        optionsFor("bgkMap", {folder / "a.rawlog"}, folder / (std::to_string(threads) + ".lamap.gz"));
    options.threads = threads;
    (void)buildMap(options);
    EXPECT_EQ(fileContent(options.outPath), fileContent(folder / "1.lamap.gz"));
  }
}

TEST(Build, AnInputNamedTwiceIsInsertedTwice)
{
  const TemporaryFolder folder;
  writeLog(folder / "a.rawlog", {laser(at(0))});
  (void)buildMap(optionsFor("bgkMap", {folder / "a.rawlog"}, folder / "once.lamap.gz"));
  const auto report =
      buildMap(optionsFor("bgkMap", {folder / "a.rawlog", folder / "a.rawlog"}, folder / "twice.lamap.gz"));
  EXPECT_EQ(report.scans.usedCount(), 2U);
  const auto once = std::dynamic_pointer_cast<lamap::CBGKMap>(lamap::loadMapFile(folder / "once.lamap.gz"));
  const auto twice = std::dynamic_pointer_cast<lamap::CBGKMap>(lamap::loadMapFile(folder / "twice.lamap.gz"));
  constexpr double kPrior = 0.003;
  size_t cells = 0;
  once->visitCells(
      [&](const lamap::CellIndex& cell, const lamap::CellEstimate& estimate)
      {
        const auto other = twice->estimateCell(cell);
        ASSERT_TRUE(other.has_value());
        for (size_t i = 0; i < 2; ++i)
          EXPECT_NEAR(other->evidence[i] - kPrior, 2 * (estimate.evidence[i] - kPrior), 1e-9);
        ++cells;
      });
  EXPECT_GT(cells, 9U);
}

TEST(Onto, AConflictingSettingIsRefusedWithBothValuesAndAnEqualOneAccepted)
{
  const TemporaryFolder folder;
  writeLog(folder / "a.rawlog", logFrom(0, 2));
  auto options = optionsFor("bgkMap", {folder / "a.rawlog"}, folder / "a.lamap.gz");
  options.map.settings = {"insertOpts.maxRange=7.5"};
  (void)buildMap(options);
  const std::string before = fileContent(options.outPath);

  options.ontoPath = options.outPath;
  options.map.settings = {"insertOpts.maxRange=8"};
  const std::string text = complaint<UsageError>(options);
  for (const std::string word : {"insertOpts.maxRange=8", "insertOpts.maxRange=7.5", "a.lamap.gz"})
    EXPECT_NE(text.find(word), std::string::npos) << text;
  options.map.settings = {"insertOpts.maxRagne=8"};
  EXPECT_NE(complaint<std::invalid_argument>(options).find("maxRange"), std::string::npos);
  options.map.settings = {"creationOpts.resolution=0.2"};
  EXPECT_NE(complaint<UsageError>(options).find("resolution"), std::string::npos);
  options.map = {"octoMap", "", {}};
  EXPECT_NE(complaint<UsageError>(options).find("octoMap"), std::string::npos);
  options.map = {
      "", folder.write("c.ini", "[map]\nbgkMap_count=1\n[map_bgkMap_00_insertOpts]\nmaxRange=9\n"), {}};
  EXPECT_NE(complaint<std::runtime_error>(options).find("maxRange=9"), std::string::npos);
  EXPECT_EQ(fileContent(options.outPath), before);

  options.map = {"",
                 folder.write("c.ini", "[map]\nbgkMap_count=1\n[map_bgkMap_00_insertOpts]\nmaxRange=7.50\n"),
                 {"insertOpts.maxRange=7.5"}};
  EXPECT_EQ(complaint<std::exception>(options), "");
  EXPECT_NE(fileContent(options.outPath), before);
}

TEST(Onto, OnlyMapsOfThisLibraryCanGoOn)
{
  const TemporaryFolder folder;
  writeLog(folder / "a.rawlog", logFrom(0, 2));
  auto options = optionsFor("octoMap", {folder / "a.rawlog"}, folder / "a.lamap.gz");
  (void)buildMap(options);
  options.ontoPath = options.outPath;
  EXPECT_NE(complaint<std::runtime_error>(options).find("COctoMap"), std::string::npos);
  options.ontoPath = folder / "none.lamap.gz";
  EXPECT_NE(complaint<std::exception>(options).find("none.lamap.gz"), std::string::npos);
}

std::string pcdOf(const std::vector<octomap::point3d>& points, const std::string& viewpoint)
{
  std::ostringstream text;
  text << "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH " << points.size()
       << "\nHEIGHT 1\nVIEWPOINT " << viewpoint << "\nPOINTS " << points.size() << "\nDATA ascii\n";
  for (const auto& point : points) text << point.x() << " " << point.y() << " " << point.z() << "\n";
  return text.str();
}

// Against OctoMap itself: the same cells with the same log-odds, in floats, from the same rays.
TEST(Build, OctoMapFromPcdIsWhatOctoMapMakesOfTheRays)
{
  const TemporaryFolder folder;
  const std::vector<octomap::point3d> points{
      {3.05F, 2.05F, 1.05F}, {2.05F, -1.95F, 0.05F}, {-0.95F, 2.55F, 3.05F}};
  const octomap::point3d origin(1.05F, 0.55F, 0.75F);
  const std::string path = folder.write("a.pcd", pcdOf(points, "1.05 0.55 0.75 0.6 0 0 0.8"));
  (void)buildMap(optionsFor("octoMap", {path, path, path}, folder / "a.ot"));

  octomap::OcTree expected(0.1);
  octomap::Pointcloud cloud;
  for (const auto& point : points) cloud.push_back(point);
  for (int i = 0; i < 3; ++i) expected.insertPointCloud(cloud, origin);
  expected.expand();
  const std::unique_ptr<octomap::AbstractOcTree> read(octomap::AbstractOcTree::read(folder / "a.ot"));
  auto* tree = dynamic_cast<octomap::OcTree*>(read.get());
  ASSERT_NE(tree, nullptr);
  tree->expand();
  EXPECT_EQ(tree->getNumLeafNodes(), expected.getNumLeafNodes());
  size_t partly = 0;
  for (auto leaf = expected.begin_leafs(); leaf != expected.end_leafs(); ++leaf)
  {
    const auto* node = tree->search(leaf.getKey());
    ASSERT_NE(node, nullptr);
    EXPECT_NEAR(node->getLogOdds(), leaf->getLogOdds(), 1e-5);
    if (leaf->getLogOdds() > -1.9F && leaf->getLogOdds() < 3.4F) ++partly;
  }
  EXPECT_GT(partly, 10U) << "log-odds between the clamping limits, which MRPT's own file would lose";
}

// The bugs of MRPT 2.5: its point maps ignore the robot's pose of a point cloud, its octrees the sensor's.
TEST(Build, MrptsOwnMapsGetPointCloudsWithAllPosesApplied)
{
  const TemporaryFolder folder;
  auto points = mrpt::maps::CSimplePointsMap::Create();
  points->insertPoint(1, 0, 0);
  auto cloud = mrpt::obs::CObservationPointCloud::Create();
  cloud->timestamp = at(0);
  cloud->pointcloud = points;
  cloud->sensorPose = mrpt::poses::CPose3D(0, 0, 2, 0, 0, 0);
  // Robot at (10, 5) turned left by 90 degrees: the point is at (10, 6, 2).
  writeLog(folder / "a.rawlog", {odometry(at(0), 10, 5, 1.57079632679489662), cloud});
  (void)buildMap(optionsFor("pointsMap", {folder / "a.rawlog"}, folder / "p.lamap.gz"));
  const auto read =
      std::dynamic_pointer_cast<mrpt::maps::CSimplePointsMap>(lamap::loadMapFile(folder / "p.lamap.gz"));
  ASSERT_EQ(read->size(), 1U);
  float x = 0;
  float y = 0;
  float z = 0;
  read->getPoint(0, x, y, z);
  EXPECT_NEAR(x, 10, 1e-5);
  EXPECT_NEAR(y, 6, 1e-5);
  EXPECT_NEAR(z, 2, 1e-5);

  (void)buildMap(optionsFor("octoMap", {folder / "a.rawlog"}, folder / "o.ot"));
  const auto cells = openCellMap(folder / "o.ot");
  const auto end = cells->estimateAt({10.01, 6.0, 2.01});
  ASSERT_TRUE(end.has_value());
  EXPECT_GT(end->prob, 0.5);
  const auto between = cells->estimateAt({10.01, 5.55, 2.01});
  ASSERT_TRUE(between.has_value());
  EXPECT_LT(between->prob, 0.5);
}

TEST(Build, CountsWhatItLeavesOutAndWhy)
{
  const TemporaryFolder folder;
  auto nothing = laser(at(0.5));
  for (size_t i = 0; i < nothing->getScanSize(); ++i) nothing->setScanRangeValidity(i, false);
  auto comment = mrpt::obs::CObservationComment::Create();
  comment->timestamp = at(0.5);
  writeLog(folder / "a.rawlog", {odometry(at(0), 0, 0, 0), laser(at(0)), comment, nothing, laser(at(7)),
                                 odometry(at(1), 0, 0, 0)});
  const auto report = buildMap(optionsFor("bgkMap", {folder / "a.rawlog"}, folder / "a.lamap.gz"));
  EXPECT_EQ(report.scans.usedCount(), 1U);
  EXPECT_EQ(report.scans.leftOut.size(), 3U);
  std::ostringstream text;
  printReport(report, text);
  for (const std::string word :
       {"1 CObservationComment: the map takes no observation of this class",
        "1 CObservation2DRangeScan: it holds no ray that can be used",
        "1 CObservation2DRangeScan: it lies before the first or after the last pose"})
    EXPECT_NE(text.str().find(word), std::string::npos) << text.str();
  const auto json = reportJson(report);
  EXPECT_EQ(json["left_out"].size(), 3U);
  EXPECT_EQ(json["scans"], 1);
  for (const auto& left : json["left_out"])
  {
    EXPECT_EQ(left["first"]["input"], folder / "a.rawlog");
    const bool isLast = left["reason"] == "it lies before the first or after the last pose";
    EXPECT_EQ(left["first"]["number"], isLast ? 4 : left["kind"] == "CObservationComment" ? 2 : 3) << left;
    EXPECT_NEAR(left["first"]["time"].get<double>(), mrpt::Clock::toDouble(at(isLast ? 7 : 0.5)), 1e-3);
  }
  EXPECT_NE(text.str().find("last pose (number 4 of " + (folder / "a.rawlog") + ", at "), std::string::npos)
      << text.str();
}

/// Four scans, those of the numbers in the list (from 0) from a pose that is not finite.
void writeMapWithBadPoses(const std::string& path, const std::set<int>& bad, double value)
{
  mrpt::maps::CSimpleMap map;
  for (int i = 0; i < 4; ++i)
  {
    auto frame = mrpt::obs::CSensoryFrame::Create();
    frame->insert(laser(at(i)));
    const double x = bad.count(i) > 0 ? value : 0.1 * i;
    map.insert(mrpt::poses::CPose3DPDFGaussian::Create(mrpt::poses::CPose3D(x, 0, 0, 0, 0, 0)), frame);
  }
  ASSERT_TRUE(map.saveToFile(path));
}

TEST(Build, APoseThatIsNotFiniteIsNamedAndStrictlyAnError)
{
  for (const double value :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    for (const std::string kind : {"bgkMap", "gpMap", "hilbertMap", "overlappingHilbertMap", "octoMap"})
    {
      SCOPED_TRACE(kind);
      const TemporaryFolder folder;
      writeMapWithBadPoses(folder / "a.simplemap", {1, 3}, value);
      BuildOptions options =
          optionsFor(kind, {folder / "a.simplemap"}, folder / (kind == "octoMap" ? "a.ot" : "a.lamap.gz"));
      const auto report = buildMap(options);
      EXPECT_EQ(report.scans.usedCount(), 2U);
      EXPECT_EQ(report.scans.failed, 2U);
      std::ostringstream text;
      printReport(report, text);
      const std::string place = "number 2 of " + (folder / "a.simplemap") + ", at ";
      EXPECT_NE(text.str().find(
                    "left out: 2 CObservation2DRangeScan: its pose is NaN or infinite (the first: " + place),
                std::string::npos)
          << text.str();
      options.strict = true;
      try
      {
        (void)buildMap(options);
        FAIL() << "a scan without a place is used";
      }
      catch (const std::runtime_error& error)
      {
        EXPECT_NE(std::string(error.what()).find(place), std::string::npos) << error.what();
      }
    }
}

TEST(Info, APoseThatIsNotFiniteIsToldAndNotOnTheWay)
{
  const TemporaryFolder folder;
  writeMapWithBadPoses(folder / "a.simplemap", {0, 2}, std::numeric_limits<double>::quiet_NaN());
  InputOptions inputs;
  inputs.paths = {folder / "a.simplemap"};
  const Json json = logInfoJson(readLogInfo(inputs));
  ASSERT_EQ(json["build"]["left_out"].size(), 1U) << json;
  EXPECT_EQ(json["build"]["left_out"][0]["reason"], "its pose is NaN or infinite");
  EXPECT_EQ(json["build"]["left_out"][0]["count"], 2);
  EXPECT_EQ(json["build"]["left_out"][0]["first"]["number"], 1);
  EXPECT_EQ(json["build"]["scans"], 2);
  EXPECT_NEAR(json["poses"]["path"]["length"].get<double>(), 0.2, 1e-6) << json["poses"];
}

TEST(Build, WithoutAUsableScanNothingIsWritten)
{
  const TemporaryFolder folder;
  folder.write("empty.rawlog", "");
  folder.write("a.lamap.gz", "stays");
  auto options = optionsFor("bgkMap", {folder / "empty.rawlog"}, folder / "a.lamap.gz");
  EXPECT_NE(complaint<std::runtime_error>(options).find("not one usable scan"), std::string::npos);
  writeLog(folder / "full.rawlog", logFrom(0, 3));
  options.inputs.paths = {folder / "full.rawlog"};
  options.map.settings = {"creationOpts.enableObservationInsertion=false"};
  EXPECT_NE(complaint<std::runtime_error>(options).find("enableObservationInsertion"), std::string::npos);
  EXPECT_EQ(fileContent(options.outPath), "stays");
  EXPECT_EQ(folder.size(), 3U) << "no temporary file is left";
}

// A log cut at every eighth gives, byte by byte, the map of the scans before the cut.
TEST(Build, SavesWhatStandsBeforeACut)
{
  const TemporaryFolder folder;
  writeLog(folder / "a.rawlog", logFrom(0, 16), false);
  const std::string whole = fileContent(folder / "a.rawlog");
  for (size_t eighth = 1; eighth < 8; ++eighth)
  {
    SCOPED_TRACE(eighth);
    // Not between two objects, where a plain log's end cannot be told from a cut.
    folder.write("cut.rawlog", whole.substr(0, whole.size() * eighth / 8 + 3));
    const auto report = buildMap(optionsFor("bgkMap", {folder / "cut.rawlog"}, folder / "cut.lamap.gz"));
    EXPECT_TRUE(lamap::tools::damaged(report.inputs));
    EXPECT_TRUE(report.saved);
    const auto used = static_cast<int>(report.scans.usedCount());
    writeLog(folder / "short.rawlog", logFrom(0, used));
    (void)buildMap(optionsFor("bgkMap", {folder / "short.rawlog"}, folder / "short.lamap.gz"));
    EXPECT_EQ(fileContent(folder / "cut.lamap.gz"), fileContent(folder / "short.lamap.gz"));
  }
}

TEST(Build, AskedToStopItFinishesTheScanAndSaves)
{
  const TemporaryFolder folder;
  writeLog(folder / "a.rawlog", logFrom(0, 12));
  auto options = optionsFor("bgkMap", {folder / "a.rawlog"}, folder / "stopped.lamap.gz");
  bool stop = false;
  options.inputs.shouldStop = [&] { return stop; };
  const auto report = buildMap(options, [&](const Progress& progress) { stop = progress.done == 5; });
  EXPECT_TRUE(report.stopped);
  EXPECT_TRUE(report.saved);
  EXPECT_EQ(report.scans.usedCount(), 5U);
  writeLog(folder / "b.rawlog", logFrom(0, 5));
  (void)buildMap(optionsFor("bgkMap", {folder / "b.rawlog"}, folder / "b.lamap.gz"));
  EXPECT_EQ(fileContent(folder / "stopped.lamap.gz"), fileContent(folder / "b.lamap.gz"));

  stop = true;
  options.outPath = folder / "never.lamap.gz";
  const auto atOnce = buildMap(options);
  EXPECT_TRUE(atOnce.stopped);
  EXPECT_FALSE(atOnce.saved);
  EXPECT_FALSE(std::filesystem::exists(options.outPath));
}

TEST(Build, TheOutputIsCheckedFirst)
{
  const TemporaryFolder folder;
  auto options = optionsFor("bgkMap", {folder / "not-there.rawlog"}, folder / "none/a.lamap.gz");
  EXPECT_NE(complaint<std::runtime_error>(options).find("none"), std::string::npos);
  options.outPath = folder / "a.ply";
  EXPECT_NE(complaint<UsageError>(options).find(".lamap.gz"), std::string::npos);
  options.outPath = folder / "a.ot";
  EXPECT_NE(complaint<UsageError>(options).find("octoMap"), std::string::npos);
  EXPECT_EQ(folder.size(), 0U);
}

TEST(Counted, AgreesInNumber)
{
  EXPECT_EQ(counted(0, "scan"), "0 scans");
  EXPECT_EQ(counted(1, "occupied cell"), "1 occupied cell");
  EXPECT_EQ(counted(2, "ray"), "2 rays");
  EXPECT_EQ(counted(1, "entry"), "1 entry");
  EXPECT_EQ(counted(12, "entry"), "12 entries");
}

TEST(ProgressBar, DoesNotPromiseAnEndThatIsNotKnown)
{
  std::ostringstream out;
  {
    ProgressBar bar(out, true, "entry");
    bar.show({3, 0, "a.rawlog"}, ProgressBar::Clock::time_point{});
  }
  EXPECT_NE(out.str().find("3 entries"), std::string::npos) << out.str();
  EXPECT_EQ(out.str().find(" of "), std::string::npos) << out.str();
  EXPECT_EQ(out.str().find("["), out.str().find("[K")) << "a bar: " << out.str();
}

TEST(ProgressBar, IsRedrawnOnATerminalAndGivesFewLinesElsewhere)
{
  const ProgressBar::Clock::time_point begin{};
  const auto draw = [&](bool isTerminal)
  {
    std::ostringstream out;
    {
      ProgressBar bar(out, isTerminal);
      for (size_t i = 0; i <= 400; ++i) bar.show({i, 400, "a"}, begin + std::chrono::milliseconds(100 * i));
    }
    return out.str();
  };
  const std::string terminal = draw(true);
  EXPECT_EQ(std::count(terminal.begin(), terminal.end(), '\r'), 401);
  EXPECT_EQ(std::count(terminal.begin(), terminal.end(), '\n'), 1);
  EXPECT_NE(terminal.find("[######..................] 100 of 400 scans, 10.0 per second, 0:30 left"),
            std::string::npos);
  const std::string plain = draw(false);
  EXPECT_EQ(plain,
            "100 of 400 scans, 10.0 per second, 0:30 left\n200 of 400 scans, 10.0 per second, 0:20 left\n"
            "300 of 400 scans, 10.0 per second, 0:10 left\n400 of 400 scans, 10.0 per second, 0:00 left\n");
  EXPECT_EQ(durationText(3723.4), "1:02:03");
}
}  // namespace
