#include <gtest/gtest.h>
#include <lamap_core/scan/open_space.h>
#include <lamap_core/scan/ray_selection.h>
#include <support/seeded_scans.h>
#include <support/seeds.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace lamap::test
{
namespace
{
constexpr double kInf = std::numeric_limits<double>::infinity();

/// Readings of a laser, a degree apart from the first angle on; 0: no return.
RayFan laser(double first_deg, const std::vector<double>& ranges_m)
{
  RayFan fan;
  for (size_t i = 0; i < ranges_m.size(); ++i)
  {
    const Eigen::Vector3d direction = towards(first_deg + static_cast<double>(i));
    if (ranges_m[i] > 0)
      fan.addReturn(ranges_m[i] * direction);
    else
      fan.add(RayEnd::NoReturn, direction);
  }
  return fan;
}

float reachOf(OpenSpace space, double azimuth_deg, double elevation_deg = 0)
{
  return static_cast<float>(space.reach_m(towards(azimuth_deg, elevation_deg)));
}

float reachAt(const RayFan& fan, double azimuth_deg, double elevation_deg = 0)
{
  return reachOf(OpenSpace(fan, 0), azimuth_deg, elevation_deg);
}

TEST(OpenSpace, ReachesTheNearerOfTheReturnsThatBoundARun)
{
  const RayFan fan = laser(0, {5, 0, 0, 0, 3, 0, 7});
  for (const double azimuth : {1.0, 2.0, 3.0}) EXPECT_FLOAT_EQ(reachAt(fan, azimuth), 3) << azimuth;
  EXPECT_FLOAT_EQ(reachAt(fan, 5), 3);
}

TEST(OpenSpace, IsUnboundedWithoutAnyReturn)
{
  EXPECT_EQ(reachAt(laser(0, {0, 0, 0}), 1), kInf);
}

TEST(OpenSpace, EndsARunAtTheEdgeOfTheFieldOfView)
{
  // 180 degrees: behind the sensor nothing is asked, so the far side bounds nothing.
  std::vector<double> ranges_m(181, 0);
  ranges_m[100] = 6;
  ranges_m[180] = 1;
  EXPECT_FLOAT_EQ(reachAt(laser(-90, ranges_m), -90), 6);
  EXPECT_FLOAT_EQ(reachAt(laser(-90, ranges_m), 89), 1);
}

TEST(OpenSpace, GoesRoundAFullTurn)
{
  std::vector<double> ranges_m(360, 0);
  ranges_m[10] = 6;
  ranges_m[200] = 2;
  const RayFan fan = laser(-180, ranges_m);
  EXPECT_FLOAT_EQ(reachAt(fan, 179), 2);
  EXPECT_FLOAT_EQ(reachAt(fan, -179), 2);
}

TEST(OpenSpace, IsBoundedFromAboveAndBelowToo)
{
  RayFan fan;
  for (int azimuth = 0; azimuth < 360; ++azimuth)
  {
    fan.addReturn(4 * towards(azimuth, -10));
    fan.add(RayEnd::NoReturn, towards(azimuth, 0));
    fan.add(RayEnd::NoReturn, towards(azimuth, 10));
  }
  fan.addReturn(2.5 * towards(50, 20));
  EXPECT_FLOAT_EQ(reachAt(fan, 120, 10), 4);
  EXPECT_FLOAT_EQ(reachAt(fan, 50, 10), 2.5);
}

TEST(OpenSpace, LooksBesideAColumnAndARowWithoutReturns)
{
  RayFan fan;
  for (int azimuth = 0; azimuth < 40; ++azimuth) fan.add(RayEnd::NoReturn, towards(azimuth, 5));
  fan.addReturn(8 * towards(39, 0));
  EXPECT_FLOAT_EQ(reachAt(fan, 10, 5), 8);
}

TEST(OpenSpace, IgnoresReturnsOfTheRobotsOwnBody)
{
  RayFan fan = laser(0, {0.2, 0, 5});
  EXPECT_FLOAT_EQ(reachOf(OpenSpace(fan, 0.3), 1), 5);
  EXPECT_FLOAT_EQ(reachOf(OpenSpace(fan, 0.1), 1), 0.2F);
}

TEST(OpenSpace, PassesReadingsOfWhichNothingIsKnown)
{
  RayFan fan = laser(0, {0, 0, 0, 4});
  fan.rays[1].meaning = RayEnd::Dropped;
  fan.addReturn(9 * towards(-1));
  EXPECT_FLOAT_EQ(reachAt(fan, 0), 4);
}

TEST(OpenSpace, IsFreeBetweenRaysAsFarAsTheNearerOfThem)
{
  // Two rings of a lidar on a floor: between them a place is free as far as the lower one.
  std::vector<Eigen::Vector3d> ends;
  for (int azimuth = 0; azimuth < 360; azimuth += 2)
  {
    ends.push_back(4 * towards(azimuth, -15));
    ends.push_back(6 * towards(azimuth, -10));
  }
  const OpenSpace space = OpenSpace::between(ends);
  EXPECT_TRUE(space.reaches({0, 0, 0}));  // the sensor itself
  EXPECT_TRUE(space.reaches(3.9 * towards(40, -12)));
  EXPECT_FALSE(space.reaches(4.1 * towards(40, -12)));
  EXPECT_TRUE(space.reaches(5.9 * towards(40, -10)));
  EXPECT_FALSE(space.reaches(6.1 * towards(41, -10)));
  EXPECT_TRUE(space.reaches(3.9 * towards(41, -17)));  // below all rings
  EXPECT_FALSE(space.reaches(4.1 * towards(41, -17)));
  EXPECT_FALSE(OpenSpace::between({}).reaches({1, 0, 0}));
}

TEST(OpenSpaceProperty, AgreesWithTheRunsOfALaserWhateverTheOrderOfItsRays)
{
  for (unsigned seed = 1; seed <= seeds(20); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    std::vector<double> ranges_m(180);
    for (double& range_m : ranges_m) range_m = random.uniform(0, 1) < 0.6 ? 0 : random.uniform(1, 9);
    ranges_m.front() = 3;
    ranges_m.back() = 4;
    RayFan fan = laser(-90, ranges_m);
    random.shuffle(fan.rays);
    const OpenSpace space(fan, 0);
    for (size_t i = 0; i < ranges_m.size(); ++i)
    {
      if (ranges_m[i] > 0) continue;
      size_t left = i;
      size_t right = i;
      while (ranges_m[left] == 0) --left;
      while (ranges_m[right] == 0) ++right;
      EXPECT_FLOAT_EQ(reachOf(space, -90 + static_cast<double>(i)),
                      static_cast<float>(std::min(ranges_m[left], ranges_m[right])))
          << i;
    }
  }
}

TEST(RaySelection, EndsARayWithoutReturnAtTheReturnsThatBoundIt)
{
  RangeOptions limits;
  limits.maxRange = 30;
  const SelectedRays rays = selectRays(scanWith({laser(0, {5, 0, 0, 3})}), limits);
  ASSERT_EQ(rays.counts.noReturn, 2u);
  EXPECT_NEAR(rays.scan.fans[0].rays[1].end.norm(), 3, 1e-6);
  EXPECT_NEAR(rays.counts.noReturnLength_m, 6, 1e-5);
  EXPECT_NEAR(rays.counts.noReturnLongest_m, 3, 1e-6);
}

}  // namespace
}  // namespace lamap::test
