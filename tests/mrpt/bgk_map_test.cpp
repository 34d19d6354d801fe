#include <gtest/gtest.h>
#include <lamap_mrpt/maps/CBGKMap.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>
#include <mrpt/system/CObserver.h>

#include <limits>
#include <random>

#include <support/small_maps.h>

namespace
{
using lamap::CBGKMap;
using lamap::CellIndex;
using lamap::CellState;
using namespace lamap::test;
using mrpt::math::TPoint3D;
using mrpt::poses::CPose3D;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// ---- Insertion

TEST(BgkMrptMap, AnObservationIsInsertedAtThePoseOfTheRobot)
{
  CBGKMap map;
  ASSERT_TRUE(map.insertObservation(roomScan(), CPose3D(5, -2, 0.4, M_PI / 2, 0, 0)));
  // Straight ahead of the sensor, which stands 0.1 m before the robot, the wall is at 3.05 m.
  const auto wall = map.estimateAt({5, -2 + 0.1 + 3.05, 0.7});
  ASSERT_TRUE(wall);
  EXPECT_EQ(wall->state, CellState::Occupied);
  const auto middle = map.estimateAt({5, -2 + 1.5, 0.7});
  ASSERT_TRUE(middle);
  EXPECT_EQ(middle->state, CellState::Free);
  EXPECT_FALSE(map.estimateAt({5, -2 + 1.5, 1.7}));
}

TEST(BgkMrptMap, WithoutAPoseTheRobotIsAtTheOrigin)
{
  CBGKMap here;
  CBGKMap there;
  here.insertObservation(roomScan());
  there.insertObservation(roomScan(), CPose3D());
  EXPECT_EQ(bytesOf(here), bytesOf(there));
}

TEST(BgkMrptMap, AnUnsupportedObservationIsRefusedAndHasNoLikelihood)
{
  CBGKMap map;
  map.insertScan(smallScan());
  const auto before = bytesOf(map);
  const mrpt::obs::CObservationImage image;
  EXPECT_FALSE(map.insertObservation(image));
  EXPECT_FALSE(map.canComputeObservationLikelihood(image));
  EXPECT_EQ(map.computeObservationLikelihood(image, CPose3D()), 0.0);
  EXPECT_EQ(bytesOf(map), before);
}

TEST(BgkMrptMap, AnObservationThatContradictsItselfIsLeftOutAndCounted)
{
  CBGKMap map;
  map.setMinLoggingLevel(mrpt::system::LVL_ERROR);
  mrpt::obs::CObservationPointCloud cloud;
  cloud.setAsExternalStorage("/no/such/file.bin",
                             mrpt::obs::CObservationPointCloud::ExternalStorageFormat::MRPT_Serialization);
  EXPECT_FALSE(map.insertObservation(cloud));
  EXPECT_EQ(map.computeObservationLikelihood(cloud, CPose3D()), 0.0);
  EXPECT_NE(map.asString().find("observations that could not be read or learned 1"), std::string::npos)
      << map.asString();
}

TEST(BgkMrptMap, GenericParametersAreHonoured)
{
  CBGKMap map;
  map.genericMapParams.enableObservationInsertion = false;
  EXPECT_FALSE(map.insertObservation(roomScan()));
  EXPECT_TRUE(map.isEmpty());
  map.genericMapParams.enableObservationInsertion = true;
  EXPECT_TRUE(map.insertObservation(roomScan()));
  EXPECT_TRUE(map.canComputeObservationLikelihood(roomScan()));
  map.genericMapParams.enableObservationLikelihood = false;
  EXPECT_FALSE(map.canComputeObservationLikelihood(roomScan()));
  EXPECT_EQ(map.computeObservationLikelihood(roomScan(), CPose3D()), 0.0);
}

TEST(BgkMrptMap, LoadsASimpleMap)
{
  mrpt::maps::CSimpleMap simpleMap;
  mrpt::obs::CSensoryFrame frame;
  frame.insert(std::make_shared<mrpt::obs::CObservation2DRangeScan>(roomScan()));
  simpleMap.insert(mrpt::poses::CPose3DPDFGaussian::Create(CPose3D(1, 2, 0, 0.3, 0, 0)),
                   mrpt::obs::CSensoryFrame::Create(frame));
  CBGKMap map;
  map.insertScan(smallScan());
  map.loadFromSimpleMap(simpleMap);
  CBGKMap expected;
  expected.insertObservation(roomScan(), CPose3D(1, 2, 0, 0.3, 0, 0));
  EXPECT_EQ(bytesOf(map), bytesOf(expected));
}

class EventCounter : public mrpt::system::CObserver
{
 public:
  int inserted = 0;
  int cleared = 0;

