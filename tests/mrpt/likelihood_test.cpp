#include <gtest/gtest.h>
#include <lamap_mrpt/maps/CBGKMap.h>
#include <lamap_mrpt/observations/observation_rays.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRange.h>

#include <support/small_maps.h>

namespace
{
using lamap::CBGKMap;
using lamap::CellIndex;
using lamap::Option;
using namespace lamap::test;
using mrpt::poses::CPose3D;

const CPose3D kRobot(0.4, -0.3, 0.0, 0.35, 0, 0);

CBGKMap roomMap()
{
  CBGKMap map;
  for (const size_t rays : {181, 251, 199}) map.insertObservation(roomScan(rays));
  return map;
}

/// The formula of end_point_likelihood.h, cell by cell, from the rays in the map frame.
double byHand(const CBGKMap& map, const mrpt::obs::CObservation& observation, const CPose3D& pose)
{
  const auto& options = map.likelihoodOptions;
  const auto scan = lamap::raysOf(observation, pose);
  size_t number = 0;
  double sum = 0;
  for (const auto& fan : scan->fans)
    for (const auto& ray : fan.rays)
    {
      const Eigen::Vector3d end = scan->inMap(ray.end);
      if (number++ % options.decimation != 0 || ray.meaning != lamap::RayEnd::Return || !end.allFinite())
        continue;
      const CellIndex cell = *lamap::cellAt(end, map.resolution());
      const auto own = map.estimateCell(cell);
      double prob = own ? own->prob : options.unobservedProb;
      const int reach = static_cast<int>(2.45 * options.endPointStd / map.resolution());
      for (int x = -reach; x <= reach; ++x)
        for (int y = -reach; y <= reach; ++y)
          for (int z = -reach; z <= reach; ++z)
          {
            const auto other = map.estimateCell({cell.x + x, cell.y + y, cell.z + z});
            const double squared = x * x + y * y + z * z;
            if (!other || squared == 0 || squared > reach * reach) continue;
            const double cells = options.endPointStd / map.resolution();
            prob = std::max(prob, other->prob * std::exp(-0.5 * squared / (cells * cells)));
          }
      const Eigen::Vector3d along = end - scan->inMap(fan.centre);
      const double before = std::max(options.freeBefore, 2 * map.resolution());
      if (options.freeBefore > 0 && along.norm() > before)
      {
        const Eigen::Vector3d passed = end - before * along.normalized();
        const auto there = map.estimateCell(*lamap::cellAt(passed, map.resolution()));
        prob *= 1 - (there ? there->prob : options.unobservedProb);
      }
      sum += std::log((1 - options.outlierProb) * prob + 0.5 * options.outlierProb);
    }
  return options.independence * sum;
}

TEST(Likelihood, FollowsItsFormula)
{
  CBGKMap map = roomMap();
  const auto scan = roomScan();
  const auto compare = [&](const char* what)
  {
    SCOPED_TRACE(what);
    for (const CPose3D& pose : {kRobot, CPose3D(1.7, 0.2, 0.05, -2, 0.02, 0.01), CPose3D(50, 0, 0, 0, 0, 0)})
      EXPECT_NEAR(map.computeObservationLikelihood(scan, pose), byHand(map, scan, pose), 1e-4);
  };
  compare("defaults");
  map.likelihoodOptions.endPointStd = 0;
  compare("cell only");
  map.likelihoodOptions.endPointStd = 0.15;
  compare("neighbours");
  map.likelihoodOptions.freeBefore = 0.4;
  compare("free before the end");
  map.likelihoodOptions.freeBefore = 0.01;
  compare("free two cells before the end");
  map.likelihoodOptions.outlierProb = 0.5;
  compare("outliers");
  map.likelihoodOptions.unobservedProb = 0.9;
  compare("unobserved");
  map.likelihoodOptions.independence = 0.3;
  compare("independence");
  map.insertObservation(scan, CPose3D(1.7, 0.2, 0.05, -2, 0.02, 0.01));
  compare("after the map has changed");
}

TEST(Likelihood, DecimationTakesEverySoManyth)
{
  CBGKMap map = roomMap();
  mrpt::obs::CObservationPointCloud cloud;
  auto points = mrpt::maps::CSimplePointsMap::Create();
  for (int i = 0; i < 20; ++i) points->insertPoint(3.0f, -1.0f + 0.1f * static_cast<float>(i), 0.3f);
  cloud.pointcloud = points;
  map.likelihoodOptions.decimation = 4;
  EXPECT_NEAR(map.computeObservationLikelihood(cloud, kRobot), byHand(map, cloud, kRobot), 1e-4);
}

TEST(Likelihood, IsLargestAtTheTruePose)
{
  const CBGKMap map = roomMap();
  const auto scan = roomScan();
  const double best = map.computeObservationLikelihood(scan, CPose3D());
  for (const double offset : {-0.6, -0.3, 0.3, 0.6})
  {
    EXPECT_GT(best, map.computeObservationLikelihood(scan, CPose3D(offset, 0, 0, 0, 0, 0)));
    EXPECT_GT(best, map.computeObservationLikelihood(scan, CPose3D(0, offset, 0, 0, 0, 0)));
    EXPECT_GT(best, map.computeObservationLikelihood(scan, CPose3D(0, 0, 0, offset, 0, 0)));
  }
}

// Learned walls are thick: an end inside of one is as likely as one on its surface, but for what its ray
// passed.
TEST(Likelihood, AsksForFreeSpaceBeforeTheEnd)
{
  CBGKMap map;
  for (int y = -20; y < 20; ++y)
    for (int x = 0; x < 40; ++x) map.updateVoxel(0.1 * x + 0.05, 0.1 * y + 0.05, 0.05, x >= 30);
  mrpt::obs::CObservationPointCloud cloud;
  auto points = mrpt::maps::CSimplePointsMap::Create();
  points->insertPoint(3.05f, 0.05f, 0.05f);
  cloud.pointcloud = points;
  const auto at = [&](double x)
  { return map.computeObservationLikelihood(cloud, CPose3D(x, 0, 0, 0, 0, 0)); };
  map.likelihoodOptions.freeBefore = 0;
  EXPECT_NEAR(at(0.6), at(0), 1e-6);
  map.likelihoodOptions.freeBefore = 0.4;
  EXPECT_LT(at(0.6), at(0) - 1.5 * map.likelihoodOptions.independence);
  EXPECT_LT(at(-0.6), at(0));
  EXPECT_NEAR(at(0.2), at(0), 1e-6);  // only that far before
}

TEST(Likelihood, HasAFloorForOutliers)
{
  CBGKMap map = roomMap();
  map.likelihoodOptions.decimation = 1;
  auto scan = roomScan();
  const double whole = map.computeObservationLikelihood(scan, CPose3D());
  scan.setScanRange(90, 1.0f);  // somebody stands in the room
  const double disturbed = map.computeObservationLikelihood(scan, CPose3D());
  EXPECT_LT(disturbed, whole);
  EXPECT_GT(disturbed,
            whole + map.likelihoodOptions.independence * std::log(0.5 * map.likelihoodOptions.outlierProb));
}

TEST(Likelihood, EveryOptionTakesEffect)
{
  const CBGKMap map = roomMap();
  const CPose3D partlyOutside(2.0, 0.4, 0, 0.5, 0, 0);
  const double before = map.computeObservationLikelihood(roomScan(), partlyOutside);
  int number = 0;
  for (const Option& option : map.likelihoodOptions.optionTable().options())
  {
    CBGKMap changed(map);
    (void)changed.computeObservationLikelihood(roomScan(), partlyOutside);  // fills what is kept
    setToAnother(option, changed.likelihoodOptions, number++);
    EXPECT_NE(changed.computeObservationLikelihood(roomScan(), partlyOutside), before) << option.key;
    CBGKMap::TLikelihoodOptions other = map.likelihoodOptions;
    EXPECT_TRUE(other.sameOptions(map.likelihoodOptions));
    setToAnother(option, other, number);
    EXPECT_FALSE(other.sameOptions(map.likelihoodOptions)) << option.key;
  }
}

TEST(Likelihood, ReturnsBeyondTheMapsRangeDoNotCount)
{
  CBGKMap map = roomMap();
  map.insertionOptions.maxRange = 2.5;
  auto scan = roomScan();
  const double before = map.computeObservationLikelihood(scan, kRobot);
  for (size_t i = 0; i < scan.getScanSize(); ++i)
    if (scan.getScanRange(i) > 2.5f) scan.setScanRange(i, 2.51f);
  EXPECT_EQ(map.computeObservationLikelihood(scan, kRobot), before);
  map.insertionOptions.maxRange = 0;
  EXPECT_NE(map.computeObservationLikelihood(scan, kRobot), before);
}

TEST(Likelihood, AnObservationThatChangesInPlaceIsSeen)
{
  CBGKMap map = roomMap();
  map.likelihoodOptions.decimation = 1;
  auto scan = roomScan();
  const double before = map.computeObservationLikelihood(scan, kRobot);
  const auto changed = [&](const char* what)
  {
    EXPECT_NEAR(map.computeObservationLikelihood(scan, kRobot), byHand(map, scan, kRobot), 1e-4) << what;
    EXPECT_NE(map.computeObservationLikelihood(scan, kRobot), before) << what;
    scan = roomScan();
    EXPECT_EQ(map.computeObservationLikelihood(scan, kRobot), before) << what;
  };
  scan.setScanRange(100, 1.0f);
  changed("a range");
  scan.setScanRangeValidity(179, false);
  scan.setScanRange(179, 0);
  changed("a validity");
  scan.sensorPose.x(0.5);
  changed("the sensor's pose");
  scan.rightToLeft = false;
  scan.sensorPose.y(0.2);
  changed("the direction");
  scan.aperture *= 0.9f;
  changed("the aperture");
  scan.deltaPitch = 0.4;
  changed("the pitch");
  scan.maxRange = 2.5f;
  changed("the range");
}

TEST(Likelihood, TakesEveryKindOfSupportedObservation)
{
  const CBGKMap map = roomMap();
  mrpt::obs::CObservationRange range;
  range.maxSensorDistance = 10;
  range.sensedData.emplace_back();
  range.sensedData[0].sensedDistance = 3.0f;
  range.sensedData[0].sensorPose = mrpt::math::TPose3D(0.1, 0, 0.3, 0, 0, 0);
  EXPECT_TRUE(map.canComputeObservationLikelihood(range));
  EXPECT_NEAR(map.computeObservationLikelihood(range, kRobot), byHand(map, range, kRobot), 1e-5);

  mrpt::obs::CObservation3DRangeScan depth;
  depth.hasPoints3D = true;
  depth.points3D_x = {3.0f, 2.9f};
  depth.points3D_y = {0.0f, 0.4f};
  depth.points3D_z = {0.3f, 0.3f};
  const double before = map.computeObservationLikelihood(depth, kRobot);
  EXPECT_NEAR(before, byHand(map, depth, kRobot), 1e-5);
  depth.points3D_y = {1.0f, 1.4f};
  EXPECT_NEAR(map.computeObservationLikelihood(depth, kRobot), byHand(map, depth, kRobot), 1e-5);
}

TEST(Likelihood, OfASensoryFrameIsTheSum)
{
  CBGKMap map = roomMap();
  mrpt::obs::CSensoryFrame frame;
  frame.insert(std::make_shared<mrpt::obs::CObservation2DRangeScan>(roomScan()));
  frame.insert(std::make_shared<mrpt::obs::CObservation2DRangeScan>(roomScan(91)));
  EXPECT_NEAR(map.computeObservationsLikelihood(frame, kRobot),
              map.computeObservationLikelihood(roomScan(), kRobot) +
                  map.computeObservationLikelihood(roomScan(91), kRobot),
              1e-9);
}

TEST(Likelihood, CleaningUpForgetsOnlyWhatIsKept)
{
  CBGKMap map = roomMap();
  const auto bytes = bytesOf(map);
  const double before = map.computeObservationLikelihood(roomScan(), kRobot);
  map.auxParticleFilterCleanUp();
  EXPECT_EQ(map.computeObservationLikelihood(roomScan(), kRobot), before);
  EXPECT_EQ(bytesOf(map), bytes);
}

TEST(Likelihood, APlanarMapIgnoresTheHeight)
{
  CBGKMap::TCreationOptions options;
  options.planar = true;
  CBGKMap map(options);
  map.likelihoodOptions.endPointStd = 0.2;
  map.insertObservation(roomScan());
  EXPECT_NEAR(map.computeObservationLikelihood(roomScan(), CPose3D(0, 0, 9, 0, 0, 0)),
              map.computeObservationLikelihood(roomScan(), CPose3D()), 1e-9);
}

}  // namespace
