#include <gtest/gtest.h>
#include <lamap_core/scan/ray_selection.h>
#include <support/seeded_scans.h>

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

RayFan fanOf(const Eigen::Vector3d& origin, const std::vector<Eigen::Vector3d>& returns,
             const std::vector<Eigen::Vector3d>& noReturns = {}, double statedMin = 0, double statedMax = 0)
{
  return {origin, returns, noReturns, statedMin, statedMax};
}

size_t sumOf(const RayCounts& c)
{
  return c.hits + c.freeOnly + c.decimated + c.notFinite + c.tooNear + c.unbounded + c.outside;
}

TEST(RaySelection, KeepsHitsAsTheyAre)
{
  const SelectedRays rays = selectRays({{fanOf({1, 2, 3}, {{4, 2, 3}, {1, -7, 3}})}}, {});
  ASSERT_EQ(rays.fans.size(), 1u);
  EXPECT_EQ(rays.fans[0].origin_map, Eigen::Vector3d(1, 2, 3));
  ASSERT_EQ(rays.fans[0].hitEnds_map.size(), 2u);
  EXPECT_EQ(rays.fans[0].hitEnds_map[0], Eigen::Vector3d(4, 2, 3));
  EXPECT_EQ(rays.fans[0].hitEnds_map[1], Eigen::Vector3d(1, -7, 3));
  EXPECT_TRUE(rays.fans[0].freeRays_map.empty());
  EXPECT_EQ(rays.counts.hits, 2u);
  EXPECT_EQ(rays.counts.used(), 2u);
  EXPECT_EQ(rays.counts.leftOut(), 0u);
}

TEST(RaySelection, CutsRaysAtTheMaximumRangeAndTakesTheirHit)
{
  RangeLimits limits;
  limits.max_m = 5;
  const SelectedRays rays = selectRays({{fanOf({1, 1, 1}, {{1, 1, 6}, {1, 1, 6.5}, {7, 9, 1}})}}, limits);
  ASSERT_EQ(rays.fans[0].hitEnds_map.size(), 1u);  // at exactly the maximum range is a hit
  ASSERT_EQ(rays.fans[0].freeRays_map.size(), 2u);
  EXPECT_NEAR((rays.fans[0].freeRays_map[0] - Eigen::Vector3d(0, 0, 5)).norm(), 0, 1e-12);
  EXPECT_NEAR((rays.fans[0].freeRays_map[1] - Eigen::Vector3d(3, 4, 0)).norm(), 0, 1e-12);
  EXPECT_EQ(rays.counts.hits, 1u);
  EXPECT_EQ(rays.counts.freeOnly, 2u);
}

TEST(RaySelection, PrefersItsOwnMaximumRangeToTheStatedOne)
{
  const Eigen::Vector3d at9(9, 0, 0);
  RangeLimits limits;
  const auto hits = [&](double own, double stated)
  {
    limits.max_m = own;
    return selectRays({{fanOf({0, 0, 0}, {at9}, {}, 0, stated)}}, limits).counts.hits;
  };
  EXPECT_EQ(hits(0, 0), 1u);
  EXPECT_EQ(hits(0, 8), 0u);
  EXPECT_EQ(hits(0, 10), 1u);
  EXPECT_EQ(hits(8, 10), 0u);
  EXPECT_EQ(hits(10, 8), 1u);
}