 private:
  void OnEvent(const mrpt::system::mrptEvent& event) override
  {
    if (event.isOfType<mrpt::maps::mrptEventMetricMapInsert>()) ++inserted;
    if (event.isOfType<mrpt::maps::mrptEventMetricMapClear>()) ++cleared;
  }
};

TEST(BgkMrptMap, TellsObserversOfInsertionAndClearing)
{
  CBGKMap map;
  EventCounter counter;
  counter.observeBegin(map);
  map.insertObservation(roomScan());
  map.insertObservation(mrpt::obs::CObservationImage());
  map.clear();
  EXPECT_EQ(counter.inserted, 1);
  EXPECT_EQ(counter.cleared, 1);
  {
    CBGKMap copy(map);
    copy.insertObservation(roomScan());
  }
  EXPECT_EQ(counter.inserted, 1) << "a copy has the other map's observers";
}

TEST(BgkMrptMap, ClearForgetsEvidenceAndKeepsOptions)
{
  CBGKMap map(0.2);
  map.insertionOptions.kernelScale = 3;
  const auto untouched = bytesOf(map);
  map.insertObservation(roomScan());
  EXPECT_FALSE(map.isEmpty());
  EXPECT_NE(map.boundingBox().max.x, 0);
  map.clear();
  EXPECT_TRUE(map.isEmpty());
  EXPECT_EQ(bytesOf(map), untouched);
  EXPECT_EQ(map.boundingBox().max.x, 0);
}

TEST(BgkMrptMap, RaysLeftOutAreCountedAndToldOnce)
{
  CBGKMap map;
  map.logging_enable_console_output = false;
  map.logging_enable_keep_record = true;
  const double infinity = std::numeric_limits<double>::infinity();
  lamap::Scan scan;
  scan.fans.emplace_back();
  for (const double x : {1.0, static_cast<double>(kNaN), infinity, 1e300}) scan.fans[0].addReturn({x, 0, 0});
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(map.insertScan(scan));
  const auto facts = map.facts();
  const auto factOf = [&](const std::string& name)
  {
    for (const auto& fact : facts)
      if (fact.name == name) return fact.text();
    return std::string("absent");
  };
  EXPECT_EQ(factOf("rays with a hit"), "5");
  EXPECT_EQ(factOf("rays left out"), "15");
  EXPECT_EQ(factOf("rays left out, not finite"), "10");
  EXPECT_EQ(factOf("scans inserted in this session"), "5");
  const std::string log = map.getLogAsString();
  size_t told = 0;
  for (size_t at = log.find("NaN"); at != std::string::npos; at = log.find("NaN", at + 1)) ++told;
  EXPECT_EQ(told, 1u) << log;
  lamap::Scan hopeless;
  hopeless.fans.emplace_back().addReturn({kNaN, 0, 0});
  EXPECT_FALSE(map.insertScan(hopeless));
}

TEST(BgkMrptMap, IllegalInsertionOptionsAreRefusedByName)
{
  CBGKMap map;
  map.insertionOptions.kernelScale = -1;
  try
  {
    map.insertScan(smallScan());
    FAIL() << "taken";
  }
  catch (const std::invalid_argument& error)
  {
    EXPECT_NE(std::string(error.what()).find("kernelScale"), std::string::npos) << error.what();
  }
  EXPECT_TRUE(map.isEmpty());
  EXPECT_THROW(CBGKMap(0.0), std::invalid_argument);
  EXPECT_THROW(CBGKMap{kNaN}, std::invalid_argument);
}

TEST(BgkMrptMap, MergingEqualsInsertingThere)
{
  CBGKMap both;
  both.insertScan(smallScan());
  both.insertObservation(roomScan(), CPose3D(1, 1, 0, 0.5, 0, 0));
  CBGKMap one;
  one.insertScan(smallScan());
  CBGKMap other;
  other.insertObservation(roomScan(), CPose3D(1, 1, 0, 0.5, 0, 0));
  ASSERT_NE(one.getAsSimplePointsMap()->size(), both.getAsSimplePointsMap()->size());
  one.merge(other);
  EXPECT_EQ(bytesOf(one), bytesOf(both));
  EXPECT_EQ(one.getAsSimplePointsMap()->size(), both.getAsSimplePointsMap()->size());
  EXPECT_THROW(one.merge(CBGKMap(0.2)), std::invalid_argument);
}

// ---- As COctoMap

TEST(BgkMrptMap, AnUpdatedVoxelTakesOneHitOrOneFreePoint)
{
  CBGKMap map;
  map.insertionOptions.kernelScale = 2.5;
  map.insertionOptions.freeWeight = 0.25;
  map.updateVoxel(1.23, -0.01, 0.55, true);
  map.updateVoxel(1.23, -0.01, 0.55, true);
  map.updateVoxel(1.23, -0.01, 0.55, false);
  const auto cell = map.estimateCell({12, -1, 5});
  ASSERT_TRUE(cell);
  EXPECT_NEAR(cell->evidence[0], 0.003 + 5.0, 1e-6);
  EXPECT_NEAR(cell->evidence[1], 0.003 + 0.625, 1e-6);
  EXPECT_FALSE(map.estimateCell({13, -1, 5}));
  EXPECT_THROW(map.updateVoxel(kNaN, 0, 0, true), std::invalid_argument);
  EXPECT_THROW(map.updateVoxel(1e300, 0, 0, true), std::invalid_argument);
}

TEST(BgkMrptMap, PointOccupancyIsThatOfTheCell)
{
  CBGKMap map;
  map.updateVoxel(1.05, 0.05, 0.05, true);
  double prob = -1;
  EXPECT_TRUE(map.getPointOccupancy(1.01f, 0.09f, 0.02f, prob));
  EXPECT_NEAR(prob, (0.003 + 1.0) / (0.006 + 1.0), 1e-6);
  prob = -1;
  EXPECT_FALSE(map.getPointOccupancy(1.11f, 0.09f, 0.02f, prob));
  EXPECT_EQ(prob, -1);
}

TEST(BgkMrptMap, ARayAndAPointCloudAreScans)
{
  mrpt::maps::CSimplePointsMap points;
  points.insertPoint(1.0f, 0.5f, 0.25f);
  points.insertPoint(2.0f, -0.5f, 0.75f);
  CBGKMap cloud;
  cloud.insertPointCloud(points, 0.5f, 0.25f, 0.125f);
  lamap::Scan scan;
  lamap::RayFan& fan = scan.fans.emplace_back();
  fan.centre = {0.5, 0.25, 0.125};
  fan.addReturn({1, 0.5, 0.25});
  fan.addReturn({2, -0.5, 0.75});
  CBGKMap byScan;
  byScan.insertScan(scan);
  EXPECT_EQ(bytesOf(cloud), bytesOf(byScan));

  CBGKMap ray;
  ray.insertRay(1.0f, 0.5f, 0.25f, 0.5f, 0.25f, 0.125f);
  fan.rays.resize(1);
  CBGKMap one;
  one.insertScan(scan);
  EXPECT_EQ(bytesOf(ray), bytesOf(one));
}

TEST(BgkMrptMap, APlanarMapTakesAnyHeight)
{
  CBGKMap::TCreationOptions options;
  options.planar = true;
  options.planarHeight = 0.5;
  CBGKMap map(options);
  map.insertObservation(roomScan(), CPose3D(0, 0, 7, 0, 0, 0));
  map.visitCells([](const CellIndex& cell, const lamap::CellEstimate&) { ASSERT_EQ(cell.z, 5); });
  const auto low = map.estimateAt({3.15, 0, -100});
  const auto high = map.estimateAt({3.15, 0, 100});
  ASSERT_TRUE(low && high);
  EXPECT_EQ(low->prob, high->prob);
  TPoint3D end;
  EXPECT_TRUE(map.castRay({0.5, 0, 42}, {1, 0, 3}, end));
  EXPECT_NEAR(end.x, 3.15, 0.101);
  EXPECT_NEAR(end.z, 0.55, 1e-12);
  EXPECT_FALSE(map.castRay({0.5, 0, 42}, {0, 0, 1}, end))
      << "straight up there is only the free cell of the origin";
  EXPECT_TRUE(map.castRay({end.x + 0, 0, 42}, {1, 0, 0}, end));
}

/// Walks in steps far smaller than a cell.
bool castBySmallSteps(const CBGKMap& map, const TPoint3D& origin, const TPoint3D& direction, TPoint3D& end,
                      bool ignoreUnknown, double maxRange)
{
  const TPoint3D unit = direction * (1 / direction.norm());
  for (double t = 0; t <= maxRange; t += 1e-4)
  {
    const TPoint3D point = origin + unit * t;
    const auto estimate = map.estimateAt(point);
    const CellState state = estimate ? estimate->state : CellState::Unknown;
    const auto cell = lamap::cellAt({point.x, point.y, point.z}, map.resolution());
    const auto centre = lamap::cellCentre(*cell, map.resolution());
    end = {centre.x(), centre.y(), centre.z()};
    if (state == CellState::Occupied) return true;
    if (!estimate && !ignoreUnknown) return false;
  }
  return false;
}

TEST(BgkMrptMap, RayCastingFindsWhatSmallStepsFind)
{
  CBGKMap map;
  std::mt19937 generator(7);
  std::uniform_real_distribution<double> coordinate(-1.5, 1.5);
  for (int i = 0; i < 20 * 20 * 20; ++i)
  {
    const double chance = coordinate(generator);
    if (chance > -1.0)  // the rest stays unobserved
      map.updateVoxel(-0.95 + 0.1 * (i % 20), -0.95 + 0.1 * (i / 20 % 20), -0.95 + 0.1 * (i / 400),
                      chance > 1.3);
  }
  int hits = 0;
  int cornersCut = 0;
  for (int i = 0; i < 300; ++i)
  {
    SCOPED_TRACE(i);
    const TPoint3D origin(0.5 * coordinate(generator), 0.07, 0.5 * coordinate(generator));
    const TPoint3D direction(coordinate(generator), coordinate(generator), coordinate(generator));
    const bool ignoreUnknown = i % 2 == 0;
    const double maxRange = i % 3 == 0 ? 1.0 : 4.0;
    TPoint3D end;
    TPoint3D expectedEnd;
    const bool hit = map.castRay(origin, direction, end, ignoreUnknown, maxRange);
    const bool expected = castBySmallSteps(map, origin, direction, expectedEnd, ignoreUnknown, maxRange);
    // Steps may jump over the corner of a cell.
    if (hit == expected && (!hit || (end - expectedEnd).norm() < 1e-9))
      hits += hit;
    else
      ++cornersCut;
  }
  EXPECT_GT(hits, 60);
  EXPECT_LE(cornersCut, 2);
}

TEST(BgkMrptMap, RayCastingEndsWithoutARange)
{
  CBGKMap map;
  TPoint3D end;
  EXPECT_FALSE(map.castRay({0, 0, 0}, {1, 0, 0}, end, true)) << "an empty map";
  map.updateVoxel(1000.05, 0.05, 0.05, true);
  EXPECT_TRUE(map.castRay({0, 0.05, 0.05}, {0.3, 0, 0}, end, true));
  EXPECT_NEAR(end.x, 1000.05, 1e-9);
  EXPECT_FALSE(map.castRay({0, 0.05, 0.05}, {-0.3, 0, 0}, end, true));
  EXPECT_FALSE(map.castRay({0, 5, 0.05}, {1, 0, 0}, end, true));
  EXPECT_FALSE(map.castRay({0, 0.05, 0.05}, {1, 0, 0}, end, true, 999.0));
  EXPECT_FALSE(map.castRay({0, 0.05, 0.05}, {1, 0, 0}, end, false)) << "unknown space ends the ray";
  EXPECT_TRUE(map.castRay({1000.05, 0.05, 0.05}, {-1, 0, 0}, end)) << "the origin's own cell counts";
  EXPECT_FALSE(map.castRay({0, 0, 0}, {0, 0, 0}, end, true));
  EXPECT_FALSE(map.castRay({0, kNaN, 0}, {1, 0, 0}, end, true));
  EXPECT_TRUE(map.castRay({1e6, 0.05, 0.05}, {-1, 0, 0}, end, true)) << "from far away";
  EXPECT_NEAR(end.x, 1000.05, 1e-9);
}

// ---- Summaries

TEST(BgkMrptMap, SumsUpWhatItHolds)
{
  CBGKMap map;
  for (int i = 0; i < 3; ++i) map.updateVoxel(0.05 + 0.1 * i, 0.05, 0.05, i == 0);
  const std::string text = map.asString();
  for (const std::string part :
       {"lamap::CBGKMap: ", "resolution 0.1 m", "; cells 3", "occupied cells 1", "free cells 2", "blocks 1",
        "evidence for occupied 1 ", "evidence for free 1 "})
    EXPECT_NE(text.find(part), std::string::npos) << part << " in " << text;
}

TEST(BgkMrptMap, TheBoundingBoxHoldsAllObservedCells)
{
  CBGKMap map;
  map.updateVoxel(-0.95, 0.05, 0.25, false);
  map.updateVoxel(2.05, -1.05, 0.25, true);
  const auto box = map.boundingBox();
  EXPECT_NEAR(box.min.x, -1.0, 1e-6);
  EXPECT_NEAR(box.min.y, -1.1, 1e-6);
  EXPECT_NEAR(box.min.z, 0.2, 1e-6);
  EXPECT_NEAR(box.max.x, 2.1, 1e-6);
  EXPECT_NEAR(box.max.y, 0.1, 1e-6);
  EXPECT_NEAR(box.max.z, 0.3, 1e-6);
}

}  // namespace
