// What wide beams mean, for all four maps: a ping is free inside of its cone, and an echo came from its cap.
#include <gtest/gtest.h>
#include <lamap_mrpt/compat/mrpt_compat.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationRange.h>

#include <cmath>

#include "law_maps.h"

namespace lamap::test
{
namespace
{
constexpr double kDegree = M_PI / 180;
constexpr double kRange_m = 2.52;
constexpr float kRangeMax_m = 6;

const Settings kCones = {{"insertOpts.beamWidth", "observation"}};
const Settings kLines = {{"insertOpts.beamWidth", "none"}};

/// A ping straight ahead, as sonars with several echoes are written.
mrpt::obs::CObservation2DRangeScan pingOf(double range_m, double aperture_deg, int echo = 1)
{
  mrpt::obs::CObservation2DRangeScan ping;
  ping.sensorLabel = "SONAR/echo" + std::to_string(echo);
  ping.aperture = 0;
  ping.beamAperture = static_cast<float>(aperture_deg * kDegree);
  ping.maxRange = kRangeMax_m;
  ping.resizeScan(1);
  ping.setScanRange(0, static_cast<float>(range_m));
  ping.setScanRangeValidity(0, range_m < ping.maxRange);
  return ping;
}

mrpt::obs::CObservationRange rangeOf(double range_m, double aperture_deg)
{
  mrpt::obs::CObservationRange ranges;
  ranges.maxSensorDistance = kRangeMax_m;
  compat::setConeAperture(ranges, aperture_deg * kDegree);
  auto& measurement = ranges.sensedData.emplace_back();
  measurement.sensedDistance = static_cast<float>(range_m);
  return ranges;
}

template <typename Map, typename Observation>
Map mapWith(const Settings& settings, const std::vector<Observation>& observations, unsigned threads = 1)
{
  Map map = made<Map>(settings);
  map.setThreadCount(threads);
  for (const Observation& observation : observations) map.insertObservation(observation);
  return map;
}

/// P(occupied) where a beam at this angle from the axis is at a range; 0.5 where the map knows nothing.
template <typename Map>
double probAt(const Map& map, double range_m, double angle_deg, bool upwards = false)
{
  const Eigen::Vector3d place = range_m * (upwards ? towards(0, angle_deg) : towards(angle_deg));
  const auto found = map.estimateAt({place.x(), place.y(), place.z()});
  return found ? found->prob : 0.5;
}

template <typename Map>
class ConeLaws : public testing::Test
{
};
TYPED_TEST_SUITE(ConeLaws, AllMaps);

template <typename Map>
void expectFreeInsideAndPerhapsOccupiedAtTheCap(const Map& map)
{
  for (const bool upwards : {false, true})
    for (const double angle_deg : {-8.0, -4.0, 0.0, 4.0, 8.0})
    {
      SCOPED_TRACE(angle_deg);
      EXPECT_LT(probAt(map, 1.5, angle_deg, upwards), 0.4);
      EXPECT_GT(probAt(map, kRange_m, angle_deg, upwards), 0.3) << "not called free";
      EXPECT_GE(probAt(map, kRange_m + 0.8, angle_deg, upwards), 0.5);
    }
  EXPECT_GE(probAt(map, 1.5, 35), 0.5) << "beside the cone";
}

TYPED_TEST(ConeLaws, APingIsFreeInItsConeButNotAtItsCap)
{
  expectFreeInsideAndPerhapsOccupiedAtTheCap(mapWith<TypeParam>(kCones, std::vector{pingOf(kRange_m, 20)}));
  expectFreeInsideAndPerhapsOccupiedAtTheCap(mapWith<TypeParam>(kCones, std::vector{rangeOf(kRange_m, 20)}));
}

TYPED_TEST(ConeLaws, ALaterEchoFreesNothing)
{
  const TypeParam map = mapWith<TypeParam>(kCones, std::vector{pingOf(kRange_m, 20, 2)});
  ASSERT_FALSE(map.isEmpty());
  map.visitCells([](const CellIndex&, const CellEstimate& cell) { ASSERT_GE(cell.prob, 0.5); });
  const TypeParam line = mapWith<TypeParam>(kCones, std::vector{pingOf(kRange_m, 0, 2)});
  EXPECT_GT(probAt(line, kRange_m, 0), 0.5);
  EXPECT_GE(probAt(line, 1.5, 0), 0.5);
}

TYPED_TEST(ConeLaws, AnApertureThatTendsToZeroGivesThePlainMap)
{
  const auto plain = mapWith<TypeParam>(kLines, std::vector{pingOf(kRange_m, 0), pingOf(3.1, 0)});
  for (const double aperture_deg : {0.0, 1e-6, 0.1, 1.0, -4.0, std::nan(""), 180.0, 270.0})
  {
    SCOPED_TRACE(aperture_deg);
    const auto narrow =
        mapWith<TypeParam>(kCones, std::vector{pingOf(kRange_m, aperture_deg), pingOf(3.1, aperture_deg)});
    EXPECT_TRUE(cellsOf(narrow) == cellsOf(plain));
  }
}

TYPED_TEST(ConeLaws, WithoutBeamWidthAnApertureMeansNothing)
{
  EXPECT_EQ(bytesOf(mapWith<TypeParam>(kLines, std::vector{pingOf(kRange_m, 20, 2)})),
            bytesOf(mapWith<TypeParam>(kLines, std::vector{pingOf(kRange_m, 0)})));
}

TYPED_TEST(ConeLaws, TheNumberOfThreadsDoesNotMatter)
{
  const std::vector pings{pingOf(kRange_m, 20), pingOf(4, 30), pingOf(kRangeMax_m, 25), pingOf(5, 30, 2)};
  EXPECT_EQ(bytesOf(mapWith<TypeParam>(kCones, pings, 4)), bytesOf(mapWith<TypeParam>(kCones, pings, 1)));
}

TYPED_TEST(ConeLaws, APlanarMapHasTheConeInItsPlane)
{
  Settings settings = kCones;
  settings.emplace_back("creationOpts.planar", "true");
  const TypeParam map = mapWith<TypeParam>(settings, std::vector{pingOf(kRange_m, 20)});
  for (const double angle_deg : {-8.0, 0.0, 8.0})
  {
    EXPECT_LT(probAt(map, 1.5, angle_deg), 0.4);
    EXPECT_GT(probAt(map, kRange_m, angle_deg), 0.3);
  }
  EXPECT_GE(probAt(map, 1.5, 35), 0.5);
}

TYPED_TEST(ConeLaws, AMapOfPingsIsReadBackFromItsFile)
{
  const TypeParam map = mapWith<TypeParam>(kCones, std::vector{pingOf(kRange_m, 20), pingOf(4, 30)});
  const auto bytes = bytesOf(map);
  EXPECT_EQ(bytesOf(*objectFrom(bytes)), bytes);
}

TEST(OverlappingCones, PingsThatWaitForOthersAreReadBackAsTheyWere)
{
  Settings settings = kCones;
  settings.emplace_back("insertOpts.scansPerModel", "4");
  auto map = mapWith<COverlappingHilbertMap>(
      settings, std::vector{pingOf(kRange_m, 20), pingOf(4, 30, 2), pingOf(kRangeMax_m, 25)});
  const auto again = std::dynamic_pointer_cast<COverlappingHilbertMap>(objectFrom(bytesOf(map)));
  ASSERT_EQ(bytesOf(*again), bytesOf(map));
  map.insertObservation(pingOf(3, 20));
  again->insertObservation(pingOf(3, 20));
  ASSERT_EQ(map.modelCount(), 1U);
  EXPECT_EQ(bytesOf(*again), bytesOf(map));
}

}  // namespace
}  // namespace lamap::test
