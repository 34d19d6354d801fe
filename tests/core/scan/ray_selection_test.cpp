#include <gtest/gtest.h>
#include <lamap_core/scan/ray_selection.h>
#include <support/seeded_scans.h>
#include <support/seeds.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace lamap::test
{
namespace
{
const double kNan = std::numeric_limits<double>::quiet_NaN();
const double kInf = std::numeric_limits<double>::infinity();

SelectedRays selected(const std::vector<RayFan>& fans, const RangeOptions& limits = {})
{
  return selectRays(scanWith(fans), limits);
}

/// The free parts of a fan's rays, whatever ended them.
std::vector<Eigen::Vector3d> freeRaysOf(const RayFan& fan)
{
  std::vector<Eigen::Vector3d> rays;
  for (const Ray& ray : fan.rays)
    if (ray.meaning != RayEnd::Return) rays.push_back(ray.end);
  return rays;
}

size_t sumOf(const RayCounts& c)
{
  return c.hits + c.freeOnly + c.decimated + c.dropped + c.notFinite + c.tooNear + c.unbounded + c.tooLong +
         c.outside;
}

TEST(RaySelection, KeepsHitsAsTheyAre)
{
  const SelectedRays rays = selected({fanOf({1, 2, 3}, {{4, 2, 3}, {1, -7, 3}})}, {});
  ASSERT_EQ(rays.scan.fans.size(), 1u);
  EXPECT_EQ(rays.scan.fans[0].centre, Eigen::Vector3d(1, 2, 3));
  ASSERT_EQ(endsOf(rays.scan.fans[0]).size(), 2u);
  EXPECT_EQ(endsOf(rays.scan.fans[0])[0], Eigen::Vector3d(4, 2, 3));
  EXPECT_EQ(endsOf(rays.scan.fans[0])[1], Eigen::Vector3d(1, -7, 3));
  EXPECT_TRUE(freeRaysOf(rays.scan.fans[0]).empty());
  EXPECT_EQ(rays.counts.hits, 2u);
  EXPECT_EQ(rays.counts.used(), 2u);
  EXPECT_EQ(rays.counts.leftOut(), 0u);
}

TEST(RaySelection, CutsRaysAtTheMaximumRangeAndTakesTheirHit)
{
  RangeOptions limits;
  limits.maxRange = 5;
  const SelectedRays rays = selected({fanOf({1, 1, 1}, {{1, 1, 6}, {1, 1, 6.5}, {7, 9, 1}})}, limits);
  ASSERT_EQ(endsOf(rays.scan.fans[0]).size(), 1u);  // at exactly the maximum range is a hit
  ASSERT_EQ(freeRaysOf(rays.scan.fans[0]).size(), 2u);
  EXPECT_NEAR((freeRaysOf(rays.scan.fans[0])[0] - Eigen::Vector3d(0, 0, 5)).norm(), 0, 1e-12);
  EXPECT_NEAR((freeRaysOf(rays.scan.fans[0])[1] - Eigen::Vector3d(3, 4, 0)).norm(), 0, 1e-12);
  EXPECT_EQ(rays.counts.hits, 1u);
  EXPECT_EQ(rays.counts.freeOnly, 2u);
}

TEST(RaySelection, TakesTheSmallerOfBothMaximumRanges)
{
  const Eigen::Vector3d at9(9, 0, 0);
  RangeOptions limits;
  const auto hits = [&](double own, double stated)
  {
    limits.maxRange = own;
    return selected({fanOf({0, 0, 0}, {at9}, {}, 0, stated)}, limits).counts.hits;
  };
  EXPECT_EQ(hits(0, 0), 1u);
  EXPECT_EQ(hits(0, 8), 0u);
  EXPECT_EQ(hits(0, 10), 1u);
  EXPECT_EQ(hits(8, 10), 0u);
  EXPECT_EQ(hits(10, 8), 0u);
}

TEST(RaySelection, TakesTheLargerOfBothMinimumRanges)
{
  RangeOptions limits;
  const auto tooNear = [&](double own, double stated)
  {
    limits.minRange = own;
    return selected({fanOf({0, 0, 0}, {{0.5, 0, 0}, {1, 0, 0}, {1.5, 0, 0}}, {}, stated, 0)}, limits)
        .counts.tooNear;
  };
  EXPECT_EQ(tooNear(0, 0), 0u);
  EXPECT_EQ(tooNear(1, 0), 1u);  // at exactly the minimum range is a hit
  EXPECT_EQ(tooNear(0, 1.2), 2u);
  EXPECT_EQ(tooNear(0.7, 1.2), 2u);
  EXPECT_EQ(tooNear(1.2, 0.7), 2u);
}

TEST(RaySelection, EndsRaysWithoutReturnAtTheMaximumRange)
{
  RangeOptions limits;
  limits.maxRange = 10;
  const SelectedRays rays = selected(
      {fanOf({1, 0, 0}, {}, {{0, 0.003, 0.004}, {-200, 0, 0}, {0, 1e-200, 0}, {0, 0, 1e200}})}, limits);
  ASSERT_EQ(rays.counts.freeOnly, 4u);
  EXPECT_NEAR((freeRaysOf(rays.scan.fans[0])[0] - Eigen::Vector3d(0, 6, 8)).norm(), 0, 1e-12);
  EXPECT_NEAR((freeRaysOf(rays.scan.fans[0])[1] - Eigen::Vector3d(-10, 0, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR((freeRaysOf(rays.scan.fans[0])[2] - Eigen::Vector3d(0, 10, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR((freeRaysOf(rays.scan.fans[0])[3] - Eigen::Vector3d(0, 0, 10)).norm(), 0, 1e-12);
}

TEST(RaySelection, LeavesOutRaysWithoutReturnThatHaveNoEndOrAreNotWanted)
{
  RangeOptions limits;
  EXPECT_EQ(selected({fanOf({0, 0, 0}, {}, {{1, 0, 0}})}, limits).counts.unbounded, 1u);
  EXPECT_EQ(selected({fanOf({0, 0, 0}, {}, {{1, 0, 0}}, 0, 4)}, limits).counts.freeOnly, 1u);
  limits.considerInvalidRangesAsFreeSpace = false;
  EXPECT_EQ(selected({fanOf({0, 0, 0}, {}, {{1, 0, 0}}, 0, 4)}, limits).counts.unbounded, 1u);
  // A return beyond the maximum range is no ray without return.
  EXPECT_EQ(selected({fanOf({0, 0, 0}, {{5, 0, 0}}, {}, 0, 4)}, limits).counts.freeOnly, 1u);
}

TEST(RaySelection, CountsWhatIsNotFiniteOrHasNoLength)
{
  RangeOptions limits;
  limits.maxRange = 10;
  const SelectedRays rays =
      selected({fanOf({1, 1, 1}, {{kNan, 0, 0}, {0, kInf, 0}, {0, 0, -kInf}, {1, 1, 1}, {2, 1, 1}},
                      {{kNan, 0, 1}, {kInf, 0, 0}, {0, 0, 0}, {1, 0, 0}}),
                fanOf({kNan, 0, 0}, {{1, 1, 1}}, {{1, 0, 0}}), fanOf({0, kInf, 0}, {{1, 1, 1}}, {{1, 0, 0}})},
               limits);
  EXPECT_EQ(rays.counts.notFinite, 3u + 2u + 4u);
  EXPECT_EQ(rays.counts.tooNear, 2u);
  EXPECT_EQ(rays.counts.hits, 1u);
  EXPECT_EQ(rays.counts.freeOnly, 1u);
  EXPECT_EQ(rays.counts.used(), 2u);
  EXPECT_EQ(rays.counts.leftOut(), 11u);
}

TEST(RaySelection, CountsDecimationThroughTheScanInTheOrderOfTheSensor)
{
  // Seven rays, then four: with every third used, those are 0, 3, 6 and 9.
  RangeOptions limits;
  limits.maxRange = 50;
  limits.rayDecimation = 3;
  RayFan first, second;
  first.addReturn({1, 0, 0});
  first.add(RayEnd::NoReturn, {1, 0, 0});
  first.addReturn({kNan, 0, 0});  // counts among the decimated
  first.add(RayEnd::NoReturn, {0, 1, 0});
  first.add(RayEnd::Dropped, {0, 0, 1});
  first.addReturn({4, 0, 0});
  first.addReturn({5, 0, 0});
  second.addReturn({11, 0, 0});
  second.add(RayEnd::NoReturn, {0, 0, 1});
  second.addReturn({13, 0, 0});
  second.addReturn({14, 0, 0});
  const SelectedRays rays = selected({first, second}, limits);
  ASSERT_EQ(rays.scan.fans.size(), 2u);
  const std::vector<Ray>& used = rays.scan.fans[0].rays;
  ASSERT_EQ(used.size(), 3u);
  EXPECT_EQ(used[0], first.rays[0]);
  EXPECT_EQ(used[1].meaning, RayEnd::NoReturn);
  EXPECT_NEAR(used[1].end.y(), 50, 1e-12);
  EXPECT_EQ(used[2], first.rays[6]);
  ASSERT_EQ(rays.scan.fans[1].rays.size(), 1u);
  EXPECT_EQ(rays.scan.fans[1].rays[0], second.rays[2]);
  EXPECT_EQ(rays.counts.decimated, 7u);
  EXPECT_EQ(rays.counts.notFinite, 0u);
  EXPECT_EQ(rays.counts.dropped, 0u);
}

TEST(RaySelection, KeepsTheSensorAndTheOrderOfItsRays)
{
  RangeOptions limits;
  limits.maxRange = 5;
  Scan scan;
  scan.sensorPose_map.translation() = Eigen::Vector3d(100, 0, 0);
  scan.sensorPose_map.linear() = Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  scan.poseCovariance = Scan::PoseCovariance::Identity();
  RayFan& fan = scan.fans.emplace_back();
  fan.centre = {0, 0, 1};
  fan.beam.halfWidth_rad = 0.25;
  fan.rays = {{{1, 0, 1}, RayEnd::Return, 2},
              {{9, 0, 1}, RayEnd::Return, 1},
              {{0, 2, 0}, RayEnd::NoReturn, 0},
              {{0, 0, 3}, RayEnd::Cut, 0},
              {{0, 3, 1}, RayEnd::Return, 0}};
  const SelectedRays rays = selectRays(scan, limits);
  EXPECT_EQ(rays.scan.sensorPose_map.matrix(), scan.sensorPose_map.matrix());
  EXPECT_EQ(*rays.scan.poseCovariance, *scan.poseCovariance);
  EXPECT_EQ(rays.firstCentre_map(), scan.inMap(fan.centre));
  const RayFan& kept = rays.scan.fans.at(0);
  EXPECT_EQ(kept.beam, fan.beam);
  EXPECT_EQ(kept.statedRangeMax_m, 5);
  EXPECT_EQ(kept.rays, (std::vector<Ray>{fan.rays[0],
                                         {{5, 0, 0}, RayEnd::Cut, 1},
                                         {{0, 3, 0}, RayEnd::NoReturn, 0},
                                         {{0, 0, 3}, RayEnd::Cut, 0},
                                         fan.rays[4]}));
  // What was selected once stays as it is.
  EXPECT_EQ(selectRays(rays.scan, limits).scan.fans, rays.scan.fans);
}

TEST(RaySelection, LeavesOutRaysOfWhichNothingIsKnownAndThoseTooNear)
{
  RayFan fan;
  fan.add(RayEnd::Dropped, {1, 0, 0});
  fan.add(RayEnd::Dropped, {0, 0, 0});
  fan.add(RayEnd::TooNear, {1, 0, 0});
  const SelectedRays rays = selected({fan}, {});
  EXPECT_EQ(rays.counts.dropped, 2u);
  EXPECT_EQ(rays.counts.tooNear, 1u);
  EXPECT_EQ(rays.counts.leftOut(), 1u);
  EXPECT_TRUE(rays.scan.fans[0].rays.empty());
}

TEST(RaySelection, AccountsForEveryRay)
{
  for (unsigned seed = 1; seed <= seeds(20); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    ScanRecipe recipe;
    recipe.fans = 4;
    const Scan scan = randomScan(random, recipe);
    size_t all = 0;
    for (const RayFan& fan : scan.fans) all += fan.rays.size();
    RangeOptions limits;
    limits.rayDecimation = static_cast<uint32_t>(random.integer(1, 5));
    limits.minRange = random.uniform(0, 0.2);
    limits.maxRange = random.chance(0.5) ? random.uniform(0.3, 1) : 0;
    limits.considerInvalidRangesAsFreeSpace = random.chance(0.5);
    const SelectedRays rays = selectRays(scan, limits);
    size_t hits = 0, freeOnly = 0;
    for (const RayFan& fan : rays.scan.fans)
      for (const Ray& ray : fan.rays)
      {
        ++(ray.meaning == RayEnd::Return ? hits : freeOnly);
        EXPECT_TRUE(ray.end.allFinite());
      }
    EXPECT_EQ(sumOf(rays.counts), all);
    EXPECT_EQ(rays.counts.hits, hits);
    EXPECT_EQ(rays.counts.freeOnly, freeOnly);
    EXPECT_EQ(rays.counts.decimated, all - (all + limits.rayDecimation - 1) / limits.rayDecimation);
  }
}

TEST(RaySelection, LeavesOutRaysThatAreTooLongForTheCells)
{
  const double longest_m = kLongestRay_cells * 0.5;
  RayFan fan;
  fan.addReturn({longest_m, 0, 0});
  fan.addReturn({0, longest_m + 1, 0});
  fan.add(RayEnd::Cut, {0, 0, longest_m + 3});
  fan.add(RayEnd::NoReturn, {-1, 0, 0});
  Scan scan = scanWith({fan});
  RangeOptions limits;
  limits.maxRange = longest_m + 2;
  RayCounts counts = selectRays(scan, limits, 0.5).counts;
  EXPECT_EQ(counts.hits, 1u);
  EXPECT_EQ(counts.tooLong, 3u);
  EXPECT_EQ(counts.tooLongLongest_m, longest_m + 2);
  EXPECT_EQ(counts.noReturn, 0u);
  EXPECT_EQ(selectRays(scan, limits).counts.tooLong, 0u) << "without cells, a ray may have any length";

  // What is cut in time is not too long.
  limits.maxRange = longest_m;
  counts = selectRays(scan, limits, 0.5).counts;
  EXPECT_EQ(counts.tooLong, 0u);
  EXPECT_EQ(counts.used(), 4u);
}

TEST(RaySelection, AddsItsCounts)
{
  RayCounts a, b;
  a.hits = 1, a.freeOnly = 2, a.decimated = 3, a.notFinite = 4, a.tooNear = 5, a.unbounded = 6, a.outside = 7,
  a.dropped = 8, a.tooLong = 9, a.tooLongLongest_m = 10;
  b = a;
  b.tooLongLongest_m = 5;
  b += a;
  EXPECT_EQ(b.hits, 2u);
  EXPECT_EQ(b.freeOnly, 4u);
  EXPECT_EQ(b.decimated, 6u);
  EXPECT_EQ(b.notFinite, 8u);
  EXPECT_EQ(b.tooNear, 10u);
  EXPECT_EQ(b.unbounded, 12u);
  EXPECT_EQ(b.outside, 14u);
  EXPECT_EQ(b.dropped, 16u);
  EXPECT_EQ(b.tooLong, 18u);
  EXPECT_EQ(b.tooLongLongest_m, 10);
  EXPECT_EQ(b.used(), 6u);
  EXPECT_EQ(b.leftOut(), 62u);
}

TEST(RaySelection, RefusesBadLimitsByNameAndValue)
{
  const auto expectRefused = [](const RangeOptions& limits, const std::string& name, const std::string& value)
  {
    try
    {
      (void)selectRays({}, limits);
      ADD_FAILURE() << name << " = " << value << " is taken";
    }
    catch (const std::invalid_argument& error)
    {
      EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find(value), std::string::npos) << error.what();
    }
  };
  RangeOptions limits;
  for (const auto& [bad, printed] :
       std::vector<std::pair<double, std::string>>{{-0.5, "-0.5"}, {kNan, "nan"}, {kInf, "inf"}})
  {
    limits = {};
    limits.minRange = bad;
    expectRefused(limits, "minRange", printed);
    limits = {};
    limits.maxRange = bad;
    expectRefused(limits, "maxRange", printed);
  }
  limits = {};
  limits.rayDecimation = 0;
  expectRefused(limits, "rayDecimation", "0");
}
}  // namespace
}  // namespace lamap::test
