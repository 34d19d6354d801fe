#include <gtest/gtest.h>
#include <lamap_tools/commands/log_info.h>
#include <lamap_tools/commands/map_build.h>
#include <lamap_tools/files/usage_error.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRange.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <sstream>

#include "support/small_logs.h"
#include "support/temporary_folder.h"

namespace
{
using namespace lamap::tools;
using namespace lamap::test;

/// 400 points around the sensor, in 20 layers. @param range_m  of a point by its number
mrpt::obs::CObservationPointCloud::Ptr cloud(mrpt::Clock::time_point time, double height_m,
                                             const std::function<double(int)>& range_m)
{
  auto points = mrpt::maps::CSimplePointsMap::Create();
  for (int i = 0; i < 400; ++i)
  {
    const double azimuth = 0.1 * i;
    const double z = height_m * (i % 20) / 19.0;
    const double range = range_m(i);
    const double across = std::sqrt(range * range - z * z);
    points->insertPoint({across * std::cos(azimuth), across * std::sin(azimuth), z});
  }
  auto observation = mrpt::obs::CObservationPointCloud::Create();
  observation->timestamp = time;
  observation->sensorLabel = "LIDAR";
  observation->pointcloud = points;
  return observation;
}

/// Ranges that differ, from 5 to 9 m.
double varied(int i)
{
  return 5 + 0.01 * i;
}

/// A quarter of the points at 9.5 m, as of a sensor that sees nothing there.
double withShell(int i)
{
  return i % 4 == 0 ? 9.5 : varied(i);
}

class Notes : public testing::Test
{
 protected:
  /// A simple map with one observation, whose pose does not drift.
  std::string simpleMapOf(const mrpt::obs::CObservation::Ptr& observation) const
  {
    mrpt::maps::CSimpleMap map;
    map.insert(std::make_shared<mrpt::poses::CPose3DPDFGaussian>(), frame({observation}));
    EXPECT_TRUE(map.saveToFile(folder_ / "a.simplemap"));
    return folder_ / "a.simplemap";
  }

  std::vector<std::string> notesOf(const std::vector<std::string>& inputs,
                                   const std::vector<std::string>& settings = {},
                                   const std::string& map = "bgkMap") const
  {
    BuildOptions options;
    options.inputs.paths = inputs;
    options.map.mapName = map;
    options.map.settings = settings;
    options.outPath = folder_ / "a.lamap.gz";
    const BuildReport report = buildMap(options);
    EXPECT_EQ(reportJson(report)["notes"], Json(report.notes));
    std::ostringstream text;
    printReport(report, text);
    for (const std::string& note : report.notes) EXPECT_NE(text.str().find(note), std::string::npos);
    return report.notes;
  }

  static std::vector<std::string> infoNotesOf(const std::string& path)
  {
    InputOptions options;
    options.paths = {path};
    return readLogInfo(options).notes;
  }

