#include <gtest/gtest.h>
#include <lamap_mrpt/files/map_file.h>
#include <lamap_mrpt/maps/CBGKMap.h>
#include <lamap_mrpt/observations/observation_rays.h>
#include <lamap_tools/cells/cell_map.h>
#include <lamap_tools/cells/truth.h>
#include <lamap_tools/commands/map_build.h>
#include <lamap_tools/files/usage_error.h>
#include <lamap_tools/inputs/pose_track.h>
#include <lamap_tools/simulate/simulate.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRange.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>

#include <cmath>
#include <functional>
#include <map>
#include <set>

#include "support/temporary_folder.h"

namespace lamap::tools
{
namespace
{
using Eigen::Vector3d;
using mrpt::obs::CObservation2DRangeScan;
using mrpt::obs::CObservationPointCloud;

class Simulated : public testing::Test
{
 protected:
  SimulateOptions optionsFor(const std::string& world, const std::string& out = "a.rawlog")
  {
    SimulateOptions options;
    options.world = world;
    options.seed = 7;
    options.outPath = folder_ / out;
    return options;
  }

  std::vector<ObservedScan> scansOf(const std::string& path) const
  {
    InputOptions input;
    input.paths = {path};
    const auto sources = openInputs(input);
    std::vector<ObservedScan> scans;
    while (const auto item = sources.front()->next()) scans.push_back(std::get<ObservedScan>(*item));
    return scans;
  }

