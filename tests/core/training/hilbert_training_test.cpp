// Training sets of Hilbert maps, against their definition.
#include <gtest/gtest.h>
#include <lamap_core/hilbert/options.h>
#include <lamap_core/scan/glancing_surfaces.h>
#include <lamap_core/training/hilbert_training.h>
#include <support/hilbert_oracle.h>
#include <support/seeded_scans.h>
#include <support/seeds.h>

#include <Eigen/Geometry>

#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>

namespace lamap::test
{
namespace
{
using Key = std::tuple<int, int, int>;
constexpr double kResolution = 0.125;
constexpr double kSpacing = 0.25;

Key keyOf(const Eigen::Vector3d& point, double edge)
{
  return {static_cast<int>(std::floor(point.x() / edge)), static_cast<int>(std::floor(point.y() / edge)),
          static_cast<int>(std::floor(point.z() / edge))};
}

Eigen::Vector3d anchorCorner(const HilbertFrame& frame)
{
  return frame.spacing_m * Eigen::Vector3d(frame.anchorSite.x, frame.anchorSite.y, frame.anchorSite.z);
}

// A hit at 2 m: free at 1.85, 1.55, …, 0.05 m.
TEST(HilbertTrainingSet, SamplesRunBackwardsFromTheHit)
{
  HilbertSampling sampling;
  sampling.trainingPoints = HilbertPoints::Points;
  const HilbertFrame frame = *HilbertFrame::inMap({0.3, 0.3, 0.3}, kResolution, kSpacing, {});
  const HilbertTrainingSet set =
      trainingSetOf(scanWith({fanOf({0.3, 0.3, 0.3}, {{2.3, 0.3, 0.3}})}), {}, sampling.rules(), frame);
  ASSERT_EQ(set.size(), 8u);
  EXPECT_EQ(set.labels[0], 1.0f);
  EXPECT_EQ(set.weights[0], 2.0f);
  EXPECT_LT((set.points[0] + anchorCorner(frame) - Eigen::Vector3d(2.3, 0.3, 0.3)).norm(), 1e-7);
  for (size_t i = 1; i < set.size(); ++i)
  {
    const double t = 1.85 - 0.3 * static_cast<double>(i - 1);
    EXPECT_LT((set.points[i] + anchorCorner(frame) - Eigen::Vector3d(0.3 + t, 0.3, 0.3)).norm(), 1e-7);
    EXPECT_EQ(set.labels[i], 0.0f);
    EXPECT_EQ(set.weights[i], 1.0f);
  }
}

TEST(HilbertTrainingSet, RaysWithoutAReturnAreFreeUpToTheirEnd)
{
  const Scan scan = scanWith({fanOf({0, 0, 0}, {}, {{0, 0, 5}})});
  HilbertSampling sampling;
  sampling.trainingPoints = HilbertPoints::Points;
  const HilbertFrame frame = *HilbertFrame::inMap({0, 0, 0}, kResolution, kSpacing, {});
  RangeOptions limits;
  limits.maxRange = 1.0;
  const HilbertTrainingSet set = trainingSetOf(scan, limits, sampling.rules(), frame);
  ASSERT_EQ(set.size(), 4u);  // 1.0, 0.7, 0.4, 0.1
  EXPECT_NEAR(set.points[0].z() + anchorCorner(frame).z(), 1.0, 1e-7);
  EXPECT_NEAR(set.points[3].z() + anchorCorner(frame).z(), 0.1, 1e-7);
  limits.considerInvalidRangesAsFreeSpace = false;
  RayCounts counts;
  EXPECT_EQ(trainingSetOf(scan, limits, sampling.rules(), frame, &counts).size(), 0u);
  EXPECT_EQ(counts.unbounded, 1u);
}

TEST(HilbertTrainingSetProperty, CellsCountOnceAndNoFreeCellHasAHit)
{
  for (unsigned seed = 1; seed <= seeds(40); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    ScanRecipe recipe;
    recipe.halfEdge_m = 2;
    recipe.rays = 60;
    const Scan scan = randomScan(random, recipe);
    HilbertSampling sampling;
    sampling.freeMargin = random.pick<double>({0.0, 0.15, 0.4});
    RangeOptions limits;
    limits.maxRange = random.pick<double>({0.0, 1.5});
    const Eigen::Vector3d near = scan.fans[0].centre;
    const HilbertFrame frame = *HilbertFrame::inMap(near, kResolution, kSpacing, {});
    RayCounts counts;
    const HilbertTrainingSet set = trainingSetOf(scan, limits, sampling.rules(), frame, &counts);

    // By the definition, in the map's own coordinates.
    std::set<Key> hits;
    const SelectedRays rays = selectRays(scan, limits);
    std::vector<Eigen::Vector3d> samples;
    for (const RayFan& fan : rays.scan.fans)
    {
      std::map<Key, std::vector<Eigen::Vector3d>> hitGroups, freeGroups;
      for (const Ray& ray : fan.rays)
      {
        const bool returned = ray.meaning == RayEnd::Return;
        const Eigen::Vector3d end = returned ? ray.end : Eigen::Vector3d(fan.centre + ray.end);
        (returned ? hitGroups : freeGroups)[keyOf(end, kResolution)].push_back(end);
      }
      const auto sample = [&](const std::vector<Eigen::Vector3d>& group, double margin)
      {
        Eigen::Vector3d mean = Eigen::Vector3d::Zero();
        for (const auto& end : group) mean += end / static_cast<double>(group.size());
        const Eigen::Vector3d ray = mean - fan.centre;
        for (double t = ray.norm() - margin; t >= 0; t -= sampling.freeResolution)
          samples.push_back(fan.centre + ray.normalized() * t);
      };
      for (const auto& [key, group] : hitGroups)
      {
        hits.insert(key);
        sample(group, sampling.freeMargin);
      }
      for (const auto& [key, group] : freeGroups) sample(group, 0);
    }
    std::set<Key> frees;
    for (const auto& place : samples)
      if (hits.count(keyOf(place, kResolution)) == 0) frees.insert(keyOf(place, kResolution));
    GlancingSurfaces surfaces;
    for (const RayFan& fan : rays.scan.fans)
      for (const GlancingSurfaces::Piece& piece : surfaces.of(fan))
      {
        const Eigen::Vector3d along = piece.end - piece.begin;
        const int parts = static_cast<int>(2 * along.norm() / kResolution) + 1;
        for (int i = 1; i < parts; ++i) frees.erase(keyOf(piece.begin + along * i / parts, kResolution));
      }

    std::set<Key> isHit, isFree;
    for (size_t i = 0; i < set.size(); ++i)
    {
      const Eigen::Vector3d place = set.points[i] + anchorCorner(frame);
      const Key key = keyOf(place, kResolution);
      const Eigen::Vector3d centre =
          kResolution *
          Eigen::Vector3d(std::get<0>(key) + 0.5, std::get<1>(key) + 0.5, std::get<2>(key) + 0.5);
      ASSERT_LT((place - centre).norm(), 1e-7);
      ASSERT_TRUE((set.labels[i] > 0.5f ? isHit : isFree).insert(key).second) << "a cell twice";
      ASSERT_EQ(set.weights[i], set.labels[i] > 0.5f ? 2.0f : 1.0f);
    }
    EXPECT_EQ(isHit, hits);
    EXPECT_EQ(isFree, frees);
    EXPECT_EQ(counts.used(), rays.counts.used());
    EXPECT_GT(counts.leftOut(), 0u);
  }
}

TEST(HilbertTrainingSet, UnusableRaysAreCountedAndLeftOut)
{
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const Scan scan = scanWith({fanOf({0, 0, 0}, {{nan, 0, 0}, {0, inf, 0}, {0, 0, 0}, {1e7, 0, 0}})});
  const HilbertFrame frame = *HilbertFrame::inMap({0, 0, 0}, 0.1, kSpacing, {});
  for (const HilbertPoints kind : {HilbertPoints::Cells, HilbertPoints::Points})
  {
    HilbertSampling sampling;
    sampling.trainingPoints = kind;
    RayCounts counts;
    EXPECT_EQ(trainingSetOf(scan, {}, sampling.rules(), frame, &counts).size(), 0u);
    EXPECT_EQ(counts.notFinite, 2u);
    EXPECT_EQ(counts.tooNear, 1u);
    EXPECT_EQ(counts.outside, 1u);
    EXPECT_EQ(counts.used(), 0u);
  }
}

TEST(HilbertInference, RefusesBadSampling)
{
  const auto refused = [](auto&& change)
  {
    HilbertInference inference;
    change(inference);
    EXPECT_THROW(inference.validate({}), std::invalid_argument);
  };
  refused([](HilbertSampling& s) { s.freeMargin = -1; });
  refused([](HilbertSampling& s) { s.freeResolution = 0; });
  refused([](HilbertSampling& s) { s.freeResolution = std::nan(""); });
  refused([](HilbertSampling& s) { s.hitWeight = 0; });
  refused([](HilbertSampling& s) { s.freeWeight = -0.1; });
  EXPECT_NO_THROW(HilbertInference{}.validate({}));
}

// A width is in cells of 0.125 m, and the same along all axes; the plane of a planar map has no thickness.
TEST(HilbertTrainingSet, TakesWidthsAndUncertainty)
{
  const HilbertFrame frame = *HilbertFrame::inMap({0, 0, 0}, kResolution, kSpacing, {});
  HilbertTrainingSet set;
  set.add(TrainingPoint{{0, 0, 0}, true, 2, 0}, frame);
  EXPECT_TRUE(set.covariances.empty());
  set.add(TrainingPoint{{1, 0, 0}, false, 1, 2}, frame);
  ASSERT_EQ(set.covariances.size(), 2u);
  EXPECT_TRUE(set.covariances[0].isZero(0));
  EXPECT_EQ(set.covariances[1], Eigen::Matrix3d(Eigen::Matrix3d::Identity() / 16));
  HilbertUncertainty uncertainty;
  uncertainty.point = Eigen::Vector3d(1, 4, 9).asDiagonal();
  set.blur(1, uncertainty, {1, 0, 0}, 2.0, true);
  EXPECT_TRUE(set.covariances[0].isZero(0));
  EXPECT_EQ(set.covariances[1],
            Eigen::Matrix3d(Eigen::Vector3d(1 + 1.0 / 16, 4 + 1.0 / 16, 1.0 / 16).asDiagonal()));
  // It weighs less by |I + 4·2·diag(1, 4, 0)|^(−1/2), the same point without uncertainty as before.
  EXPECT_EQ(set.weights[0], 2.0f);
  EXPECT_EQ(set.variances, (std::vector<float>{0, 2.5f}));
  EXPECT_NEAR(set.weights[1], 1 / std::sqrt(9.0 * 33.0), 1e-6);
}

// A point p moved by a pose (t, ω): p + t + ω × (p − centre), by drawing.
TEST(HilbertUncertainty, FollowsPosesRangesAndPoints)
{
  std::mt19937_64 engine(3);
  std::normal_distribution<double> normal;
  Random random(4);
  HilbertUncertainty uncertainty;
  Eigen::Matrix<double, 6, 6> root;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) root(i, j) = random.uniform(-0.02, 0.02);
  uncertainty.pose = root * root.transpose();
  uncertainty.pose = (uncertainty.pose + uncertainty.pose.transpose()).eval() / 2;
  uncertainty.centre = {1, 2, 3};
  uncertainty.rangeStd_m = 0.03;
  uncertainty.point = Eigen::Vector3d(1e-4, 4e-4, 0).asDiagonal();
  uncertainty.validate();
  const Eigen::Vector3d place(4, 1, 2.5), sensor(1, 2, 3.2);
  Eigen::Matrix3d drawn = Eigen::Matrix3d::Zero();
  constexpr int kDraws = 200000;
  for (int i = 0; i < kDraws; ++i)
  {
    Eigen::Matrix<double, 6, 1> unit;
    for (int j = 0; j < 6; ++j) unit[j] = normal(engine);
    const Eigen::Matrix<double, 6, 1> pose = root * unit;
    Eigen::Vector3d by = pose.head<3>() + pose.tail<3>().cross(place - uncertainty.centre);
    by += (place - sensor).normalized() * 0.03 * normal(engine);
    by.x() += 0.01 * normal(engine);
    by.y() += 0.02 * normal(engine);
    drawn += by * by.transpose() / kDraws;
  }
  EXPECT_LT((uncertainty.of(place, sensor) - drawn).cwiseAbs().maxCoeff(), 0.02 * drawn.trace());
  uncertainty.pose(0, 0) = -1;
  EXPECT_THROW(uncertainty.validate(), std::invalid_argument);
}

TEST(HilbertFrame, PutsCellsWhereTheyAre)
{
  for (unsigned seed = 1; seed <= seeds(200); ++seed)
  {
    Random random(seed);
    const double resolution = random.pick<double>({0.1, 0.125, 0.05, 0.3, 1.0});
    const Eigen::Vector3d near = random.inCube(random.pick<double>({1, 1000, 1e6}));
    const auto frame = HilbertFrame::inMap(near, resolution, kSpacing, {});
    ASSERT_TRUE(frame);
    const Eigen::Vector3d local = *frame->cells.toLocal(near);
    const Eigen::Vector3d place = frame->position(local) + anchorCorner(*frame);
    EXPECT_LT((place - near).norm(), 1e-6);
    EXPECT_LT(frame->position(local).norm(), 3 * (resolution + kSpacing));
  }
  EXPECT_FALSE(HilbertFrame::inMap({1e15, 0, 0}, 0.1, kSpacing, {}));
  EXPECT_FALSE(HilbertFrame::inMap({std::nan(""), 0, 0}, 0.1, kSpacing, {}));
}
}  // namespace
}  // namespace lamap::test
