#include <gtest/gtest.h>
#include <lamap_tools/commands/log_info.h>
#include <lamap_tools/commands/map_build.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>

#include <filesystem>
#include <limits>
#include <sstream>
#include <stdexcept>

#include "support/small_logs.h"
#include "support/temporary_folder.h"

namespace
{
using namespace lamap::tools;
using namespace lamap::test;
using lamap::RayEnd;

LogInfo infoOf(const std::string& path)
{
  InputOptions options;
  options.paths = {path};
  return readLogInfo(options);
}

std::string textOf(const LogInfo& info)
{
  std::ostringstream out;
  printLogInfo(info, out);
  return out.str();
}

/// One ray each at NaN, 0, beyond the maximum range and nearer than can be measured; five return, from 2.4 m
/// to 2.8 m.
mrpt::obs::CObservation2DRangeScan::Ptr oneOfEachReading(mrpt::Clock::time_point time)
{
  auto scan = laser(time);
  scan->sensorLabel = "FRONT";
  scan->setScanRange(0, std::numeric_limits<float>::quiet_NaN());
  scan->setScanRange(1, 0);
  scan->setScanRange(2, 25);
  scan->setScanRange(3, -std::numeric_limits<float>::infinity());
  return scan;
}

TEST(LogInfo, CountsWhatTheReadingsOfEachSensorMean)
{
  const TemporaryFolder folder;
  writeLog(folder / "a.rawlog", {odometry(at(0), 0, 0, 0), oneOfEachReading(at(0)), laser(at(1), 5),
                                 oneOfEachReading(at(2)), odometry(at(4), 4, 0, 0)});
  const LogInfo info = infoOf(folder / "a.rawlog");
  ASSERT_EQ(info.sensors.size(), 2U);
  const SensorInfo& unlabelled = info.sensors[0];
  EXPECT_EQ(unlabelled.name, "CObservation2DRangeScan");
  EXPECT_EQ(unlabelled.scans, 1U);
  EXPECT_EQ(unlabelled.look.count(RayEnd::Return), 9U);

  const SensorInfo& front = info.sensors[1];
  EXPECT_EQ(front.name, "FRONT");
  EXPECT_EQ(front.className, "CObservation2DRangeScan");
  EXPECT_EQ(front.scans, 2U);
  EXPECT_EQ(front.look.rayCount(), 18U);
  EXPECT_EQ(front.look.count(RayEnd::Return), 10U);
  EXPECT_EQ(front.look.count(RayEnd::NoReturn), 2U);
  EXPECT_EQ(front.look.count(RayEnd::Dropped), 4U);
  EXPECT_EQ(front.look.count(RayEnd::TooNear), 2U);
  ASSERT_TRUE(front.look.ranges && front.look.statedRanges && front.time && info.firstTime);
  EXPECT_NEAR(front.look.ranges->shortest_m, 2.4, 1e-6);
  EXPECT_NEAR(front.look.ranges->longest_m, 2.8, 1e-6);
  EXPECT_EQ(front.look.statedRanges->longest_m, 20);
  EXPECT_EQ(*info.firstTime, at(0));
  EXPECT_EQ(front.time->last, at(2));

  EXPECT_NE(textOf(info).find("returns                        10 (55.6 %)"), std::string::npos)
      << textOf(info);
  const Json json = logInfoJson(info);
  EXPECT_EQ(json["sensors"][1]["rays"]["dropped"], 4);
  EXPECT_EQ(json["sensors"][1]["rays"]["tooNear"], 2);
  EXPECT_EQ(json["sensors"][1]["last"], 2.0);
  EXPECT_EQ(json["sensors"][1]["perSecond"], 0.5);
}

// Odometry from x = 0 to 4 m within 4 s, and scans at 0, 2 and 3 s, in another order, and one after the end.
TEST(LogInfo, TellsHowFarThePosesLeadAndWhatABuildWouldLeaveOut)
{
  const TemporaryFolder folder;
  auto imu = mrpt::obs::CObservationIMU::Create();
  imu->timestamp = at(1);
  writeLog(folder / "a.rawlog", {odometry(at(0), 0, 0, 0), laser(at(3)), laser(at(0)), laser(at(2)), imu,
                                 laser(at(9)), odometry(at(4), 4, 0, 0)});
  const LogInfo info = infoOf(folder / "a.rawlog");
  EXPECT_TRUE(info.posesAreOdometry);
  ASSERT_EQ(info.poses.size(), 1U);
  EXPECT_EQ(info.poses[0], "2 poses from odometry");
  ASSERT_TRUE(info.robotPath);
  EXPECT_NEAR(info.robotPath->length_m, 3, 1e-6);
  EXPECT_NEAR(info.robotPath->farthestFromStart_m, 3, 1e-6);
  EXPECT_EQ(info.build.usedCount(), 3U);
  ASSERT_EQ(info.build.leftOut.size(), 2U);
  EXPECT_EQ(info.build.leftOut.begin()->first.second, "it lies before the first or after the last pose");
  EXPECT_EQ(info.build.leftOut.rbegin()->first.first, "CObservationIMU");
  EXPECT_NE(textOf(info).find("3 of 5 observations"), std::string::npos) << textOf(info);
}

TEST(LogInfo, DescribesALogWithoutPoses)
{
  const TemporaryFolder folder;
  writeLog(folder / "a.rawlog", {laser(at(0)), laser(at(1))});
  const LogInfo info = infoOf(folder / "a.rawlog");
  ASSERT_EQ(info.sensors.size(), 1U);
  EXPECT_EQ(info.sensors[0].look.count(RayEnd::Return), 18U);
  EXPECT_FALSE(info.robotPath);
  EXPECT_EQ(info.build.usedCount(), 0U);
  EXPECT_NE(textOf(info).find("give --poses FILE"), std::string::npos) << textOf(info);
}

TEST(LogInfo, DescribesSimpleMapsAndFoldersOfClouds)
{
  const TemporaryFolder folder;
  mrpt::maps::CSimpleMap map;
  for (const double x : {0.0, 3.0})
    map.insert(
        std::make_shared<mrpt::poses::CPose3DPDFGaussian>(mrpt::poses::CPose3D(x, 4 * x / 3, 0, 0, 0, 0)),
        frame({laser(at(x))}));
  ASSERT_TRUE(map.saveToFile(folder / "a.simplemap"));
  const LogInfo simple = infoOf(folder / "a.simplemap");
  ASSERT_EQ(simple.sensors.size(), 1U);
  EXPECT_EQ(simple.sensors[0].scans, 2U);
  EXPECT_FALSE(simple.posesAreOdometry);
  ASSERT_TRUE(simple.robotPath);
  EXPECT_NEAR(simple.robotPath->length_m, 5, 1e-6);

  std::filesystem::create_directory(folder / "clouds");
  folder.write(
      "clouds/1.pcd",
      "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 3\nHEIGHT 1\nVIEWPOINT 1 0 0 1 0 0 0\n"
      "POINTS 3\nDATA ascii\n4 0 0\n1 5 0\nnan 0 0\n");
  const LogInfo clouds = infoOf(folder / "clouds");
  ASSERT_EQ(clouds.sensors.size(), 1U);
  EXPECT_EQ(clouds.sensors[0].look.count(RayEnd::Return), 2U);
  EXPECT_EQ(clouds.sensors[0].look.notFinite, 1U);
  ASSERT_TRUE(clouds.sensors[0].look.ranges);
  EXPECT_NEAR(clouds.sensors[0].look.ranges->shortest_m, 3, 1e-6);
  EXPECT_NEAR(clouds.sensors[0].look.ranges->longest_m, 5, 1e-6);
  EXPECT_FALSE(clouds.time);
  EXPECT_EQ(logInfoJson(clouds)["firstTime"], nullptr);
}

// Points at the sensor are how drivers of 3D lidars write missing returns.
TEST(LogInfo, CountsPointsOnTheSensorAsABuildDoes)
{
  const TemporaryFolder folder;
  folder.write(
      "1.pcd",
      "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 4\nHEIGHT 1\nVIEWPOINT 1 0 0 1 0 0 0\n"
      "POINTS 4\nDATA ascii\n4 0 0\n1 0 0\n1 0 0\n1 5 0\n");
  const LogInfo info = infoOf(folder / "1.pcd");
  ASSERT_EQ(info.sensors.size(), 1U);
  EXPECT_EQ(info.sensors[0].look.count(RayEnd::Return), 2U);
  EXPECT_EQ(info.sensors[0].look.count(RayEnd::TooNear), 2U);
  EXPECT_NEAR(info.sensors[0].look.ranges->shortest_m, 3, 1e-6);

  BuildOptions build;
  build.inputs.paths = {folder / "1.pcd"};
  build.map.mapName = "bgkMap";
  build.outPath = folder / "a.lamap.gz";
  const BuildReport report = buildMap(build);
  EXPECT_EQ(report.rays.hits, 2U);
  EXPECT_EQ(report.rays.tooNear, 2U);

  folder.write(
      "2.pcd",
      "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 1\nHEIGHT 1\nVIEWPOINT 1 0 0 1 0 0 0\n"
      "POINTS 1\nDATA ascii\n1 0 0\n");
  EXPECT_EQ(infoOf(folder / "2.pcd").build.usedCount(), 0U) << "a build refuses it, too";
}

TEST(LogInfo, RefusesPosesOfAnotherTime)
{
  const TemporaryFolder folder;
  const TemporaryFolder poses;
  writeLog(folder / "a.rawlog", {laser(at(0)), laser(at(1))});
  InputOptions options;
  options.paths = {folder / "a.rawlog"};
  options.posesPath = poses.write("p.tum", "5 0 0 0 0 0 0 1\n6 1 0 0 0 0 0 1\n");
  try
  {
    (void)readLogInfo(options);
    FAIL() << "accepted";
  }
  catch (const std::runtime_error& error)
  {
    const std::string text = error.what();
    EXPECT_NE(text.find("of its 2 observations, at 1000000000.000 to 1000000001.000 s since 1970, none lies "
                        "within the time of the poses, 5.000 to 6.000 s"),
              std::string::npos)
        << text;
  }
  // The log's own poses are as they are: what is there is described.
  writeLog(folder / "a.rawlog",
           {odometry(at(5), 0, 0, 0), laser(at(0)), laser(at(1)), odometry(at(6), 0, 0, 0)});
  options.posesPath.clear();
  const LogInfo info = readLogInfo(options);
  EXPECT_EQ(info.sensors.at(0).scans, 2U);
  EXPECT_NE(textOf(info).find("of its 2 observations"), std::string::npos) << textOf(info);
}

// 225 scans of 361 rays, on a path of 76 m.
TEST(LogInfo, DescribesALogOfMrpt)
{
  const std::string path = "/usr/share/mrpt/datasets/2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not installed";
  const LogInfo info = infoOf(path);
  ASSERT_EQ(info.sensors.size(), 1U);
  EXPECT_EQ(info.sensors[0].scans, 225U);
  EXPECT_EQ(info.sensors[0].look.rayCount(), 225U * 361U);
  EXPECT_EQ(info.sensors[0].look.count(RayEnd::Return) + info.sensors[0].look.count(RayEnd::NoReturn),
            225U * 361U);
  EXPECT_EQ(info.build.usedCount(), 225U);
  ASSERT_TRUE(info.robotPath);
  EXPECT_NEAR(info.robotPath->length_m, 76.4, 0.2);
  EXPECT_TRUE(info.input.damages.empty());
}
}  // namespace
