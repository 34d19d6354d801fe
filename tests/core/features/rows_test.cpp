// Compact features in sparse rows, against dense features from the equation.
#include <gtest/gtest.h>
#include <lamap_core/features/compact_kernel.h>
#include <lamap_core/features/rows.h>
#include <lamap_core/learning/lbfgs.h>
#include <lamap_core/learning/sgd.h>
#include <support/hilbert_oracle.h>
#include <support/logistic_oracle.h>
#include <support/seeded_scans.h>
#include <support/seeds.h>

#include <Eigen/LU>

#include <cmath>
#include <set>
#include <tuple>

namespace lamap::test
{
namespace
{
constexpr double kSpacing = 0.25;

struct Built
{
  HilbertTrainingSet set;
  CompactRows compact;
  std::vector<Eigen::Vector3d> centres;
};

Eigen::Vector3d centreOf(const CellIndex& site, const CellIndex& shift, double spacing)
{
  return spacing * Eigen::Vector3d(site.x - shift.x + 0.5, site.y - shift.y + 0.5, site.z - shift.z + 0.5);
}

void build(Built& built, const CompactKernel& kernel, double spacing, const CellIndex& shift,
           unsigned threads = 1)
{
  built.compact.findSites(built.set, kernel, spacing, false, shift);
  built.compact.build(built.set, Workers(threads));
  built.centres.clear();
  for (const CellIndex& site : built.compact.numbers().sites())
    built.centres.push_back(centreOf(site, shift, spacing));
}

TEST(CompactKernel, MatchesItsFormulaAndIsNothingBeyondTheSupport)
{
  const CompactKernel kernel;
  EXPECT_NEAR(kernel.support_m(), std::sqrt(std::log(1 / 0.03) / 14), 1e-14);
  EXPECT_NEAR(kernel.at({0, 0, 0}), 0.97, 1e-7);
  EXPECT_NEAR(kernel.at({0.1, 0.2, -0.2}), std::exp(-14 * 0.09) - 0.03, 1e-7);
  EXPECT_EQ(kernel.at({kernel.support_m(), 0, 0}), 0.0f);
  EXPECT_EQ(kernel.at({0.3, 0.3, 0.3}), 0.0f);
  for (const double bad : {0.0, -1.0, std::nan("")})
    EXPECT_THROW(CompactKernel(bad, 0.03), std::invalid_argument);
  for (const double bad : {0.0, 1.0, -0.1}) EXPECT_THROW(CompactKernel(14, bad), std::invalid_argument);
  EXPECT_THROW(AxisReaches(kernel, 0.01), std::invalid_argument);
}

TEST(CompactRowsProperty, SitesAreThoseThatHoldAPoint)
{
  for (unsigned seed = 1; seed <= seeds(20); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    Built built;
    built.set = randomTrainingSet(random, 200, random.uniform(0.1, 3));
    build(built, CompactKernel(), kSpacing, {3, 7, -9});
    std::set<std::tuple<int, int, int>> expected, is;
    for (const Eigen::Vector3d& point : built.set.points)
      expected.insert({std::floor(point.z() / kSpacing) - 9, std::floor(point.y() / kSpacing) + 7,
                       std::floor(point.x() / kSpacing) + 3});
    std::vector<std::tuple<int, int, int>> inOrder;
    for (const CellIndex& site : built.compact.numbers().sites()) inOrder.push_back({site.z, site.y, site.x});
    EXPECT_TRUE(std::is_sorted(inOrder.begin(), inOrder.end()));
    is.insert(inOrder.begin(), inOrder.end());
    EXPECT_EQ(is.size(), inOrder.size());
    EXPECT_EQ(is, expected);
  }
}

TEST(CompactRowsProperty, ProductsEqualThoseOfDenseFeatures)
{
  for (unsigned seed = 1; seed <= seeds(30); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    Built built;
    const double spacing = random.pick<double>({0.25, 0.2, 0.31});
    const CompactKernel kernel(random.pick<double>({14, 6, 30}), random.pick<double>({0.03, 0.1}));
    built.set =
        randomTrainingSet(random, static_cast<size_t>(random.integer(1, 400)), random.uniform(0.05, 2));
    build(built, kernel, spacing, {1, 2, 3});
    const Eigen::MatrixXd dense =
        denseCompactFeatures(built.set.points, built.centres, kernel.gamma(), kernel.cutoff());
    FeatureRows& rows = built.compact.rows();
    const std::vector<uint32_t>& used = rows.used();
    ASSERT_EQ(used.size(), built.centres.size());

    std::vector<float> u(rows.weights(), 0.0f), f(rows.points()), r(rows.points()), g(rows.weights());
    Eigen::VectorXd denseU(used.size()), denseR(rows.points());
    for (size_t j = 0; j < used.size(); ++j)
      denseU[static_cast<long>(j)] = u[used[j]] = static_cast<float>(random.uniform(-1, 1));
    for (size_t i = 0; i < r.size(); ++i)
      denseR[static_cast<long>(i)] = r[i] = static_cast<float>(random.uniform(0, 1));
    const Workers workers(1);
    rows.multiply(u.data(), f.data(), workers);
    const Eigen::VectorXd expectedF = dense * denseU;
    for (size_t i = 0; i < f.size(); ++i)
    {
      ASSERT_NEAR(f[i], expectedF[static_cast<long>(i)], 1e-5) << i;
      ASSERT_NEAR(rows.dot(i, u.data()), f[i], 1e-6);
    }
    const auto compareColumns = [&](const Eigen::VectorXd& expected)
    {
      double inUse = 0, all = 0;
      for (size_t j = 0; j < used.size(); ++j)
      {
        ASSERT_NEAR(g[used[j]], expected[static_cast<long>(j)], 2e-5 * (1 + expected.cwiseAbs().maxCoeff()));
        inUse += std::abs(g[used[j]]);
      }
      for (const float entry : g) all += std::abs(entry);
      EXPECT_NEAR(inUse, all, 1e-9) << "numbers between those of features are not left alone";
    };
    rows.multiplyTransposed(r.data(), g.data(), workers);
    compareColumns(dense.transpose() * denseR);
    rows.addSquares(r.data(), g.data(), workers);
    compareColumns(dense.array().square().matrix().transpose() * denseR);
  }
}

TEST(CompactRowsProperty, MoreSitesMayBeInserted)
{
  Random random(4);
  Built built;
  built.set = randomTrainingSet(random, 60, 0.8);
  const CompactKernel kernel;
  built.compact.findSites(built.set, kernel, kSpacing, false, {});
  SiteSet& sites = built.compact.sites();
  const size_t holding = sites.size();
  sites.dilate(built.compact.reach_sites(), false);
  EXPECT_GT(sites.size(), holding);
  built.compact.build(built.set, Workers(1));
  for (const CellIndex& site : built.compact.numbers().sites())
    built.centres.push_back(centreOf(site, {}, kSpacing));
  const Eigen::MatrixXd dense = denseCompactFeatures(built.set.points, built.centres, 14, 0.03);
  std::vector<float> u(built.compact.rows().weights(), 0.0f), f(built.set.size());
  for (const uint32_t j : built.compact.rows().used()) u[j] = 1;
  built.compact.rows().multiply(u.data(), f.data(), Workers(1));
  for (size_t i = 0; i < f.size(); ++i) EXPECT_NEAR(f[i], dense.row(static_cast<long>(i)).sum(), 1e-5);
}

TEST(SiteSetProperty, DilatesToABoxAroundEachSite)
{
  for (unsigned seed = 1; seed <= seeds(10); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    const int steps = random.integer(1, 3);
    const bool flat = random.chance(0.3);
    std::vector<CellIndex> inserted;
    SiteSet sites;
    sites.reset({-30, -30, -30}, {30, 30, 30});
    for (int i = 0; i < 12; ++i)
    {
      inserted.push_back({random.integer(-20, 20), random.integer(-20, 20), random.integer(-20, 20)});
      sites.insert(inserted.back());
    }
    sites.dilate(steps, flat);
    size_t count = 0;
    for (int z = -25; z <= 25; ++z)
      for (int y = -25; y <= 25; ++y)
        for (int x = -25; x <= 25; ++x)
        {
          const bool expected = std::any_of(inserted.begin(), inserted.end(),
                                            [&](const CellIndex& site)
                                            {
                                              return std::abs(site.x - x) <= steps &&
                                                     std::abs(site.y - y) <= steps &&
                                                     std::abs(site.z - z) <= (flat ? 0 : steps);
                                            });
          count += expected;
          ASSERT_EQ(sites.contains({x, y, z}), expected) << x << ", " << y << ", " << z;
        }
    EXPECT_EQ(sites.size(), count);
  }
}

Eigen::Matrix3d randomCovariance(Random& random, double std_m)
{
  Eigen::Matrix3d root;
  for (int i = 0; i < 3; ++i) root.col(i) = random.inCube(std_m);
  return root * root.transpose();
}

// E[exp(−γ|x − c|²)] by drawing, against the closed form; the compact kernel's cut comes after the
// expectation, so it may fall short of the drawn mean by its cutoff and no more.
TEST(ExpectedKernel, AgreesWithMonteCarlo)
{
  std::mt19937_64 engine(7);
  std::normal_distribution<double> normal;
  Random random(8);
  for (int trial = 0; trial < 12; ++trial)
  {
    SCOPED_TRACE(trial);
    const double gamma = random.pick<double>({3, 14});
    const CompactKernel kernel(gamma, 0.03);
    Eigen::Matrix3d root;
    for (int i = 0; i < 3; ++i) root.col(i) = random.inCube(0.15);
    const Eigen::Vector3d mean = random.inCube(0.3);
    constexpr int kDraws = 200000;
    double sum = 0, squares = 0, compact = 0;
    for (int i = 0; i < kDraws; ++i)
    {
      const double a = normal(engine), b = normal(engine), c = normal(engine);
      const Eigen::Vector3d drawn = mean + root * Eigen::Vector3d(a, b, c);
      const double k = std::exp(-gamma * drawn.squaredNorm());
      sum += k;
      squares += k * k;
      compact += std::max(0.0, k - 0.03);
    }
    const double drawnMean = sum / kDraws;
    const double error = std::sqrt((squares / kDraws - drawnMean * drawnMean) / kDraws);
    const GaussianBlur blur(root * root.transpose(), gamma);
    EXPECT_NEAR(blur.factor * std::exp(-gamma * blur.squaredDistance(mean)), drawnMean, 5 * error + 1e-9);
    EXPECT_LE(kernel.at(mean, blur), compact / kDraws + 5 * error);
    EXPECT_GE(kernel.at(mean, blur), compact / kDraws - 0.03 - 5 * error);
  }
  const GaussianBlur none(Eigen::Matrix3d::Zero(), 14);
  EXPECT_NEAR(CompactKernel().at({0.1, 0.2, 0.1}, none), CompactKernel().at({0.1, 0.2, 0.1}), 1e-7);
}

TEST(ExpectedKernel, ReachIsTheBoxOfWhatIsNotZero)
{
  Random random(9);
  const CompactKernel kernel;
  for (int trial = 0; trial < 20; ++trial)
  {
    const GaussianBlur blur(randomCovariance(random, random.uniform(0.01, 0.3)), kernel.gamma());
    const Eigen::Vector3d reach = kernel.reach_m(blur);
    Eigen::Vector3d farthest = Eigen::Vector3d::Zero();
    for (int i = 0; i < 20000; ++i)
    {
      const Eigen::Vector3d d = random.inCube(1.2 * reach.maxCoeff() + 1e-6);
      if (kernel.at(d, blur) > 0) farthest = farthest.cwiseMax(d.cwiseAbs());
    }
    EXPECT_TRUE((farthest.array() <= reach.array() + 1e-9).all());
    EXPECT_GE(farthest.maxCoeff(), 0.7 * reach.maxCoeff());
  }
  EXPECT_EQ(kernel.reach_m(GaussianBlur(Eigen::Matrix3d::Identity() * 100, 14)), Eigen::Vector3d(0, 0, 0));
}

TEST(CompactRowsProperty, UncertainPointsHaveExpectedFeatures)
{
  for (unsigned seed = 1; seed <= seeds(10); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    Built built;
    built.set = randomTrainingSet(random, 80, 1.0);
    for (size_t i = 0; i < built.set.size(); ++i)
      built.set.covariances.push_back(randomCovariance(random, random.pick<double>({0.0, 0.05, 0.2, 2.0})));
    const CompactKernel kernel;
    build(built, kernel, kSpacing, {5, 0, -1});
    FeatureRows& rows = built.compact.rows();
    std::vector<float> u(rows.weights(), 0.0f), f(rows.points());
    for (const uint32_t j : rows.used()) u[j] = static_cast<float>(random.uniform(-1, 1));
    rows.multiply(u.data(), f.data(), Workers(1));
    for (size_t i = 0; i < f.size(); ++i)
    {
      const Eigen::Matrix3d widened =
          Eigen::Matrix3d::Identity() + 2 * kernel.gamma() * built.set.covariances[i];
      double expected = 0;
      for (size_t j = 0; j < built.centres.size(); ++j)
      {
        const Eigen::Vector3d d = built.set.points[i] - built.centres[j];
        const double k =
            std::exp(-kernel.gamma() * d.dot(widened.inverse() * d)) / std::sqrt(widened.determinant());
        expected += std::max(0.0, k - 0.03) * static_cast<double>(u[rows.used()[j]]);
      }
      ASSERT_NEAR(f[i], expected, 1e-5) << i;
    }
  }
}

TEST(FeatureRows, AreSharedOutEvenlyInFewChunks)
{
  FeatureRows rows;
  for (const size_t points :
       {size_t{0}, size_t{1}, size_t{2048}, size_t{2049}, size_t{32768}, size_t{160000}})
  {
    SCOPED_TRACE(points);
    rows.reset(4, points, 4, {0, 1, 2});
    EXPECT_EQ(rows.chunkCount(), std::min<size_t>(16, (points + 2047) / 2048));
    size_t end = 0;
    for (size_t chunk = 0; chunk < rows.chunkCount(); ++chunk)
    {
      EXPECT_EQ(rows.firstPointOf(chunk), end);
      end = rows.endPointOf(chunk);
      const bool isLast = chunk + 1 == rows.chunkCount();
      EXPECT_TRUE(isLast || end - rows.firstPointOf(chunk) == std::max<size_t>(2048, (points + 15) / 16));
    }
    EXPECT_EQ(end, points);
  }
}

TEST(FeatureRowsProperty, ProductsGiveTheGradientAndCurvatureOfTheLogisticLoss)
{
  for (unsigned seed = 1; seed <= seeds(10); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    Built built;
    built.set = randomTrainingSet(random, 150, 0.7);
    build(built, CompactKernel(), kSpacing, {});
    FeatureRows& rows = built.compact.rows();
    std::vector<float> mean(rows.weights(), 0.0f), precision(rows.weights(), 0.0f), u(rows.weights(), 0.0f);
    for (const uint32_t j : rows.used())
    {
      mean[j] = static_cast<float>(random.uniform(-1, 1));
      precision[j] = static_cast<float>(random.uniform(0.1, 3));
      u[j] = static_cast<float>(random.uniform(-1, 1));
    }
    const LogisticProblem problem{rows, built.set.labels, built.set.weights, mean, precision};
    const std::vector<float> g = gradientOf(problem, u);
    const std::vector<float> curvature = curvatureOf(problem, u);
    for (const uint32_t j : rows.used())
    {
      constexpr float kStep = 0x1p-6f;
      std::vector<float> less = u, more = u;
      less[j] -= kStep;
      more[j] += kStep;
      const double width = static_cast<double>(more[j]) - less[j];
      const double below = objectiveOf(problem, less), above = objectiveOf(problem, more);
      ASSERT_NEAR(g[j], (above - below) / width, 2e-3 * (1 + std::abs(g[j])));
      const double second = (above - 2 * objectiveOf(problem, u) + below) / (width * width / 4);
      ASSERT_NEAR(curvature[j], second, 0.02 * (1 + second));
    }
  }
}
}  // namespace
}  // namespace lamap::test