  test::TemporaryFolder folder_;
};

std::map<std::string, std::string> contentOf(const std::vector<std::string>& files)
{
  std::map<std::string, std::string> content;
  for (const std::string& path : files)
    content[path.substr(path.find_last_of("/.") + 1)] = test::fileContent(path);
  return content;
}

TEST_F(Simulated, TheSameOptionsGiveTheSameBytesAndAnotherSeedOthers)
{
  for (const char* world : {"structured", "pier", "flatland"})
  {
    SCOPED_TRACE(world);
    SimulateOptions options = optionsFor(world);
    options.scans = 3;
    options.resolution_m = 0.2;
    options.truthPaths = {folder_ / "t.csv", folder_ / "t.bt"};
    options.noise = {0.01, 0.002, world == std::string("structured") ? 0.01 : 0.0, 0.1, 0.02, 0.01};
    options.odometryNoise = 0.02;
    const auto first = contentOf(simulate(options).files);
    const auto again = contentOf(simulate(options).files);
    options.seed = 8;
    const auto other = contentOf(simulate(options).files);
    ASSERT_EQ(first.size(), 5U);
    for (const auto& [kind, bytes] : first)
    {
      EXPECT_GT(bytes.size(), 100U) << kind;
      EXPECT_TRUE(bytes == again.at(kind)) << kind;
      EXPECT_FALSE(bytes == other.at(kind)) << kind;
    }
  }
}

/// The ray from a scan's origin to one of its ends, and how far off the world's first surface the end lies.
double offSurface(const sim::World& world, const Vector3d& origin, const Vector3d& end)
{
  const Vector3d ray = end - origin;
  const auto hit = world.scene.firstHit(origin, ray.normalized(), 1000);
  return hit ? ray.norm() - hit->range_m : 1000;
}

// Through the log, its composed poses and our own reader: what comes out lies where the world's surfaces are.
TEST_F(Simulated, EndPointsLieOnSurfacesWithinTheNoise)
{
  for (const double noise : {0.0, 0.02})
    for (const char* worldName : {"structured", "unstructured", "corridor", "flatland"})
    {
      SCOPED_TRACE(std::string(worldName) + " " + std::to_string(noise));
      SimulateOptions options = optionsFor(worldName);
      options.scans = 4;
      options.noise.range_m = noise;
      simulate(options);
      const sim::World world = sim::makeWorld(worldName, 7);
      size_t count = 0;
      double squares = 0;
      for (const ObservedScan& scan : scansOf(options.outPath))
      {
        const auto rays = raysOf(*scan.observation, scan.robotPose_map);
        for (const RayFan& fan : rays->fans)
          for (const Ray& ray : fan.rays)
          {
            if (ray.meaning != RayEnd::Return) continue;
            const Vector3d end = rays->inMap(ray.end), origin = rays->inMap(fan.centre);
            const double range = (end - origin).norm();
            if (range > 29.9 || (std::string(worldName) != "corridor" && range > 7.9)) continue;
            const double off = offSurface(world, origin, end);
            // Rays that graze an edge may pass it or not by a rounding of their direction.
            if (std::abs(off) > 6 * noise + 0.01) continue;
            ++count;
            squares += off * off;
          }
      }
      EXPECT_GT(count, worldName == std::string("flatland") ? 1000U : 8000U);
      const double deviation = std::sqrt(squares / static_cast<double>(count));
      EXPECT_NEAR(deviation, noise, noise > 0 ? 0.002 : 2e-4);
    }
}

TEST_F(Simulated, NearlyNoReturnIsOffItsSurface)
{
  SimulateOptions options = optionsFor("structured");
  simulate(options);
  const sim::World world = sim::makeWorld("structured", 7);
  size_t off = 0;
  size_t all = 0;
  for (const ObservedScan& scan : scansOf(options.outPath))
  {
    const auto rays = raysOf(*scan.observation, scan.robotPose_map);
    const Vector3d origin = rays->inMap(rays->fans.front().centre);
    for (const Ray& ray : rays->fans.front().rays)
    {
      if (ray.meaning != RayEnd::Return) continue;
      const Vector3d end = rays->inMap(ray.end);
      const double range = (end - origin).norm();
      if (range > 8)
      {
        EXPECT_NEAR(range, 12, 1e-4);  // no return: a point at 1.5 times the maximum range
        const auto hit = world.scene.firstHit(origin, (end - origin) / range, 7.999);
        off += hit ? 1 : 0;
      }
      else
        off += std::abs(offSurface(world, origin, end)) > 1e-3 ? 1 : 0;
      ++all;
    }
  }
  EXPECT_EQ(all, 12U * 3500U);
  EXPECT_LT(off, all / 2000);
}

TEST_F(Simulated, A3DScanIsACloudInTheFrameOfTheRobot)
{
  SimulateOptions options = optionsFor("corridor");
  options.scans = 2;
  simulate(options);
  const auto scans = scansOf(options.outPath);
  ASSERT_EQ(scans.size(), 2U);
  for (const ObservedScan& scan : scans)
  {
    const auto cloud = std::dynamic_pointer_cast<CObservationPointCloud>(scan.observation);
    ASSERT_TRUE(cloud);
    EXPECT_EQ(cloud->sensorPose, mrpt::poses::CPose3D());
    EXPECT_EQ(cloud->pointcloud->size(), 89000U);
    EXPECT_EQ(cloud->sensorLabel, "pan-tilt-laser");
    EXPECT_GT(scan.robotPose_map.z(), 0.9);
  }
}

TEST_F(Simulated, APlanarScanStandsOnARobotOnTheGround)
{
  SimulateOptions options = optionsFor("corridor");
  options.sensor = "planar-laser";
  options.scans = 5;
  options.noise.missing = 0.2;
  simulate(options);
  size_t lost = 0;
  for (const ObservedScan& scan : scansOf(options.outPath))
  {
    const auto laser = std::dynamic_pointer_cast<CObservation2DRangeScan>(scan.observation);
    ASSERT_TRUE(laser);
    EXPECT_EQ(scan.robotPose_map.z(), 0);
    EXPECT_GT(laser->sensorPose.z(), 0.4);
    EXPECT_NEAR(laser->aperture, M_PI, 1e-6);
    EXPECT_EQ(laser->maxRange, 30);
    ASSERT_EQ(laser->getScanSize(), 361U);
    for (size_t i = 0; i < 361; ++i)
      if (!laser->getScanRangeValidity(i))
      {
        EXPECT_EQ(laser->getScanRange(i), 30);
        ++lost;
      }
  }
  EXPECT_NEAR(static_cast<double>(lost) / (5 * 361), 0.2, 0.03);
}

TEST_F(Simulated, ASonarPingIsAScanOfOneBeamForEachEcho)
{
  SimulateOptions options = optionsFor("pier");
  options.scans = 4;
  const SimulateReport report = simulate(options);
  EXPECT_EQ(report.scans, 4U);
  std::map<mrpt::Clock::time_point, std::vector<CObservation2DRangeScan::Ptr>> pings;
  for (const ObservedScan& scan : scansOf(options.outPath))
    pings[scan.observation->timestamp].push_back(
        std::dynamic_pointer_cast<CObservation2DRangeScan>(scan.observation));
  EXPECT_EQ(pings.size(), 4U * 120U);
  size_t several = 0;
  size_t silent = 0;
  for (const auto& [time, echoes] : pings)
  {
    float last = 0;
    for (size_t rank = 1; rank <= echoes.size(); ++rank)
    {
      const auto& echo = echoes[rank - 1];
      ASSERT_TRUE(echo);
      EXPECT_EQ(echo->sensorLabel, "SONAR/echo" + std::to_string(rank));
      EXPECT_NEAR(echo->beamAperture, 15 * M_PI / 180, 1e-6);
      ASSERT_EQ(echo->getScanSize(), 1U);
      ASSERT_TRUE(echo->hasIntensity());
      if (!echo->getScanRangeValidity(0))
      {
        EXPECT_EQ(echoes.size(), 1U);
        ++silent;
        continue;
      }
      EXPECT_GT(echo->getScanRange(0), last);
      EXPECT_LT(echo->getScanRange(0), 15);
      EXPECT_GE(echo->getScanIntensity(0), 1);
      last = echo->getScanRange(0);
    }
    several += echoes.size() > 1 ? 1 : 0;
  }
  EXPECT_GT(several, 100U);
  EXPECT_EQ(silent, report.noReturns);
}

TEST_F(Simulated, ASingleEchoIsARange)
{
  SimulateOptions options = optionsFor("pier");
  options.sensor = "sonar-range";
  options.scans = 1;
  const SimulateReport report = simulate(options);
  size_t heard = 0;
  const auto scans = scansOf(options.outPath);
  ASSERT_EQ(scans.size(), 120U);
  for (const ObservedScan& scan : scans)
  {
    const auto range = std::dynamic_pointer_cast<mrpt::obs::CObservationRange>(scan.observation);
    ASSERT_TRUE(range);
    ASSERT_EQ(range->sensedData.size(), 1U);
    EXPECT_EQ(range->maxSensorDistance, 15);
    heard += range->sensedData[0].sensedDistance > 0 ? 1 : 0;
  }
  EXPECT_EQ(heard, report.returns);
}

TEST_F(Simulated, TheTruePosesAreThoseOfTheLogUnlessItErrs)
{
  for (const char* world : {"structured", "pier", "flatland"})
  {
    SCOPED_TRACE(world);
    SimulateOptions options = optionsFor(world);
    options.scans = 4;
    simulate(options);
    const PoseTrack track(readPoseFile(folder_ / "a.tum"));
    for (const ObservedScan& scan : scansOf(options.outPath))
    {
      const auto pose = track.at(scan.observation->timestamp);
      ASSERT_TRUE(pose);
      EXPECT_NEAR((*pose - scan.robotPose_map).norm(), 0, 1e-8);
      EXPECT_NEAR(std::remainder(pose->yaw() - scan.robotPose_map.yaw(), 2 * M_PI), 0, 1e-8);
    }
  }
}

double meanOffset(const std::vector<ObservedScan>& scans, const PoseTrack& track, size_t first, size_t last)
{
  double sum = 0;
  for (size_t i = first; i < last; ++i)
    sum += track.at(scans[i].observation->timestamp)->distanceTo(scans[i].robotPose_map);
  return sum / static_cast<double>(last - first);
}

TEST_F(Simulated, PoseNoiseStaysAndOdometryNoiseAddsUp)
{
  SimulateOptions options = optionsFor("flatland");
  options.scans = 400;
  options.noise.position_m = 0.1;
  options.noise.turn_rad = 0.01;
  simulate(options);
  const PoseTrack track(readPoseFile(folder_ / "a.tum"));
  auto scans = scansOf(options.outPath);
  const double mean = 0.1 * std::sqrt(M_PI / 2);  // of the length of a 2D Gaussian
  EXPECT_NEAR(meanOffset(scans, track, 0, 200), mean, 0.02);
  EXPECT_NEAR(meanOffset(scans, track, 200, 400), mean, 0.02);
  for (const ObservedScan& scan : scans) EXPECT_EQ(scan.robotPose_map.z(), 0);

  options.noise = {};
  options.odometryNoise = 0.1;
  simulate(options);
  scans = scansOf(options.outPath);
  EXPECT_EQ(meanOffset(scans, track, 0, 1) < 1e-6, true) << "the first movement is exact";
  EXPECT_GT(meanOffset(scans, track, 200, 400), 2 * meanOffset(scans, track, 0, 50));
}

TEST_F(Simulated, ASimplemapHasTheCovarianceOfThePoses)
{
  SimulateOptions options = optionsFor("structured", "a.simplemap");
  options.scans = 3;
  options.noise.position_m = 0.05;
  options.noise.turn_rad = 0.02;
  simulate(options);
  mrpt::maps::CSimpleMap map;
  ASSERT_TRUE(map.loadFromFile(options.outPath));
  ASSERT_EQ(map.size(), 3U);
  mrpt::poses::CPose3DPDF::ConstPtr pose;
  mrpt::obs::CSensoryFrame::ConstPtr frame;
  map.get(1, pose, frame);
  const auto gaussian = std::dynamic_pointer_cast<const mrpt::poses::CPose3DPDFGaussian>(pose);
  ASSERT_TRUE(gaussian);
  EXPECT_NEAR(gaussian->cov(0, 0), 0.0025, 1e-12);
  EXPECT_NEAR(gaussian->cov(3, 3), 0.0004, 1e-12);
  EXPECT_EQ(gaussian->cov(0, 1), 0);
  const PoseTrack track(readPoseFile(folder_ / "a.tum"));
  const double off = track.poses()[1].pose_map.distanceTo(gaussian->mean);
  EXPECT_GT(off, 0.005);
  EXPECT_LT(off, 0.3);
}

TEST_F(Simulated, ItsConfigurationBuildsOurMapAndMrptsOnTheTruth)
{
  SimulateOptions options = optionsFor("structured");
  options.resolution_m = 0.2;
  options.rangeMax_m = 6;
  options.truthPaths = {folder_ / "t.csv"};
  simulate(options);
  BuildOptions build;
  build.inputs.paths = {options.outPath};
  build.map.configPath = folder_ / "a.ini";
  build.map.mapName = "bgkMap";
  build.outPath = folder_ / "a.lamap.gz";
  EXPECT_EQ(buildMap(build).scans.usedCount(), 12U);
  const auto bgk = std::dynamic_pointer_cast<CBGKMap>(loadMapFile(build.outPath));
  ASSERT_TRUE(bgk);
  EXPECT_TRUE(bgk->optionIs("insertOpts", "maxRange", "6"));
  EXPECT_TRUE(bgk->optionIs("creationOpts", "resolution", "0.2"));

  // OctoMap marks the cells that rays end in: each holds a surface, if it is not at the brink of one.
  build.map.mapName = "octoMap";
  build.outPath = folder_ / "a.ot";
  buildMap(build);
  const sim::World world = sim::makeWorld("structured", 7);
  size_t occupied = 0;
  size_t mixed = 0;
  openCellMap(build.outPath)
      ->visitCells(
          [&](const CellIndex& cell, const CellEstimate& estimate)
          {
            if (estimate.state != CellState::Occupied) return;
            ++occupied;
            const Vector3d low(0.2 * cell.x, 0.2 * cell.y, 0.2 * cell.z);
            const Eigen::AlignedBox3d box(low, low + Vector3d::Constant(0.2));
            mixed += world.scene.relationOf(box) == sim::Relation::Mixed ? 1 : 0;
          });
  EXPECT_GT(occupied, 2000U);
  EXPECT_GT(mixed, occupied - occupied / 200);
}

TEST_F(Simulated, TheTruthAsTextAndAsTreeIsTheSame)
{
  SimulateOptions options = optionsFor("structured");
  options.resolution_m = 0.2;
  options.truthPaths = {folder_ / "t.csv", folder_ / "t.bt"};
  const SimulateReport report = simulate(options);
  const auto labelsOf = [](const Truth& truth)
  {
    std::map<std::tuple<long, long, long>, bool> labels;
    for (const TrueCell& cell : truth.cells)
    {
      const Vector3d at = cell.centre_map * 10;  // centres are odd multiples of 0.1 m
      labels[{std::lround(at.x()), std::lround(at.y()), std::lround(at.z())}] = cell.occupied;
    }
    return labels;
  };
  const Truth csv = readTruth(folder_ / "t.csv");
  EXPECT_EQ(csv.occupiedCount(), report.occupiedCells);
  EXPECT_EQ(csv.cells.size(), report.occupiedCells + report.freeCells);
  EXPECT_TRUE(csv.isOnGrid(0.2));
  EXPECT_TRUE(labelsOf(csv) == labelsOf(readTruth(folder_ / "t.bt")));
}

using Cell = std::tuple<long, long, long>;
Cell cellOf(const Vector3d& point, double resolution_m)
{
  const Vector3d index = (point / resolution_m).array().floor();
  return {std::lround(index.x()), std::lround(index.y()), std::lround(index.z())};
}

// Through the files: each return of an exact log ends in a cell that the truth of surfaces calls occupied, or
// on its face (the log holds floats).
TEST_F(Simulated, EveryReturnEndsInAnOccupiedCellOfTheTruthOfSurfaces)
{
  for (const char* world : {"structured", "poles", "flatland"})
  {
    SCOPED_TRACE(world);
    SimulateOptions options = optionsFor(world);
    options.scans = 6;
    options.truthPaths = {folder_ / "t.csv"};
    options.truthOf = "surfaces";
    const SimulateReport report = simulate(options);
    const Truth truth = readTruth(folder_ / "t.csv");
    EXPECT_EQ(truth.occupiedCount(), report.occupiedCells);
    EXPECT_EQ(truth.cells.size(), report.occupiedCells + report.freeCells);
    std::set<Cell> occupied;
    for (const TrueCell& cell : truth.cells)
      if (cell.occupied) occupied.insert(cellOf(cell.centre_map, 0.1));
    size_t returns = 0;
    size_t elsewhere = 0;
    for (const ObservedScan& scan : scansOf(options.outPath))
    {
      const auto rays = raysOf(*scan.observation, scan.robotPose_map);
      for (const Ray& ray : rays->fans.front().rays)
      {
        if (ray.meaning != RayEnd::Return || ray.end.norm() > report.rangeMax_m) continue;
        ++returns;
        bool found = false;
        for (int corner = 0; corner < 8; ++corner)
        {
          const Vector3d side(corner & 1, corner >> 1 & 1, corner >> 2);
          Vector3d near = rays->inMap(ray.end) + 1e-5 * (2 * side.array() - 1).matrix();
          if (truth.isOneLayer()) near.z() = truth.cells.front().centre_map.z();
          found = found || occupied.count(cellOf(near, 0.1)) == 1;
        }
        elsewhere += found ? 0 : 1;
      }
    }
    EXPECT_GT(returns, world == std::string("flatland") ? 1000U : 10000U);
    EXPECT_EQ(elsewhere, 0U);
  }
}

TEST_F(Simulated, SurfacePointsAreInTheCellsOfTheSurface)
{
  SimulateOptions options = optionsFor("poles");
  options.truthPaths = {folder_ / "t.csv"};
  options.truthOf = "surfaces";
  options.surfacePath = folder_ / "s.csv";
  const SimulateReport report = simulate(options);
  EXPECT_EQ(report.files.back(), options.surfacePath);
  Truth truth = readTruth(folder_ / "t.csv");
  readSurface(folder_ / "s.csv", truth);
  EXPECT_EQ(truth.surface_map.size(), report.surfacePoints);
  std::set<Cell> holding;
  for (const Vector3d& point : truth.surface_map) holding.insert(cellOf(point, 0.1));
  for (const TrueCell& cell : truth.cells)
    if (!cell.occupied)
    {
      ASSERT_EQ(holding.count(cellOf(cell.centre_map, 0.1)), 0U) << cell.centre_map.transpose();
    }
  EXPECT_GT(holding.size(), truth.occupiedCount() * 9 / 10);
}

/// How often each meaning occurs among the rays of all scans.
std::map<RayEnd, size_t> meaningsIn(const std::vector<ObservedScan>& scans)
{
  std::map<RayEnd, size_t> counts;
  for (const ObservedScan& scan : scans)
  {
    const auto rays = raysOf(*scan.observation, scan.robotPose_map);
    for (const RayFan& fan : rays->fans)
      for (const Ray& ray : fan.rays) ++counts[ray.meaning];
  }
  return counts;
}

TEST_F(Simulated, ALostRangeIsWrittenAsAskedFor)
{
  SimulateOptions options = optionsFor("flatland");
  options.rangeMax_m = 30;  // then every beam meets a wall
  options.scans = 3;
  options.noise.missing = 0.3;
  const std::map<std::string, std::function<bool(float)>> codes{
      {"open", [](float range) { return range == 30; }},
      {"zero", [](float range) { return range == 0; }},
      {"nan", [](float range) { return std::isnan(range); }},
      {"inf", [](float range) { return std::isinf(range) && range > 0; }},
      {"max", [](float range) { return range == 30; }},
      {"invalid", [](float range) { return range > 0 && range < 15; }}};
  for (const auto& [name, isCode] : codes)
  {
    SCOPED_TRACE(name);
    options.missingAs = name;
    const SimulateReport report = simulate(options);
    EXPECT_GT(report.lost, 250U);
    size_t invalid = 0;
    for (const ObservedScan& scan : scansOf(options.outPath))
    {
      const auto& ranges = dynamic_cast<const CObservation2DRangeScan&>(*scan.observation);
      for (size_t i = 0; i < ranges.getScanSize(); ++i)
      {
        if (ranges.getScanRangeValidity(i)) continue;
        ++invalid;
        ASSERT_TRUE(isCode(ranges.getScanRange(i))) << ranges.getScanRange(i);
      }
    }
    EXPECT_EQ(invalid, report.lost);
    EXPECT_EQ(report.noReturns, report.lost);
  }
  options.missingAs = "invalid";
  const SimulateReport report = simulate(options);
  EXPECT_EQ(meaningsIn(scansOf(options.outPath))[RayEnd::Dropped], report.lost) << "not open space";
}

TEST_F(Simulated, ALostPointIsWrittenAsAskedFor)
{
  SimulateOptions options = optionsFor("structured");
  options.rangeMax_m = 6;
  options.scans = 3;
  options.noise.missing = 0.3;
  options.noise.longestBurst = 20;
  const std::map<std::string, std::function<bool(const Vector3d&)>> codes{
      {"zero", [](const Vector3d& point) { return point.isZero(0); }},
      {"nan", [](const Vector3d& point) { return point.array().isNaN().all(); }},
      {"inf", [](const Vector3d& point)
       { return point.array().isInf().any() && !point.array().isNaN().any() && point.x() > 0; }},
      {"max", [](const Vector3d& point) { return std::abs(point.norm() - 6) < 1e-5; }}};
  for (const auto& [name, isCode] : codes)
  {
    SCOPED_TRACE(name);
    options.missingAs = name;
    const SimulateReport report = simulate(options);
    EXPECT_GT(report.lost, 2000U);
    size_t coded = 0;
    size_t points = 0;
    for (const ObservedScan& scan : scansOf(options.outPath))
    {
      const auto& cloud = *dynamic_cast<const CObservationPointCloud&>(*scan.observation).pointcloud;
      for (size_t i = 0; i < cloud.size(); ++i)
      {
        float x = 0, y = 0, z = 0;
        cloud.getPointFast(i, x, y, z);
        ++points;
        coded += isCode({x, y, z}) ? 1 : 0;
      }
    }
    EXPECT_EQ(points, 3U * 3500U);
    EXPECT_EQ(coded, report.lost);
  }
  options.missingAs = "invalid";
  const SimulateReport report = simulate(options);
  size_t points = 0;
  for (const ObservedScan& scan : scansOf(options.outPath))
    points += dynamic_cast<const CObservationPointCloud&>(*scan.observation).pointcloud->size();
  EXPECT_EQ(points, 3U * 3500U - report.lost);
}

TEST_F(Simulated, ALostEchoIsWrittenAsAskedFor)
{
  SimulateOptions options = optionsFor("pier");
  options.scans = 1;
  options.noise.missing = 1;
  options.missingAs = "invalid";
  const SimulateReport report = simulate(options);
  EXPECT_EQ(report.returns, 0U);
  EXPECT_GT(report.lost, 60U);
  auto meanings = meaningsIn(scansOf(options.outPath));
  EXPECT_EQ(meanings[RayEnd::Return], 0U);
  EXPECT_GT(meanings[RayEnd::Dropped], 50U) << "pings that heard nothing of what they met";
  EXPECT_EQ(meanings[RayEnd::Dropped] + meanings[RayEnd::NoReturn], 120U);

  options.sensor = "sonar-range";
  options.missingAs = "max";
  simulate(options);
  for (const ObservedScan& scan : scansOf(options.outPath))
  {
    const auto& ranges = dynamic_cast<const mrpt::obs::CObservationRange&>(*scan.observation);
    ASSERT_EQ(ranges.sensedData.size(), 1U);
    const float distance = ranges.sensedData[0].sensedDistance;
    EXPECT_TRUE(distance == 15 || distance == 0) << distance;
  }
}

TEST_F(Simulated, AWayFromAFileAndAPlaceAreKept)
{
  SimulateOptions options = optionsFor("structured");
  options.trajectory = folder_.write("way.tum", "1 2 2 0.5 0 0 0 1\n2 2.2 2 0.6 0 0 0.1 0.99498743710662\n");
  EXPECT_EQ(simulate(options).scans, 2U);
  const auto scans = scansOf(options.outPath);
  EXPECT_NEAR(scans[1].robotPose_map.x(), 2.2, 1e-8);
  EXPECT_NEAR(scans[1].robotPose_map.z(), 0.6, 1e-8);
  EXPECT_NEAR(scans[1].robotPose_map.yaw(), 2 * std::asin(0.1), 1e-7);

  options.trajectory.clear();
  options.standAt = "2,2,0.5,90";
  options.scans = 3;
  simulate(options);
  for (const ObservedScan& scan : scansOf(options.outPath))
  {
    EXPECT_NEAR(scan.robotPose_map.yaw(), M_PI / 2, 1e-8);
    EXPECT_NEAR(scan.robotPose_map.x(), 2, 1e-8);
  }
}

TEST_F(Simulated, RefusesWhatCannotBeAndWritesNothing)
{
  using Change = std::function<void(SimulateOptions&)>;
  const auto expectRefused = [&](const Change& change, const std::string& word)
  {
    SimulateOptions options = optionsFor("structured");
    change(options);
    try
    {
      simulate(options);
      ADD_FAILURE() << "accepted; expected a word of " << word;
    }
    catch (const UsageError& error)
    {
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
  };
  expectRefused([](auto& o) { o.world = "structurd"; }, "did you mean structured?");
  expectRefused([](auto& o) { o.world = "structurd"; }, "flatland");
  expectRefused([](auto& o) { o.sensor = "pan-tilt-lasr"; }, "did you mean pan-tilt-laser?");
  expectRefused([](auto& o) { o.world = "flatland", o.sensor = "sonar"; },
                "--sensor sonar: flatland is two-dimensional");
  expectRefused([](auto& o) { o.sensor = "pan-tilt-lasr"; }, "--sensor ");
  expectRefused([&](auto& o) { o.resolution_m = 1e-7, o.truthPaths = {folder_ / "a.csv"}; },
                "--resolution = 1e-7 m");
  expectRefused([&](auto& o) { o.outPath = folder_ / "a.log"; }, ".rawlog or .simplemap");
  expectRefused([&](auto& o) { o.truthPaths = {folder_ / "a.txt"}; }, ".csv or .bt");
  expectRefused([&](auto& o) { o.truthPaths = {folder_ / "a.csv", folder_ / "a.csv"}; }, "twice");
  expectRefused([](auto& o) { o.scans = 0; }, "--scans 0");
  // Before any work, with what it would need.
  for (const std::string at : {"", "2,2,0.5"})
  {
    const auto many = [&](int scans, const std::string& sensor, const std::string& format)
    {
      return [=](SimulateOptions& o)
      { o.scans = scans, o.sensor = sensor, o.standAt = at, o.outPath = folder_ / ("a." + format); };
    };
    expectRefused(many(100'000'000, "sector-laser", "rawlog"),
                  "--scans 100000000: 3.5e+11 rays of a sector-laser, some 4.2e+03 GB of log");
    expectRefused(many(2'000'000'000, "sonar", "rawlog"),
                  "--scans 2000000000: 2.4e+11 rays of a sonar, some 2.04e+05 GB of log; a .rawlog has at "
                  "most 1e+07 pings");
    expectRefused(many(5'000'000, "pan-tilt-laser", "rawlog"), "4.45e+11 rays of a pan-tilt-laser");
    expectRefused(many(1'000'000, "sector-laser", "simplemap"), "because it is held in memory");
  }
  for (const double bad : {0.0, -0.1, std::nan(""), HUGE_VAL})
    expectRefused([&](auto& o) { o.resolution_m = bad; }, "--resolution");
  expectRefused([](auto& o) { o.truthDepth_m = 0; }, "--truth-depth 0");
  for (const double bad : {0.0, -1.0, std::nan("")})
    expectRefused([&](auto& o) { o.rangeMax_m = bad; }, "--max-range = ");
  expectRefused([](auto& o) { o.truthOf = "surface"; }, "did you mean surfaces?");
  expectRefused([](auto& o) { o.truthOf = "surfaces", o.truthDepth_m = 0.2; }, "--truth-depth");
  expectRefused([](auto& o) { o.surfacePath = "s.pcd"; }, ".csv");
  expectRefused([](auto& o) { o.missingAs = "null"; }, "invalid");
  expectRefused([](auto& o) { o.noise.missing = 0.9, o.noise.longestBurst = 2; },
                "--missing = 0.9: with bursts of up to 2 beams, at most 0.6");
  expectRefused([](auto& o) { o.noise.longestBurst = 0; }, "--missing-burst = 0");
  expectRefused([](auto& o) { o.world = "pier", o.noise.longestBurst = 5; }, "--missing-burst: a sonar");
  expectRefused([](auto& o) { o.noise.missing = 2; }, "--missing: 2: must be from 0 to 1");
  expectRefused([](auto& o) { o.noise.range_m = -1; }, "--range-noise: -1 m: must be from 0 to 100 m");
  expectRefused([](auto& o) { o.noise.range_m = 1e300; }, "--range-noise");
  expectRefused([](auto& o) { o.noise.angle_rad = 4; }, "--angle-noise: 229.183 deg");
  expectRefused([](auto& o) { o.noise.turn_rad = -0.1; }, "--pose-noise: -5.72958 deg");
  expectRefused([](auto& o) { o.odometryNoise = std::nan(""); }, "--odometry-noise: nan");
  expectRefused([](auto& o) { o.trajectory = "flying"; }, "neither stops nor driving");
  expectRefused([&](auto& o) { o.odometryNoise = 1, o.outPath = folder_ / "a.simplemap"; }, "no odometry");
  expectRefused([](auto& o) { o.sensor = "planar-laser", o.noise.point_m = 0.1; },
                "--point-noise: a planar-laser");
  expectRefused([](auto& o) { o.standAt = "1,2"; }, "x,y,z");
  expectRefused([](auto& o) { o.standAt = "1,2,3m"; }, "x,y,z");
  expectRefused([](auto& o) { o.standAt = "-0.5,2,0.5"; }, "--at -0.5,2,0.5");
  expectRefused([](auto& o) { o.standAt = "2,2,-0.2"; }, "outside the world");
  expectRefused([](auto& o) { o.standAt = "2,2,0.5", o.trajectory = "stops"; }, "name one");
  EXPECT_EQ(folder_.size(), 0U);
}

TEST_F(Simulated, WritesAllOfItsFilesOrNone)
{
  folder_.write("a.tum", "of before");
  std::filesystem::create_symlink("/dev/full", folder_ / "truth.csv");
  SimulateOptions options = optionsFor("flatland");
  options.outPath = folder_ / "a.rawlog";
  options.truthPaths = {folder_ / "truth.csv", folder_ / "truth.bt"};
  EXPECT_THROW(simulate(options), std::runtime_error);
  EXPECT_EQ(test::fileContent(folder_ / "a.tum"), "of before");
  EXPECT_EQ(folder_.size(), 2U);
}

TEST_F(Simulated, NamesThePoseOfAFileThatLiesInAWall)
{
  SimulateOptions options = optionsFor("structured");
  options.trajectory = folder_.write("way.tum", "1 2 2 0.5 0 0 0 1\n2 -0.3 2 0.5 0 0 0 1\n");
  try
  {
    simulate(options);
    ADD_FAILURE();
  }
  catch (const std::runtime_error& error)
  {
    const std::string what = error.what();
    EXPECT_NE(what.find("way.tum: pose 2"), std::string::npos) << what;
    EXPECT_NE(what.find("-0.3, 2, 0.5"), std::string::npos) << what;
  }
  options.trajectory = folder_ / "none.tum";
  EXPECT_THROW(simulate(options), std::runtime_error);
  options.trajectory.clear();
  options.outPath = folder_ / "none/a.rawlog";
  EXPECT_THROW(simulate(options), std::runtime_error);
  EXPECT_EQ(folder_.size(), 1U);
}

// Asked to stop at its n-th question, whether that comes in the log or in the truth.
TEST_F(Simulated, StoppedItLeavesNothing)
{
  for (const int questions : {0, 3, 12, 13})
  {
    SimulateOptions options = optionsFor("structured");
    options.truthPaths = {folder_ / "t.csv", folder_ / "t.bt"};
    int asked = 0;
    options.shouldStop = [&] { return asked++ >= questions; };
    const SimulateReport report = simulate(options);
    EXPECT_TRUE(report.stopped) << questions;
    EXPECT_TRUE(report.files.empty());
    EXPECT_EQ(folder_.size(), 0U);
  }
}
}  // namespace
}  // namespace lamap::tools
