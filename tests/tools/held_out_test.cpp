#include <gtest/gtest.h>
#include <lamap_core/training/scan_labels.h>
#include <lamap_mrpt/observations/observation_rays.h>
#include <lamap_tools/commands/held_out.h>
#include <lamap_tools/commands/map_build.h>
#include <lamap_tools/files/usage_error.h>
#include <lamap_tools/scores/held_out_cells.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "support/small_logs.h"
#include "support/temporary_folder.h"

namespace
{
using namespace lamap;
using namespace lamap::tools;
using namespace lamap::test;

/// Where the i-th scan was taken, and how far it saw.
mrpt::poses::CPose3D poseOf(int i)
{
  return mrpt::poses::CPose3D(mrpt::poses::CPose2D(0.2 * i, 0.02, 0.03 * i));
}

mrpt::obs::CObservation2DRangeScan::Ptr scanAt(int i)
{
  return laser(at(i), 2 + 0.03F * static_cast<float>(i));
}

/// The scans [0, count) but those that are left out.
void writeScans(const std::string& path, int count, const std::function<bool(int)>& leftOut)
{
  Objects objects;
  for (int i = 0; i < count; ++i)
  {
    objects.push_back(odometry(at(i), 0.2 * i, 0.02, 0.03 * i));
    if (!leftOut(i)) objects.push_back(scanAt(i));
  }
  writeLog(path, objects);
}

HeldOutOptions optionsFor(const std::string& input, size_t every, const std::string& map = "bgkMap")
{
  HeldOutOptions options;
  options.inputs.paths = {input};
  options.map.mapName = map;
  options.every = every;
  return options;
}

template <class Error>
std::string complaint(const HeldOutOptions& options)
{
  try
  {
    (void)scoreHeldOut(options);
  }
  catch (const Error& error)
  {
    return error.what();
  }
  return "";
}

/// The same by hand: a map of the other scans, and a Brier score of what those that were left out show.
TEST(HeldOut, IsAMapOfTheOtherScansAskedAboutWhatTheseShow)
{
  const TemporaryFolder folder;
  const auto heldOut = [](int i) { return i % 4 == 3; };
  writeScans(folder / "all.rawlog", 13, [](int) { return false; });
  writeScans(folder / "rest.rawlog", 13, heldOut);
  for (const std::string map : {"bgkMap", "octoMap"})
  {
    SCOPED_TRACE(map);
    HeldOutOptions options = optionsFor(folder / "all.rawlog", 4, map);
    // So that some of the cells that are asked for lie between beams, unobserved.
    if (map == "bgkMap") options.map.settings = {"insertOpts.beamWidth=none"};
    options.maxRange_m = 15;
    const HeldOutReport report = scoreHeldOut(options);
    EXPECT_EQ(report.heldOut, 3U);
    EXPECT_EQ(report.scans.usedCount(), 10U);
    EXPECT_FALSE(report.stopped || lamap::tools::damaged(report.inputs));

    BuildOptions build;
    build.map = options.map;
    build.inputs.paths = {folder / "rest.rawlog"};
    build.outPath = folder / (map == "octoMap" ? "rest.ot" : "rest.lamap.gz");
    (void)buildMap(build);
    const auto cells = openCellMap(build.outPath);
    double sum = 0;
    uint64_t occupied = 0, count = 0, observed = 0;
    LabelRules rules;
    rules.maxRange_m = 15;
    const auto ask = [&](const CellIndex& cell, double label)
    {
      const Eigen::Vector3d centre = cellCentre(cell, 0.1);
      const auto estimate = cells->estimateAt({centre.x(), centre.y(), centre.z()});
      observed += estimate.has_value();
      sum += std::pow((estimate ? estimate->prob : 0.5) - label, 2);
      ++count;
    };
    for (int i = 0; i < 13; ++i)
    {
      if (!heldOut(i)) continue;
      const ScanLabels labels = labelCells(*raysOf(*scanAt(i), poseOf(i)), rules);
      for (const CellIndex& cell : labels.occupied) ask(cell, 1);
      for (const CellIndex& cell : labels.free) ask(cell, 0);
      occupied += labels.occupied.size();
    }
    EXPECT_EQ(report.scores.all.cells(), count);
    EXPECT_EQ(report.scores.all.occupied, occupied);
    EXPECT_EQ(report.scores.observed.cells(), observed);
    EXPECT_LT(observed, count);
    EXPECT_NEAR(*report.scores.all.brier, sum / static_cast<double>(count), 1e-6);  // an .ot holds floats
    EXPECT_GT(*report.scores.all.areaUnderRoc, 0.6);
  }
}

/// A scan of which every third ray did not return.
mrpt::obs::CObservation2DRangeScan::Ptr holedScanAt(int i)
{
  auto scan = scanAt(i);
  for (size_t ray = 0; ray < 9; ray += 3)
  {
    scan->setScanRange(ray, scan->maxRange);
    scan->setScanRangeValidity(ray, false);
  }
  return scan;
}

// By hand: what the scan shows when those rays are cut from it.
TEST(HeldOut, GivesItsScoresAlsoWithoutTheRaysThatDidNotReturn)
{
  const TemporaryFolder folder;
  Objects objects;
  for (int i = 0; i < 4; ++i)
  {
    objects.push_back(odometry(at(i), 0.2 * i, 0.02, 0.03 * i));
    objects.push_back(holedScanAt(i));
  }
  writeLog(folder / "a.rawlog", objects);
  HeldOutOptions options = optionsFor(folder / "a.rawlog", 4);
  options.maxRange_m = 6;
  const HeldOutReport report = scoreHeldOut(options);

  LabelRules rules;
  rules.maxRange_m = 6;
  Scan scan = *raysOf(*holedScanAt(3), poseOf(3));
  const ScanLabels byAll = labelCells(scan, rules);
  auto& rays = scan.fans.front().rays;
  rays.erase(std::remove_if(rays.begin(), rays.end(),
                            [](const Ray& ray) { return ray.meaning == RayEnd::NoReturn; }),
             rays.end());
  ASSERT_EQ(rays.size(), 6U);
  const ScanLabels byReturned = labelCells(scan, rules);
  EXPECT_LT(byReturned.free.size() + 50, byAll.free.size());
  EXPECT_EQ(report.scores.all.free, byAll.free.size());
  EXPECT_EQ(report.scoresOfReturned.all.free, byReturned.free.size());
  EXPECT_EQ(report.scores.all.occupied, byAll.occupied.size());
  EXPECT_EQ(report.scoresOfReturned.all.occupied, byReturned.occupied.size());
  EXPECT_NE(*report.scores.all.logLoss, *report.scoresOfReturned.all.logLoss);
}

TEST(HeldOut, CountsTheScansOfEachSensorByThemselves)
{
  const TemporaryFolder folder;
  Objects objects;
  for (int i = 0; i < 8; ++i)
  {
    objects.push_back(odometry(at(i), 0, 0, 0));
    auto scan = scanAt(i);
    scan->sensorLabel = i % 2 == 0 ? "FRONT" : "REAR";
    if (i % 2 == 1) scan->sensorPose = mrpt::poses::CPose3D(0, 0, 0, M_PI, 0, 0);
    objects.push_back(scan);
  }
  writeLog(folder / "a.rawlog", objects);
  const HeldOutReport report = scoreHeldOut(optionsFor(folder / "a.rawlog", 2));
  EXPECT_EQ(report.heldOut, 4U);
  EXPECT_GT(report.scores.observedShare(), 0.9) << "the map was kept from one of the sensors";
}

TEST(HeldOut, TheNumberOfThreadsChangesNothing)
{
  const TemporaryFolder folder;
  writeScans(folder / "a.rawlog", 9, [](int) { return false; });
  HeldOutOptions options = optionsFor(folder / "a.rawlog", 3);
  options.threads = 1;
  const HeldOutReport one = scoreHeldOut(options);
  options.threads = 3;
  const HeldOutReport three = scoreHeldOut(options);
  EXPECT_EQ(one.scores.all.logLoss, three.scores.all.logLoss);
  EXPECT_EQ(one.scores.all.areaUnderRoc, three.scores.all.areaUnderRoc);
}

TEST(HeldOut, TheRangeIsTheMapsUnlessItIsGiven)
{
  const TemporaryFolder folder;
  writeScans(folder / "a.rawlog", 6, [](int) { return false; });
  HeldOutOptions options = optionsFor(folder / "a.rawlog", 3);
  EXPECT_EQ(scoreHeldOut(options).maxRange_m, 0);
  options.map.settings = {"insertOpts.maxRange=2.5"};
  const HeldOutReport asTheMap = scoreHeldOut(options);
  EXPECT_EQ(asTheMap.maxRange_m, 2.5);
  options.maxRange_m = 1;
  const HeldOutReport given = scoreHeldOut(options);
  EXPECT_EQ(given.maxRange_m, 1);
  EXPECT_EQ(given.scores.all.occupied, 0U);
  EXPECT_GT(asTheMap.scores.all.occupied, 0U);
  options = optionsFor(folder / "a.rawlog", 3, "octoMap");
  options.map.settings = {"insertOpts.maxrange=7"};
  EXPECT_EQ(scoreHeldOut(options).maxRange_m, 7);
}

TEST(HeldOut, APlanarMapIsAskedInItsLayer)
{
  const TemporaryFolder folder;
  writeScans(folder / "a.rawlog", 9, [](int) { return false; });
  HeldOutOptions options = optionsFor(folder / "a.rawlog", 3);
  options.map.settings = {"creationOpts.planar=true", "creationOpts.planarHeight=3"};
  EXPECT_GT(scoreHeldOut(options).scores.observedShare(), 0.5);
  EXPECT_GT(scoreHeldOut(optionsFor(folder / "a.rawlog", 3, "occupancyGrid")).scores.observedShare(), 0.5);
}

TEST(HeldOut, RefusesWhatCannotBeScored)
{
  const TemporaryFolder folder;
  writeScans(folder / "a.rawlog", 5, [](int) { return false; });
  for (const size_t every : {0U, 1U})
    EXPECT_NE(complaint<UsageError>(optionsFor(folder / "a.rawlog", every)).find(">= 2"), std::string::npos);
  const std::string tooFew = complaint<std::runtime_error>(optionsFor(folder / "a.rawlog", 6));
  EXPECT_NE(tooFew.find("a.rawlog: 5 usable scans"), std::string::npos) << tooFew;
  EXPECT_NE(complaint<UsageError>(optionsFor(folder / "a.rawlog", 2, "pointsMap")).find("no cells"),
            std::string::npos);
  EXPECT_NE(complaint<std::exception>(optionsFor(folder / "none.rawlog", 2)).find("none.rawlog"),
            std::string::npos);
  HeldOutOptions deaf = optionsFor(folder / "a.rawlog", 2);
  deaf.map.settings = {"creationOpts.enableObservationInsertion=false"};
  const std::string nothing = complaint<std::runtime_error>(deaf);
  EXPECT_NE(nothing.find("enableObservationInsertion"), std::string::npos) << nothing;
}

TEST(HeldOut, StopsWhenAskedTo)
{
  const TemporaryFolder folder;
  writeScans(folder / "a.rawlog", 9, [](int) { return false; });
  HeldOutOptions options = optionsFor(folder / "a.rawlog", 3);
  size_t done = 0;
  options.inputs.shouldStop = [&] { return done >= 4; };
  const HeldOutReport report = scoreHeldOut(options, [&](const Progress& progress) { done = progress.done; });
  EXPECT_TRUE(report.stopped);
  EXPECT_EQ(done, 4U);
}
}  // namespace