  TemporaryFolder folder_;
};

bool contains(const std::string& text, const std::string& part)
{
  return text.find(part) != std::string::npos;
}

TEST_F(Notes, OdometryDriftsIsSaidOnceForABuild)
{
  const Objects driven{odometry(at(0), 0, 0, 0), laser(at(0)), laser(at(2)), odometry(at(2), 3, 0, 0)};
  writeLog(folder_ / "a.rawlog", driven);
  writeLog(folder_ / "b.rawlog", driven);
  const auto notes = notesOf({folder_ / "a.rawlog", folder_ / "b.rawlog"});
  ASSERT_EQ(notes.size(), 1U);
  for (const std::string part : {"a.rawlog", "drifts", "icp-slam", "rbpf-slam", ".simplemap", "MOLA",
                                 "log_estimated_path.txt", "--poses"})
    EXPECT_TRUE(contains(notes[0], part)) << part << " in: " << notes[0];
  EXPECT_TRUE(contains(notes[0], "The same holds for " + folder_ / "b.rawlog")) << notes[0];
  EXPECT_EQ(infoNotesOf(folder_ / "a.rawlog"), notesOf({folder_ / "a.rawlog"}));
}

// The first log has nothing to tell: neither its poses drift nor has its scan a shell.
TEST_F(Notes, NameTheLogThatTheyAreAbout)
{
  writeLog(folder_ / "still.rawlog",
           {odometry(at(0), 0, 0, 0), cloud(at(0), 3, varied), odometry(at(2), 0, 0, 0)});
  for (const std::string name : {"moved.rawlog", "again.rawlog"})
    writeLog(folder_ / name, {odometry(at(0), 0, 0, 0), cloud(at(0), 3, withShell),
                              cloud(at(2), 3, withShell), odometry(at(2), 3, 0, 0)});
  const auto notes = notesOf({folder_ / "still.rawlog", folder_ / "moved.rawlog", folder_ / "again.rawlog"},
                             {"creationOpts.planar=true"});
  ASSERT_EQ(notes.size(), 3U);
  EXPECT_EQ(notes[0].find(folder_ / "moved.rawlog" + ": its poses"), 0U) << notes[0];
  EXPECT_EQ(notes[1].find(folder_ / "still.rawlog" + ": LIDAR: its scans are 2.7 m high"), 0U) << notes[1];
  EXPECT_TRUE(contains(notes[1], "The same holds for LIDAR in " + folder_ / "moved.rawlog" + ", LIDAR in " +
                                     folder_ / "again.rawlog"))
      << notes[1];
  EXPECT_EQ(notes[2].find(folder_ / "moved.rawlog" + ": LIDAR: many returns"), 0U) << notes[2];
}

TEST_F(Notes, OnWhatWasChosenNameAllInputsThatItWasChosenFrom)
{
  std::vector<std::string> paths;
  for (const std::string name : {"a", "b", "c", "d"})
  {
    paths.push_back(folder_ / (name + ".rawlog"));
    writeLog(paths.back(), {laser(at(0))});
  }
  BuildOptions options;
  options.inputs.paths = paths;
  options.inputs.choice.every = 2;
  options.map.mapName = "bgkMap";
  options.outPath = folder_ / "a.lamap.gz";
  const BuildReport report = buildMap(options);
  EXPECT_EQ(report.notes, std::vector<std::string>{paths[0] + ", " + paths[1] + ", " + paths[2] +
                                                   " and 1 more: 2 of 4 observations chosen by --every 2"});
  for (const InputReport& input : report.inputs) EXPECT_EQ(input.notes.size(), 1U) << "on its poses";
}

/// A laser that sees nothing. @param returns  but in its first rays
mrpt::obs::CObservation2DRangeScan::Ptr blinded(double seconds, size_t returns = 0)
{
  auto scan = laser(at(seconds));
  scan->sensorLabel = "BLIND";
  scan->resizeScan(40);
  for (size_t i = 0; i < 40; ++i)
  {
    scan->setScanRange(i, i < returns ? 3 : 25);
    scan->setScanRangeValidity(i, i < returns);
  }
  return scan;
}

TEST_F(Notes, ScansWithoutAReturnThatMadeFreeSpaceAreCounted)
{
  const std::string log = folder_ / "a.rawlog";
  const auto write = [&](const Objects& scans)
  {
    Objects objects{odometry(at(0), 0, 0, 0)};
    objects.insert(objects.end(), scans.begin(), scans.end());
    objects.push_back(odometry(at(9), 0, 0, 0));
    writeLog(log, objects);
  };
  // Of 40 rays, 4 returns are a tenth, and 5 are more.
  write({blinded(0), laser(at(1)), blinded(2), blinded(3, 4), blinded(4, 5)});
  const auto notes = notesOf({log});
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_EQ(
      notes[0],
      log +
          ": BLIND: free space comes from 2 of 4 scans without a single return and 1 of 4 scans with "
          "hardly one (for at most every tenth ray). If the sensor was blinded or dead, leave them out: "
          "-s insertOpts.considerInvalidRangesAsFreeSpace=false, or --sensors without it");
  EXPECT_EQ(infoNotesOf(log), notes);
  EXPECT_TRUE(notesOf({log}, {"insertOpts.considerInvalidRangesAsFreeSpace=false"}).empty());
  write({blinded(0), blinded(1)});
  ASSERT_EQ(notesOf({log}).size(), 1U);
  EXPECT_FALSE(contains(notesOf({log})[0], "--sensors")) << "there is no other sensor";
  write({blinded(0, 5), laser(at(1))});
  EXPECT_TRUE(notesOf({log}).empty());
}

TEST_F(Notes, PingsWithoutAnEchoAreScansWithoutAReturn)
{
  Objects objects{odometry(at(0), 0, 0, 0)};
  for (const float range_m : {2.0F, 5.0F, 5.0F, 3.0F})
  {
    auto ping = mrpt::obs::CObservationRange::Create();
    ping->timestamp = at(static_cast<double>(objects.size()));
    ping->sensorLabel = "SONAR";
    ping->maxSensorDistance = 5;
    ping->sensedData.emplace_back();
    ping->sensedData[0].sensedDistance = range_m;
    objects.push_back(ping);
  }
  objects.push_back(odometry(at(9), 0, 0, 0));
  writeLog(folder_ / "a.rawlog", objects);
  const auto notes = notesOf({folder_ / "a.rawlog"});
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_TRUE(contains(notes[0], "SONAR: free space comes from 2 of 4 scans without a single return."))
      << notes[0];
}

TEST_F(Notes, AnOpeningAngleThatIsNoneIsNamed)
{
  const auto notesOn = [&](double aperture_deg)
  {
    auto scan = laser(at(0));
    scan->beamAperture = static_cast<float>(aperture_deg * M_PI / 180);
    return notesOf({simpleMapOf(scan)});
  };
  EXPECT_TRUE(notesOn(0).empty());
  EXPECT_TRUE(notesOn(15).empty());
  for (const double aperture_deg : {-5.0, 200.0, std::nan("")})
  {
    const auto notes = notesOn(aperture_deg);
    ASSERT_EQ(notes.size(), 1U) << aperture_deg;
    EXPECT_TRUE(contains(notes[0], "must be at least 0 and less than 180 degrees")) << notes[0];
    EXPECT_TRUE(contains(notes[0], "taken for lines")) << notes[0];
  }
}

TEST_F(Notes, NothingIsSaidOfPosesThatDoNotDrift)
{
  writeLog(folder_ / "still.rawlog", {odometry(at(0), 0, 0, 0), laser(at(0)), odometry(at(2), 0, 0, 0)});
  EXPECT_TRUE(notesOf({folder_ / "still.rawlog"}).empty()) << "a robot that stands still";
  EXPECT_TRUE(notesOf({simpleMapOf(laser(at(0)))}).empty());

  mrpt::obs::CActionRobotMovement2D matched;
  matched.computeFromOdometry(mrpt::poses::CPose2D(3, 0, 0), {});
  matched.estimationMethod = mrpt::obs::CActionRobotMovement2D::emScan2DMatching;
  auto actions = mrpt::obs::CActionCollection::Create();
  actions->insert(matched);
  writeLog(folder_ / "matched.rawlog", {frame({laser(at(0))}), actions, frame({laser(at(1))})});
  EXPECT_TRUE(notesOf({folder_ / "matched.rawlog"}).empty()) << "matched scans";
  writeLog(folder_ / "moved.rawlog",
           {frame({laser(at(0))}), move2D(at(0.5), 3, 0, 0), frame({laser(at(1))})});
  EXPECT_EQ(notesOf({folder_ / "moved.rawlog"}).size(), 1U) << "the same from odometry";
}

// Of 20 layers over 3 m, the outermost ones do not count: 17/19 of 3 m are left.
TEST_F(Notes, A3DCloudInAPlanarMapIsNamed)
{
  const std::vector<std::string> planar{"creationOpts.planar=true"};
  const auto notes = notesOf({simpleMapOf(cloud(at(0), 3, varied))}, planar);
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_TRUE(contains(notes[0], "LIDAR: its scans are 2.7 m high, but the map is planar")) << notes[0];
  EXPECT_TRUE(contains(notes[0], "creationOpts.planar=false")) << notes[0];
  EXPECT_TRUE(notesOf({simpleMapOf(cloud(at(0), 3, varied))}).empty()) << "a map in 3D";
  EXPECT_TRUE(notesOf({simpleMapOf(cloud(at(0), 0.1, varied))}, planar).empty()) << "a flat cloud";
}

TEST_F(Notes, CellsLargerThanWhatTheyHoldAreNamed)
{
  const auto tooLarge = notesOf({simpleMapOf(laser(at(0)))}, {"creationOpts.resolution=2"});
  ASSERT_EQ(tooLarge.size(), 1U);
  EXPECT_TRUE(contains(tooLarge[0], "cells of 2 m")) << tooLarge[0];
  EXPECT_TRUE(contains(tooLarge[0], "2.8 m away; try -s creationOpts.resolution=0.05")) << tooLarge[0];
  EXPECT_TRUE(notesOf({simpleMapOf(laser(at(0)))}, {"creationOpts.resolution=0.25"}).empty());

  // All but a few points within a metre, and one of them far away.
  const auto close = [](int i) { return i == 0 ? 80.0 : 1 + 0.001 * i; };
  const auto crowded = notesOf({simpleMapOf(cloud(at(0), 0.1, close))}, {"creationOpts.resolution=1"});
  ASSERT_EQ(crowded.size(), 1U);
  EXPECT_TRUE(contains(crowded[0], "fewer than ten cells")) << crowded[0];
  EXPECT_TRUE(notesOf({simpleMapOf(cloud(at(0), 0.1, close))}, {"creationOpts.resolution=0.1"}).empty());
}

TEST_F(Notes, PhantomShellsAreNamedUnlessSomethingLimitsTheRange)
{
  const std::string log = simpleMapOf(cloud(at(0), 3, withShell));
  for (const std::string map : {"bgkMap", "octoMap"})
  {
    const auto notes = notesOf({log}, {}, map);
    ASSERT_FALSE(notes.empty()) << map;
    EXPECT_TRUE(contains(notes[0], "9.50 m")) << notes[0];
    EXPECT_TRUE(contains(notes[0], "insertOpts.maxRange")) << notes[0];
  }
  EXPECT_TRUE(notesOf({log}, {"insertOpts.maxRange=9"}).empty());
  EXPECT_EQ(notesOf({log}, {"insertOpts.maxRange=20"}).size(), 1U) << "beyond the shell";
  EXPECT_EQ(notesOf({log}, {"insertOpts.maxRange=9.5"}).size(), 1U) << "rounded to either side of the range";
  EXPECT_TRUE(notesOf({simpleMapOf(cloud(at(0), 3, varied))}).empty());

  InputOptions info;
  info.paths = {simpleMapOf(cloud(at(0), 3, withShell))};
  EXPECT_EQ(readLogInfo(info).sensors.at(0).phantomShells, 1U);
  EXPECT_EQ(readLogInfo(info).notes, notesOf({log}));
}

// A driver that writes lost returns at a range that the user then sets as the limit, below other returns.
TEST_F(Notes, ManyReturnsAtTheLimitItselfAreNamed)
{
  const auto shellBelowOthers = [](int i) {
    return i % 10 == 0 ? 8.0 : i % 10 == 1 ? 9 + varied(i) : varied(i);
  };
  const std::string log = simpleMapOf(cloud(at(0), 0.1, shellBelowOthers));
  const auto notes = notesOf({log}, {"insertOpts.maxRange=8"});
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_TRUE(contains(notes[0], "insertOpts.maxRange=7.92")) << notes[0];
  EXPECT_TRUE(notesOf({log}, {"insertOpts.maxRange=7.92"}).empty());
  EXPECT_TRUE(notesOf({log}).empty());
}

// Two of four scans have a shell at 12 m, and one each at 9.5 and at 30 m.
TEST_F(Notes, OfSeveralPhantomShellsTheNearestThatIsNoChanceIsNamed)
{
  const auto shellAt = [](double range_m)
  { return [range_m](int i) { return i % 4 == 0 ? range_m : varied(i); }; };
  mrpt::maps::CSimpleMap map;
  const auto add = [&](double range_m)
  {
    map.insert(std::make_shared<mrpt::poses::CPose3DPDFGaussian>(),
               frame({cloud(at(static_cast<double>(map.size())), 3, shellAt(range_m))}));
    return folder_ / "a.simplemap";
  };
  for (const double range_m : {12.0, 30.0, 12.0, 9.5}) (void)add(range_m);
  ASSERT_TRUE(map.saveToFile(folder_ / "a.simplemap"));
  const auto notes = notesOf({folder_ / "a.simplemap"});
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_TRUE(contains(notes[0], "9.50 m")) << "in a quarter of the scans: " << notes[0];
  EXPECT_EQ(infoNotesOf(folder_ / "a.simplemap"), notes);
  (void)add(12);
  ASSERT_TRUE(map.saveToFile(folder_ / "a.simplemap"));
  EXPECT_TRUE(contains(notesOf({folder_ / "a.simplemap"})[0], "12.00 m")) << "in less than a quarter";
  EXPECT_EQ(infoNotesOf(folder_ / "a.simplemap"), notesOf({folder_ / "a.simplemap"}));
}

TEST_F(Notes, ABagFileIsRefusedWithTheToolThatConvertsIt)
{
  std::filesystem::create_directory(folder_ / "bag");
  folder_.write("bag/metadata.yaml", "rosbag2_bagfile_information:\n");
  for (const auto& [path, tool] : std::vector<std::pair<std::string, std::string>>{
           {folder_.write("a.bag", "#ROSBAG V2.0\n"), "rosbag2rawlog"},
           {folder_.write("a.db3", "SQLite format 3"), "mola-lidar-odometry-cli"},
           {folder_.write("a.mcap", ""), "mola-lidar-odometry-cli"},
           {folder_ / "bag", "mola-lidar-odometry-cli"}})
  {
    InputOptions options;
    options.paths = {path};
    EXPECT_TRUE(isNameOfLog(path));
    try
    {
      (void)openInputs(options);
      FAIL() << path;
    }
    catch (const UsageError& error)
    {
      EXPECT_TRUE(contains(error.what(), path)) << error.what();
      EXPECT_TRUE(contains(error.what(), tool)) << error.what();
    }
  }
}
}  // namespace