TEST(RaySelection, TakesTheLargerOfBothMinimumRanges)
{
  RangeLimits limits;
  const auto tooNear = [&](double own, double stated)
  {
    limits.min_m = own;
    return selectRays({{fanOf({0, 0, 0}, {{0.5, 0, 0}, {1, 0, 0}, {1.5, 0, 0}}, {}, stated, 0)}}, limits)
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
  RangeLimits limits;
  limits.max_m = 10;
  const SelectedRays rays = selectRays(
      {{fanOf({1, 0, 0}, {}, {{0, 0.003, 0.004}, {-200, 0, 0}, {0, 1e-200, 0}, {0, 0, 1e200}})}}, limits);
  ASSERT_EQ(rays.counts.freeOnly, 4u);
  EXPECT_NEAR((rays.fans[0].freeRays_map[0] - Eigen::Vector3d(0, 6, 8)).norm(), 0, 1e-12);
  EXPECT_NEAR((rays.fans[0].freeRays_map[1] - Eigen::Vector3d(-10, 0, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR((rays.fans[0].freeRays_map[2] - Eigen::Vector3d(0, 10, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR((rays.fans[0].freeRays_map[3] - Eigen::Vector3d(0, 0, 10)).norm(), 0, 1e-12);
}

TEST(RaySelection, LeavesOutRaysWithoutReturnThatHaveNoEndOrAreNotWanted)
{
  RangeLimits limits;
  EXPECT_EQ(selectRays({{fanOf({0, 0, 0}, {}, {{1, 0, 0}})}}, limits).counts.unbounded, 1u);
  EXPECT_EQ(selectRays({{fanOf({0, 0, 0}, {}, {{1, 0, 0}}, 0, 4)}}, limits).counts.freeOnly, 1u);
  limits.noReturnIsFree = false;
  EXPECT_EQ(selectRays({{fanOf({0, 0, 0}, {}, {{1, 0, 0}}, 0, 4)}}, limits).counts.unbounded, 1u);
  // A return beyond the maximum range is no ray without return.
  EXPECT_EQ(selectRays({{fanOf({0, 0, 0}, {{5, 0, 0}}, {}, 0, 4)}}, limits).counts.freeOnly, 1u);
}

TEST(RaySelection, CountsWhatIsNotFiniteOrHasNoLength)
{
  RangeLimits limits;
  limits.max_m = 10;
  const SelectedRays rays = selectRays(
      {{fanOf({1, 1, 1}, {{kNan, 0, 0}, {0, kInf, 0}, {0, 0, -kInf}, {1, 1, 1}, {2, 1, 1}},
              {{kNan, 0, 1}, {kInf, 0, 0}, {0, 0, 0}, {1, 0, 0}}),
        fanOf({kNan, 0, 0}, {{1, 1, 1}}, {{1, 0, 0}}), fanOf({0, kInf, 0}, {{1, 1, 1}}, {{1, 0, 0}})}},
      limits);
  EXPECT_EQ(rays.counts.notFinite, 3u + 2u + 4u);
  EXPECT_EQ(rays.counts.tooNear, 2u);
  EXPECT_EQ(rays.counts.hits, 1u);
  EXPECT_EQ(rays.counts.freeOnly, 1u);
  EXPECT_EQ(rays.counts.used(), 2u);
  EXPECT_EQ(rays.counts.leftOut(), 11u);
}

TEST(RaySelection, CountsDecimationThroughTheWholeScan)
{
  // 5 returns and 2 no-returns, then 3 and 1: with every third used, those are 0, 3, 6 and 9.
  RangeLimits limits;
  limits.max_m = 50;
  limits.decimation = 3;
  std::vector<Eigen::Vector3d> five, three;
  for (int i = 0; i < 5; ++i) five.emplace_back(1 + i, 0, 0);
  for (int i = 0; i < 3; ++i) three.emplace_back(11 + i, 0, 0);
  five[1] = {kNan, 0, 0};  // counts among the decimated
  const SelectedRays rays = selectRays(
      {{fanOf({0, 0, 0}, five, {{1, 0, 0}, {0, 1, 0}}), fanOf({0, 0, 0}, three, {{0, 0, 1}})}}, limits);
  ASSERT_EQ(rays.fans.size(), 2u);
  ASSERT_EQ(rays.fans[0].hitEnds_map.size(), 2u);
  EXPECT_EQ(rays.fans[0].hitEnds_map[0].x(), 1);
  EXPECT_EQ(rays.fans[0].hitEnds_map[1].x(), 4);
  ASSERT_EQ(rays.fans[0].freeRays_map.size(), 1u);
  EXPECT_NEAR(rays.fans[0].freeRays_map[0].y(), 50, 1e-12);
  ASSERT_EQ(rays.fans[1].hitEnds_map.size(), 1u);
  EXPECT_EQ(rays.fans[1].hitEnds_map[0].x(), 13);
  EXPECT_TRUE(rays.fans[1].freeRays_map.empty());
  EXPECT_EQ(rays.counts.decimated, 7u);
  EXPECT_EQ(rays.counts.notFinite, 0u);
}

TEST(RaySelection, AccountsForEveryRay)
{
  for (unsigned seed = 1; seed <= 20; ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    ScanRecipe recipe;
    recipe.fans = 4;
    const Scan scan = randomScan(random, recipe);
    size_t all = 0;
    for (const RayFan& fan : scan.fans) all += fan.returns_map.size() + fan.noReturnDirections_map.size();
    RangeLimits limits;
    limits.decimation = static_cast<uint32_t>(random.integer(1, 5));
    limits.min_m = random.uniform(0, 0.2);
    limits.max_m = random.chance(0.5) ? random.uniform(0.3, 1) : 0;
    limits.noReturnIsFree = random.chance(0.5);
    const SelectedRays rays = selectRays(scan, limits);
    size_t hits = 0, freeOnly = 0;
    for (const SelectedFan& fan : rays.fans)
    {
      hits += fan.hitEnds_map.size();
      freeOnly += fan.freeRays_map.size();
      for (const auto& end : fan.hitEnds_map) EXPECT_TRUE(end.allFinite());
      for (const auto& ray : fan.freeRays_map) EXPECT_TRUE(ray.allFinite());
    }
    EXPECT_EQ(sumOf(rays.counts), all);
    EXPECT_EQ(rays.counts.hits, hits);
    EXPECT_EQ(rays.counts.freeOnly, freeOnly);
    EXPECT_EQ(rays.counts.decimated, all - (all + limits.decimation - 1) / limits.decimation);
  }
}

TEST(RaySelection, AddsItsCounts)
{
  RayCounts a, b;
  a.hits = 1, a.freeOnly = 2, a.decimated = 3, a.notFinite = 4, a.tooNear = 5, a.unbounded = 6, a.outside = 7;
  b = a;
  b += a;
  EXPECT_EQ(b.hits, 2u);
  EXPECT_EQ(b.freeOnly, 4u);
  EXPECT_EQ(b.decimated, 6u);
  EXPECT_EQ(b.notFinite, 8u);
  EXPECT_EQ(b.tooNear, 10u);
  EXPECT_EQ(b.unbounded, 12u);
  EXPECT_EQ(b.outside, 14u);
  EXPECT_EQ(b.used(), 6u);
  EXPECT_EQ(b.leftOut(), 44u);
}

TEST(RaySelection, RefusesBadLimitsByNameAndValue)
{
  const auto expectRefused = [](const RangeLimits& limits, const std::string& name, const std::string& value)
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
  RangeLimits limits;
  for (const auto& [bad, printed] :
       std::vector<std::pair<double, std::string>>{{-0.5, "-0.5"}, {kNan, "nan"}, {kInf, "inf"}})
  {
    limits = {};
    limits.min_m = bad;
    expectRefused(limits, "minRange", printed);
    limits = {};
    limits.max_m = bad;
    expectRefused(limits, "maxRange", printed);
  }
  limits = {};
  limits.decimation = 0;
  expectRefused(limits, "rayDecimation", "0");
}
}  // namespace
}  // namespace lamap::test
