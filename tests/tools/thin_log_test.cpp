#include <gtest/gtest.h>
#include <lamap_mrpt/observations/observation_rays.h>
#include <lamap_tools/commands/thin_log.h>
#include <lamap_tools/files/usage_error.h>
#include <lamap_tools/inputs/scan_source.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>

#include <algorithm>
#include <stdexcept>

#include "support/small_logs.h"
#include "support/temporary_folder.h"

namespace
{
using namespace lamap;
using namespace lamap::tools;
using namespace lamap::test;
using mrpt::obs::CObservation;
using mrpt::obs::CObservation2DRangeScan;

std::vector<Eigen::Vector3d> endsOf(const CObservation& observation)
{
  const auto scan = raysOf(observation, mrpt::poses::CPose3D(1, 2, 0.5, 0.3, 0.1, -0.2));
  std::vector<Eigen::Vector3d> ends;
  for (const Ray& ray : scan->fans.front().rays)
    if (ray.meaning == RayEnd::Return) ends.push_back(scan->inMap(ray.end));
  return ends;
}

// What is left are rays of the scan itself, so far apart as asked for, in the middle of the fan.
TEST(Thinned, KeepsRaysOfTheScanWhereTheyWere)
{
  for (const size_t count : {1, 2, 7, 10, 361})
    for (const size_t every : {1, 2, 3, 10, 400})
      for (const bool rightToLeft : {true, false})
      {
        SCOPED_TRACE(std::to_string(count) + " rays, every " + std::to_string(every));
        CObservation2DRangeScan scan;
        scan.aperture = 2.5F;
        scan.maxRange = 30;
        scan.rightToLeft = rightToLeft;
        scan.sensorPose = mrpt::poses::CPose3D(0.2, -0.1, 0.4, 0.7, 0.2, 0.1);
        scan.resizeScan(count);
        for (size_t i = 0; i < count; ++i)
        {
          scan.setScanRange(i, 2 + 0.01F * static_cast<float>(i));
          scan.setScanRangeValidity(i, true);
        }
        const auto all = endsOf(scan);
        const auto fewer = endsOf(**thinned(scan, every));
        ASSERT_EQ(fewer.size(), (count - 1) / every + 1);
        const size_t first = (count - 1 - (fewer.size() - 1) * every) / 2;
        for (size_t i = 0; i < fewer.size(); ++i)
          ASSERT_LT((fewer[i] - all[first + i * every]).norm(), 1e-5) << i;
      }
}

TEST(Thinned, KeepsValidityAndIntensity)
{
  auto scan = laser(at(0));
  scan->setScanHasIntensity(true);
  for (size_t i = 0; i < 9; ++i) scan->setScanIntensity(i, static_cast<int>(10 * i));
  scan->setScanRangeValidity(4, false);
  const auto fewer = std::dynamic_pointer_cast<CObservation2DRangeScan>(*thinned(*scan, 4));
  ASSERT_EQ(fewer->getScanSize(), 3U);
  EXPECT_EQ(fewer->getScanIntensity(1), 40);
  EXPECT_FALSE(fewer->getScanRangeValidity(1));
  EXPECT_TRUE(fewer->getScanRangeValidity(2));
  EXPECT_EQ(fewer->timestamp, scan->timestamp);
}

TEST(Thinned, KeepsPointsOfACloud)
{
  mrpt::obs::CObservationPointCloud cloud;
  auto points = mrpt::maps::CSimplePointsMap::Create();
  for (int i = 0; i < 10; ++i) points->insertPoint(static_cast<float>(i), 1, 2);
  cloud.pointcloud = points;
  const auto fewer = std::dynamic_pointer_cast<mrpt::obs::CObservationPointCloud>(*thinned(cloud, 4));
  ASSERT_EQ(fewer->pointcloud->size(), 3U);
  for (size_t i = 0; i < 3; ++i)
    EXPECT_EQ(fewer->pointcloud->getPointsBufferRef_x()[i], 4 * static_cast<float>(i));
  EXPECT_EQ(points->size(), 10U) << "the cloud itself stays";
}

TEST(Thinned, LeavesWhatHasNoRaysAndRefusesWhatItCannotThin)
{
  EXPECT_FALSE(thinned(*odometry(at(0), 1, 2, 0), 3));
  EXPECT_THROW((void)thinned(mrpt::obs::CObservation3DRangeScan(), 3), std::runtime_error);
  EXPECT_THROW((void)thinned(*laser(at(0)), 0), UsageError);
}

ThinOptions optionsFor(const std::string& in, const std::string& out)
{
  ThinOptions options;
  options.inPath = in;
  options.outPath = out;
  options.every = 4;
  return options;
}

size_t raysIn(const std::string& path, size_t& scans)
{
  InputOptions inputs;
  inputs.paths = {path};
  size_t rays = 0;
  for (const auto& source : openInputs(inputs))
    while (const auto item = source->next())
    {
      rays += std::dynamic_pointer_cast<CObservation2DRangeScan>(std::get<ObservedScan>(*item).observation)
                  ->getScanSize();
      ++scans;
    }
  return rays;
}

TEST(ThinLog, WritesRawlogsAndSimpleMapsAgain)
{
  const TemporaryFolder folder;
  Objects frames;
  Objects observations;
  mrpt::maps::CSimpleMap map;
  for (int i = 0; i < 5; ++i)
  {
    frames.push_back(move2D(at(i), 0.1, 0, 0));
    frames.push_back(frame({laser(at(i))}));
    observations.push_back(odometry(at(i), 0.1 * i, 0, 0));
    observations.push_back(laser(at(i)));
    map.insert(mrpt::poses::CPose3DPDFGaussian::Create(), frame({laser(at(i))}));
  }
  writeLog(folder / "frames.rawlog", frames);
  writeLog(folder / "observations.rawlog", observations);
  ASSERT_TRUE(map.saveToFile(folder / "map.simplemap.gz"));
  for (const std::string name : {"frames.rawlog", "observations.rawlog", "map.simplemap.gz"})
  {
    SCOPED_TRACE(name);
    const ThinReport report = thinLog(optionsFor(folder / name, folder / ("thin_" + name)));
    EXPECT_TRUE(report.saved);
    EXPECT_EQ(report.thinned.at("mrpt::obs::CObservation2DRangeScan"), 5U);
    EXPECT_EQ(report.asTheyAre.size(), name == "observations.rawlog" ? 1U : 0U);
    size_t scans = 0;
    EXPECT_EQ(raysIn(folder / ("thin_" + name), scans), 15U);
    EXPECT_EQ(scans, 5U);
  }
}

TEST(ThinLog, NothingIsWrittenOfWhatCannotBeThinned)
{
  const TemporaryFolder folder;
  writeLog(folder / "camera.rawlog", {laser(at(0)), std::make_shared<mrpt::obs::CObservation3DRangeScan>()});
  folder.write("no.rawlog", "nothing of the kind");
  folder.write("no.simplemap", "nothing of the kind");
  for (const std::string name : {"camera.rawlog", "no.rawlog", "no.simplemap", "none.rawlog"})
  {
    SCOPED_TRACE(name);
    const std::string out = folder / ("out" + std::filesystem::path(name).extension().string());
    try
    {
      (void)thinLog(optionsFor(folder / name, out));
      ADD_FAILURE() << "it was thinned";
    }
    catch (const std::runtime_error& error)
    {
      EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
    }
    EXPECT_FALSE(std::filesystem::exists(out));
  }
  EXPECT_THROW((void)thinLog(optionsFor(folder / "camera.rawlog", folder / "a.simplemap")), UsageError);
  EXPECT_THROW((void)thinLog(optionsFor(folder / "camera.pcd", folder / "a.pcd")), UsageError);
}

TEST(ThinLog, OfALogThatWasCutShortIsWrittenWhatThereIs)
{
  const TemporaryFolder folder;
  constexpr int kScans = 500;
  Objects log;
  for (int i = 0; i < kScans; ++i) log.push_back(laser(at(i), 1 + 0.01F * static_cast<float>(i * i % 97)));
  writeLog(folder / "log.rawlog", log);
  std::filesystem::resize_file(folder / "log.rawlog", std::filesystem::file_size(folder / "log.rawlog") / 2);
  const ThinReport report = thinLog(optionsFor(folder / "log.rawlog", folder / "thin.rawlog"));
  EXPECT_TRUE(report.saved && report.damage);
  EXPECT_GT(report.thinned.begin()->second, 10U);
  EXPECT_LT(report.thinned.begin()->second, size_t{kScans});
}
}  // namespace
