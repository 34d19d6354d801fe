// Wide beams as training points: against the definition, by brute force over cells.
#include <gtest/gtest.h>
#include <lamap_core/training/sampler.h>
#include <support/seeded_scans.h>
#include <support/seeds.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <tuple>

namespace lamap::test
{
namespace
{
constexpr double kDegree = M_PI / 180;
constexpr double kResolution_m = 0.1;

/// Training points by the cell that holds them; several in a cell add up.
using Weights = std::map<std::tuple<int, int, int>, double>;

struct Taught
{
  Weights hits;
  Weights frees;
  RayCounts counts;
};

/// One ping from the middle of a cell.
Scan pingOf(const Eigen::Vector3d& echo, double aperture_deg, uint8_t rank = 0)
{
  RayFan fan;
  fan.centre = {0.05, 0.05, 0.05};
  fan.rays.push_back({fan.centre + echo, RayEnd::Return, rank});
  fan.beam.halfWidth_rad = fan.beam.halfHeight_rad = 0.5 * aperture_deg * kDegree;
  return scanWith({fan});
}

SamplingRules coneRules()
{
  SamplingRules rules;
  rules.protectHits = 2;
  rules.beamWidth = BeamWidth::Observation;
  return rules;
}

Taught taughtBy(const Scan& scan, const SamplingRules& rules, double maxRange_m = 20, bool planar = false)
{
  RangeOptions limits;
  limits.maxRange = maxRange_m;
  const SelectedRays rays = selectRays(scan, limits);
  const ScanFrame frame(kResolution_m, {0, 0, 0}, planar);
  Sampler sampler;
  const TrainingSet& set = sampler.sample(rays, rules, frame, {}, 1);
  Taught taught;
  set.forEachPoint(
      [&](const TrainingPoint& point)
      {
        const CellIndex cell = cellOfLocal(point.place);
        (point.occupied ? taught.hits : taught.frees)[{cell.x, cell.y, cell.z}] += point.weight;
      });
  taught.counts = set.counts;
  return taught;
}

double sumOf(const Weights& weights)
{
  return std::accumulate(weights.begin(), weights.end(), 0.0,
                         [](double sum, const auto& one) { return sum + one.second; });
}

/// From the ping's centre [m].
Eigen::Vector3d centreOf(const Weights::value_type& cell)
{
  const auto [x, y, z] = cell.first;
  return kResolution_m * Eigen::Vector3d(x, y, z);
}

double angleOf(const Eigen::Vector3d& place, const Eigen::Vector3d& axis)
{
  return std::atan2(place.cross(axis).norm(), place.dot(axis));
}

/// All cells that a cap passes through, but for the smallest corners: by many random places on it.
Weights cellsOfCap(const Eigen::Vector3d& echo, double half_rad, Random& random)
{
  Weights cells;
  const double range = echo.norm();
  for (int i = 0; i < 200000; ++i)
  {
    const Eigen::Vector3d place = range * (echo / range + random.inCube(std::tan(half_rad))).normalized();
    if (angleOf(place, echo) > half_rad) continue;
    const auto cellAt = [](double coordinate)
    { return static_cast<int>(std::floor((coordinate + 0.05) / kResolution_m)); };
    cells[{cellAt(place.x()), cellAt(place.y()), cellAt(place.z())}] += 1;
  }
  return cells;
}

TEST(ConeSampling, TheEchoIsSharedEvenlyByTheCellsOfTheCap)
{
  for (unsigned seed = 1; seed <= seeds(6); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    const double aperture_deg = random.uniform(8, 25);
    const Eigen::Vector3d echo = random.uniform(2, 4) * random.inCube(1).normalized();
    const Taught taught = taughtBy(pingOf(echo, aperture_deg), coneRules());
    EXPECT_NEAR(sumOf(taught.hits), SamplingRules().echoWeight, 1e-9);
    for (const auto& hit : taught.hits) EXPECT_NEAR(hit.second, taught.hits.begin()->second, 1e-12);

    const Weights cap = cellsOfCap(echo, 0.5 * aperture_deg * kDegree, random);
    double missed = 0;
    for (const auto& [cell, places] : cap)
      if (taught.hits.count(cell) == 0) missed += places;
    EXPECT_LT(missed, 0.05 * sumOf(cap)) << "corners only";
    for (const auto& [cell, weight] : taught.hits) EXPECT_EQ(cap.count(cell), 1U);
  }
}

TEST(ConeSampling, TheConeIsFreeBeforeTheCap)
{
  for (unsigned seed = 1; seed <= seeds(6); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    const double half = 0.5 * random.uniform(8, 25) * kDegree;
    const Eigen::Vector3d direction = random.inCube(1).normalized();
    const Eigen::Vector3d echo = random.uniform(2, 4) * direction;
    const Taught taught = taughtBy(pingOf(echo, 2 * half / kDegree), coneRules());
    const double range = echo.norm();
    const double slack = kResolution_m * std::sqrt(3.0) / 2;
    for (const auto& free : taught.frees)
    {
      EXPECT_EQ(free.second, 1);
      EXPECT_EQ(taught.hits.count(free.first), 0U) << "a cell of the cap";
      const Eigen::Vector3d place = centreOf(free);
      EXPECT_LT(place.norm(), range - kResolution_m + slack);
      EXPECT_LT(place.norm() * (angleOf(place, echo) - half), slack) << "beside the cone";
    }
    // Nearly every cell that lies within the cone, and nearer than the margin.
    const int reach = static_cast<int>(range / kResolution_m) + 1;
    size_t inside = 0;
    size_t missed = 0;
    for (int x = -reach; x <= reach; ++x)
      for (int y = -reach; y <= reach; ++y)
        for (int z = -reach; z <= reach; ++z)
        {
          const Eigen::Vector3d place = centreOf({{x, y, z}, 0});
          if (place.norm() > range - 2.5 * kResolution_m || place.norm() < kResolution_m) continue;
          if (place.norm() * (half - angleOf(place, echo)) < slack) continue;
          ++inside;
          missed += taught.frees.count({x, y, z}) == 0 ? 1 : 0;
        }
    EXPECT_GT(inside, 30U);
    EXPECT_LT(missed, inside / 4) << "a cell near the end may lie between the rays";
  }
}

// What is known of a ping that is no wider than a cell is what is known of a ray.
TEST(ConeSampling, AnApertureThatTendsToZeroGivesThePlainRay)
{
  for (const TrainingPoints points : {TrainingPoints::Cells, TrainingPoints::Centroids})
    for (const double aperture_deg : {0.0, 1e-6, 0.5, 200.0})
    {
      SamplingRules rules = coneRules();
      rules.points = points;
      rules.hitDownsampling = kResolution_m;
      const Taught narrow = taughtBy(pingOf({3, 1, 0.5}, aperture_deg), rules);
      rules.beamWidth = BeamWidth::None;
      const Taught plain = taughtBy(pingOf({3, 1, 0.5}, aperture_deg), rules);
      EXPECT_EQ(narrow.hits, plain.hits) << aperture_deg;
      EXPECT_EQ(narrow.frees, plain.frees) << aperture_deg;
    }
}

TEST(ConeSampling, AnApertureThatIsNoneIsRefused)
{
  for (const double aperture_deg : {-3.0, std::nan(""), std::numeric_limits<double>::infinity()})
    EXPECT_THROW(taughtBy(pingOf({3, 1, 0.5}, aperture_deg), coneRules()), std::invalid_argument)
        << aperture_deg;
}

TEST(ConeSampling, AnEchoWeighsAHitForEachCellOfItsCapUntilItWeighsTheMost)
{
  // 1.2 m away: 2.4 sin(a/4)·2 across, a disc of π/4 of its square.
  const auto weightOf = [](double aperture_deg) {
    return sumOf(taughtBy(pingOf({1.2, 0, 0}, aperture_deg), coneRules()).hits);
  };
  EXPECT_NEAR(weightOf(4), 1, 1e-9) << "narrower than a cell";
  EXPECT_NEAR(weightOf(5), 1, 1e-9) << "wider, but of a smaller area";
  const double across_cells = 2 * 12 * 2 * std::sin(7.4 / 4 * kDegree);
  EXPECT_NEAR(weightOf(7.4), M_PI / 4 * across_cells * across_cells, 1e-6);
  EXPECT_NEAR(weightOf(20), 3, 1e-9);
}

TEST(ConeSampling, NoCellWeighsMoreThanAHit)
{
  Scan scan = pingOf({3, 1, 0.5}, 10);
  for (int i = 0; i < 200; ++i) scan.fans.push_back(scan.fans.front());
  for (const auto& hit : taughtBy(scan, coneRules()).hits) EXPECT_NEAR(hit.second, 1, 1e-12);
}

TEST(ConeSampling, ALaterEchoFreesNothing)
{
  for (const double aperture_deg : {0.0, 15.0})
    for (const TrainingPoints points : {TrainingPoints::Cells, TrainingPoints::Centroids})
    {
      SamplingRules rules = coneRules();
      rules.points = points;
      const Taught first = taughtBy(pingOf({3, 0.3, 0}, aperture_deg), rules);
      const Taught second = taughtBy(pingOf({3, 0.3, 0}, aperture_deg, 1), rules);
      EXPECT_EQ(second.hits, first.hits);
      EXPECT_TRUE(second.frees.empty());
      EXPECT_FALSE(first.frees.empty());
      EXPECT_EQ(second.counts.hits, 1U);
    }
  // Without the widths of beams, ranks mean nothing.
  SamplingRules rules = coneRules();
  rules.beamWidth = BeamWidth::None;
  EXPECT_EQ(taughtBy(pingOf({3, 0.3, 0}, 15, 1), rules).frees,
            taughtBy(pingOf({3, 0.3, 0}, 15), rules).frees);
}

TEST(ConeSampling, EchoesOfOnePingMayStandInOneScanInAnyOrder)
{
  Scan ping = pingOf({2, 0, 0}, 15);
  ping.fans[0].rays.push_back({ping.fans[0].centre + Eigen::Vector3d(4, 0, 0), RayEnd::Return, 1});
  const Taught both = taughtBy(ping, coneRules());
  std::swap(ping.fans[0].rays[0], ping.fans[0].rays[1]);
  const Taught swapped = taughtBy(ping, coneRules());
  EXPECT_EQ(both.frees, swapped.frees);
  EXPECT_EQ(both.hits, swapped.hits);
  EXPECT_NEAR(sumOf(both.hits), 6, 1e-9);
  EXPECT_EQ(both.frees, taughtBy(pingOf({2, 0, 0}, 15), coneRules()).frees);
}

TEST(ConeSampling, InAPlanarMapTheSectionInItsPlaneCounts)
{
  const Taught taught = taughtBy(pingOf({3, 0, 0}, 20), coneRules(), 20, true);
  // An arc of 3 m · 20° is 10.5 cells long.
  EXPECT_NEAR(static_cast<double>(taught.hits.size()), 11, 3);
  EXPECT_NEAR(sumOf(taught.hits), 3, 1e-9);
  for (const auto& hit : taught.hits)
  {
    EXPECT_EQ(std::get<2>(hit.first), 0);
    EXPECT_NEAR(std::hypot(centreOf(hit).x(), centreOf(hit).y()), 3, 0.08);
  }
  EXPECT_EQ(taught.frees.count({20, 3, 0}), 1U);
  EXPECT_EQ(taught.frees.count({20, 5, 0}), 0U);
}

TEST(ConeSampling, ABeamWithoutAnEchoWeighsWhatIsAskedFor)
{
  Scan scan = pingOf({1, 0, 0}, 10);
  RayFan& fan = scan.fans[0];
  fan.statedRangeMax_m = 4;
  fan.rays = {{{1, 0, 0}, RayEnd::NoReturn, 0}};
  SamplingRules rules = coneRules();
  rules.freeWeight = 0.5;
  for (const TrainingPoints points : {TrainingPoints::Cells, TrainingPoints::Centroids})
  {
    rules.points = points;
    rules.noEchoWeight = 1;
    const Taught usual = taughtBy(scan, rules);
    ASSERT_GT(usual.frees.size(), 500U);
    EXPECT_EQ(usual.counts.noReturn, 1U);
    rules.noEchoWeight = 0.25;
    const Taught weak = taughtBy(scan, rules);
    EXPECT_EQ(weak.frees.size(), usual.frees.size());
    for (const auto& [cell, weight] : weak.frees) EXPECT_NEAR(weight, 0.25 * usual.frees.at(cell), 1e-12);
    rules.noEchoWeight = 0;
    const Taught none = taughtBy(scan, rules);
    EXPECT_TRUE(none.frees.empty());
    EXPECT_EQ(none.counts.noReturn, 0U);
    EXPECT_EQ(none.counts.unbounded, 1U);
    EXPECT_EQ(none.counts.used(), 0U);
    EXPECT_EQ(none.counts.noReturnLength_m, 0);
  }
  // Not so of a laser's.
  fan.beam = {};
  EXPECT_FALSE(taughtBy(scan, rules).frees.empty());
}

TEST(ConeSampling, WhereACellIsFreeByAnEchoTooItWeighsAsMuchAsAnyOther)
{
  Scan scan = pingOf({3, 0, 0}, 10);
  scan.fans.push_back(scan.fans[0]);
  scan.fans[1].statedRangeMax_m = 5;
  scan.fans[1].rays = {{{1, 0, 0}, RayEnd::NoReturn, 0}};
  SamplingRules rules = coneRules();
  rules.noEchoWeight = 0.25;
  const Taught taught = taughtBy(scan, rules);
  EXPECT_EQ(taught.frees.at({20, 0, 0}), 1);
  EXPECT_EQ(taught.frees.at({40, 0, 0}), 0.25);
  EXPECT_EQ(taught.frees.count({30, 0, 0}), 0U) << "the cap of the other one";
}

TEST(ConeSampling, PointsByThemselvesAreAsDenseNearTheSensorAsElsewhere)
{
  SamplingRules rules = coneRules();
  rules.points = TrainingPoints::Centroids;
  const Taught taught = taughtBy(pingOf({4, 0, 0}, 20), rules);
  // Samples and rays stand a cell of 0.1 m apart, so each cell of the cone takes about one, near or far.
  for (const double x : {0.8, 1.5, 2.5, 3.5})
  {
    double sum = 0;
    double cells = 0;
    for (const auto& free : taught.frees)
    {
      const Eigen::Vector3d place = centreOf(free);
      if (std::abs(place.norm() - x) > 0.3 || angleOf(place, {1, 0, 0}) > 7 * kDegree) continue;
      sum += free.second;
      ++cells;
    }
    ASSERT_GT(cells, 10);
    EXPECT_NEAR(sum / cells, 1, 0.4) << x;
  }
}

TEST(ConeSampling, ARangeBeyondTheMaximumIsFreeSpaceOfTheWholeCone)
{
  const Taught taught = taughtBy(pingOf({30, 0, 0}, 10), coneRules(), 5);
  EXPECT_TRUE(taught.hits.empty());
  EXPECT_EQ(taught.counts.freeOnly, 1U);
  EXPECT_EQ(taught.frees.count({49, 3, 0}), 1U);
  EXPECT_EQ(taught.frees.count({49, 0, -3}), 1U);
  EXPECT_EQ(taught.frees.count({49, 6, 0}), 0U);
  EXPECT_EQ(taught.frees.count({51, 0, 0}), 0U);
}

}  // namespace
}  // namespace lamap::test
