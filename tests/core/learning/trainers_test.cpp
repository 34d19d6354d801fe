// L-BFGS and SGD, against Newton's method on dense features and against each other.
#include <gtest/gtest.h>
#include <lamap_core/features/nystroem.h>
#include <lamap_core/features/nystroem_rows.h>
#include <lamap_core/features/rows.h>
#include <lamap_core/learning/lbfgs.h>
#include <lamap_core/learning/sgd.h>
#include <support/hilbert_oracle.h>
#include <support/logistic_oracle.h>
#include <support/seeded_scans.h>
#include <support/seeds.h>

#include <array>
#include <cmath>

namespace lamap::test
{
namespace
{
constexpr double kSpacing = 0.25;

struct Built
{
  HilbertTrainingSet set;
  CompactRows compact;
  Eigen::MatrixXd dense;

  Built(Random& random, size_t points, double halfEdge_m)
  {
    set = randomTrainingSet(random, points, halfEdge_m);
    compact.findSites(set, CompactKernel(), kSpacing, false, {});
    compact.build(set, Workers(1));
    std::vector<Eigen::Vector3d> centres;
    for (const CellIndex& site : compact.numbers().sites())
      centres.push_back(kSpacing * Eigen::Vector3d(site.x + 0.5, site.y + 0.5, site.z + 0.5));
    dense = denseCompactFeatures(set.points, centres, 14, 0.03);
  }
};

TEST(LbfgsProperty, ReachesTheMinimumOfNewtonsMethod)
{
  for (unsigned seed = 1; seed <= seeds(10); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    Built built(random, 300, 0.8);
    FeatureRows& rows = built.compact.rows();
    std::vector<float> mean(rows.weights(), 0.0f), precision(rows.weights(), 0.0f);
    DensePosterior prior{Eigen::VectorXd(built.dense.cols()), Eigen::VectorXd(built.dense.cols())};
    for (size_t j = 0; j < rows.used().size(); ++j)
    {
      prior.mean[static_cast<long>(j)] = mean[rows.used()[j]] = static_cast<float>(random.uniform(-1, 1));
      prior.precision[static_cast<long>(j)] = precision[rows.used()[j]] =
          static_cast<float>(random.uniform(0.1, 4));
    }
    const LogisticProblem problem{rows, built.set.labels, built.set.weights, mean, precision};
    const DensePosterior oracle = denseLaplace(built.dense, built.set, prior);
    const double least = denseObjective(built.dense, built.set, prior, oracle.mean);
    Lbfgs lbfgs;
    const Workers workers(1);
    double last = objectiveOf(problem, mean);
    for (const int iterations : {1, 3, 10, 25, 200})
    {
      std::vector<float> u = mean;
      lbfgs.minimize(problem, iterations, u, workers);
      const double reached = objectiveOf(problem, u);
      EXPECT_LE(reached, last * (1 + 1e-6)) << "after " << iterations;
      last = reached;
      EXPECT_LE(reached, least * (iterations < 10 ? 10 : iterations < 25 ? 1.01 : 1.001));
      if (iterations < 200) continue;
      EXPECT_LE(reached, least * (1 + 1e-5));
      std::vector<float> diagonal;
      lbfgs.finalCurvature(problem, diagonal, workers);
      for (size_t j = 0; j < rows.used().size(); ++j)
      {
        const auto at = static_cast<long>(j);
        ASSERT_NEAR(u[rows.used()[j]], oracle.mean[at], 0.02);
        ASSERT_NEAR(diagonal[rows.used()[j]], oracle.precision[at], 0.01 * oracle.precision[at]);
      }
    }
  }
}

TEST(Trainers, SgdAndLbfgsReachTheSameObjectiveForTheSameL2Penalty)
{
  for (unsigned seed = 1; seed <= 4; ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    HilbertTrainingSet set = randomTrainingSet(random, 600, 0.7);
    const Workers workers(1);
    CompactRows compact;
    compact.findSites(set, CompactKernel(), kSpacing, false, {});
    compact.build(set, workers);
    FeatureRows nystroem;
    NystroemFeatures(set.points, 60, 3.0, seed).rowsOf(set, nystroem, workers);
    for (FeatureRows* rows : {&compact.rows(), &nystroem})
    {
      SCOPED_TRACE(rows == &nystroem ? "nystroem" : "compact");
      constexpr double kAlpha = 2e-3;
      std::vector<float> mean(rows->weights(), 0.0f), precision(rows->weights(), 0.0f);
      for (const uint32_t j : rows->used())
        if (rows->bias() != j) precision[j] = static_cast<float>(kAlpha * static_cast<double>(set.size()));
      const LogisticProblem problem{*rows, set.labels, set.weights, mean, precision};
      std::vector<float> byLbfgs = mean, bySgd = mean;
      Lbfgs().minimize(problem, 300, byLbfgs, workers);
      trainSgd(*rows, set.labels, set.weights, {{kAlpha, 300}, SgdPenalty::L2, seed}, 0, bySgd);
      const double least = objectiveOf(problem, byLbfgs);
      const double reached = objectiveOf(problem, bySgd);
      EXPECT_LE(reached, least * 1.01);
      EXPECT_GE(reached, least * 0.9999);
      EXPECT_LT(least, 0.9 * objectiveOf(problem, mean));
    }
  }
}

double objectiveWithL1(const Built& built, const std::vector<float>& u, double alpha)
{
  const FeatureRows& rows = const_cast<Built&>(built).compact.rows();
  double sum = 0, penalty = 0;
  for (size_t i = 0; i < built.set.size(); ++i)
  {
    const double f = static_cast<double>(rows.dot(i, u.data())) * (built.set.labels[i] > 0.5f ? 1 : -1);
    sum += static_cast<double>(built.set.weights[i]) * std::log1p(std::exp(-f));
  }
  for (const float weight : u) penalty += std::abs(static_cast<double>(weight));
  return sum / static_cast<double>(built.set.size()) + alpha * penalty;
}

// Thesis eq. 2.34: more penalty, more weights that are exactly zero; and no single weight can better it.
TEST(Sgd, WithL1FindsASparseMinimum)
{
  Random random(5);
  Built built(random, 500, 0.7);
  FeatureRows& rows = built.compact.rows();
  size_t lastZeros = 0;
  for (const double alpha : {1e-4, 1e-2, 1e-1})
  {
    SCOPED_TRACE(alpha);
    std::vector<float> u(rows.weights(), 0.0f);
    trainSgd(rows, built.set.labels, built.set.weights, {{alpha, 400}, SgdPenalty::L1, 3}, 0, u);
    size_t zeros = 0;
    for (const uint32_t j : rows.used()) zeros += u[j] == 0.0f;
    EXPECT_GE(zeros, lastZeros);
    lastZeros = zeros;
    if (alpha < 1e-3) continue;
    const double reached = objectiveWithL1(built, u, alpha);
    for (const uint32_t j : rows.used())
      for (const float by : {-0.1f, 0.1f})
      {
        std::vector<float> other = u;
        other[j] += by;
        ASSERT_GE(objectiveWithL1(built, other, alpha), reached - 2e-3 * reached);
      }
  }
  EXPECT_GT(lastZeros, rows.used().size() / 4);
}

// The bias alone is free of penalties: with all else forbidden it learns how many points are hits.
TEST(Sgd, PenalizesNoBias)
{
  Random random(8);
  HilbertTrainingSet set;
  for (int i = 0; i < 400; ++i) set.add(random.inCube(1), i % 4 != 0, 1.0);
  const NystroemFeatures features(set.points, 10, 3.0, 1);
  FeatureRows rows;
  features.rowsOf(set, rows, Workers(1));
  for (const SgdPenalty penalty : {SgdPenalty::L1, SgdPenalty::L2})
  {
    std::vector<float> u(rows.weights(), 0.0f);
    trainSgd(rows, set.labels, set.weights, {{1.0, 200}, penalty, 1}, 0, u);
    EXPECT_NEAR(u[*rows.bias()], std::log(3.0), 0.15);
    for (size_t j = 0; j < features.components(); ++j) EXPECT_NEAR(u[j], 0.0, 0.3);
  }
}

TEST(Sgd, IsRepeatedByItsSeedAndRefusesBadOptions)
{
  Random random(6);
  Built built(random, 200, 0.5);
  const FeatureRows& rows = built.compact.rows();
  const auto trained = [&](uint64_t seed)
  {
    std::vector<float> u(rows.weights(), 0.0f);
    trainSgd(rows, built.set.labels, built.set.weights, {{1e-4, 3}, SgdPenalty::L1, seed}, 0, u);
    return u;
  };
  EXPECT_EQ(trained(1), trained(1));
  EXPECT_NE(trained(1), trained(2));
  std::vector<float> u(rows.weights(), 0.0f);
  EXPECT_EQ(trainSgd(rows, built.set.labels, built.set.weights, {{1e-4, 3}, SgdPenalty::L2, 1}, 7, u), 607u);
  EXPECT_THROW(trainSgd(rows, built.set.labels, built.set.weights, {{0.0, 1}, SgdPenalty::L1, 1}, 0, u),
               std::invalid_argument);
  EXPECT_THROW(trainSgd(rows, built.set.labels, built.set.weights, {{1e-4, 0}, SgdPenalty::L1, 1}, 0, u),
               std::invalid_argument);
}

// Nyström with all points inducing is the full kernel (thesis 2.4.2), but for the jitter.
TEST(NystroemProperty, WithAllPointsInducingReproducesTheKernelMatrix)
{
  for (unsigned seed = 1; seed <= seeds(5); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    const HilbertTrainingSet set = randomTrainingSet(random, 120, random.pick<double>({0.2, 1.0, 3.0}));
    const double gamma = random.pick<double>({3, 10});
    for (const size_t components : {size_t{120}, size_t{1000}})
    {
      const NystroemFeatures features(set.points, components, gamma, seed);
      EXPECT_EQ(features.components(), 120u);
      FeatureRows rows;
      features.rowsOf(set, rows, Workers(1));
      for (size_t i = 0; i < set.size(); ++i)
        for (size_t j = 0; j <= i; ++j)
        {
          double product = 0;
          for (size_t k = 0; k < features.components(); ++k)
            product += static_cast<double>(rows.valuesOf(i)[k]) * rows.valuesOf(j)[k];
          ASSERT_NEAR(product, std::exp(-gamma * (set.points[i] - set.points[j]).squaredNorm()),
                      NystroemFeatures::kJitter + 1e-4);
        }
    }
  }
}

TEST(NystroemRows, AreTheSameWithNarrowRegisters)
{
  if (!hasAvx2()) GTEST_SKIP() << "this processor has only narrow registers";
  Random random(4);
  for (const size_t components : {size_t{1}, size_t{15}, size_t{16}, size_t{17}, size_t{50}})
  {
    SCOPED_TRACE(components);
    std::array<std::vector<float>, 3> inducing;
    for (auto& axis : inducing)
      for (size_t k = 0; k < components; ++k) axis.push_back(static_cast<float>(random.uniform(-1, 1)));
    std::vector<double> inverse(components * components, 0.0);
    for (size_t row = 0; row < components; ++row)
      for (size_t column = 0; column <= row; ++column)
        inverse[row * components + column] = random.uniform(-2, 2);
    const NystroemRows rows(inducing, inverse, 3);
    std::array<std::vector<float>, 2> features;
    for (const bool wide : {false, true})
    {
      std::vector<float> kernels(NystroemRows::kAtOnce * rows.stride());
      for (size_t p = 0; p < NystroemRows::kAtOnce; ++p)
        rows.kernelsOf({0.1F * static_cast<float>(p), 0.2F, -0.3F}, kernels.data() + p * rows.stride(), wide);
      features[wide].resize(kernels.size());
      rows.featuresOf(kernels.data(), features[wide].data(), wide);
      for (size_t p = 0; p < NystroemRows::kAtOnce; ++p)
        for (size_t row = 0; row < components; ++row)
        {
          double sum = 0;
          for (size_t k = 0; k < components; ++k)
            sum += inverse[row * components + k] * kernels[p * rows.stride() + k];
          ASSERT_NEAR(features[wide][p * rows.stride() + row], sum, 1e-4);
        }
    }
    EXPECT_EQ(features[0], features[1]);
  }
}

// Columns of the inverse are dealt to threads from 512 components on.
TEST(Nystroem, ManyComponentsAreFactorizedByManyThreadsAsByOne)
{
  Random random(6);
  const HilbertTrainingSet set = randomTrainingSet(random, 700, 2.0);
  const NystroemFeatures features(set.points, 700, 10, 1);
  FeatureRows rows;
  features.rowsOf(set, rows, Workers(1));
  for (size_t i = 0; i < set.size(); i += 7)
    for (size_t j = 0; j <= i; j += 5)
    {
      double product = 0;
      for (size_t k = 0; k < features.components(); ++k)
        product += static_cast<double>(rows.valuesOf(i)[k]) * rows.valuesOf(j)[k];
      ASSERT_NEAR(product, std::exp(-10 * (set.points[i] - set.points[j]).squaredNorm()),
                  NystroemFeatures::kJitter + 1e-4);
    }
}

TEST(NystroemProperty, FoldedClassifierEqualsItsFeatures)
{
  for (unsigned seed = 1; seed <= seeds(8); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    HilbertTrainingSet set = randomTrainingSet(random, 250, 1.5);
    const NystroemFeatures features(set.points, 40, 3.0, seed);
    EXPECT_EQ(features.components(), 40u);
    FeatureRows rows;
    features.rowsOf(set, rows, Workers(1));
    std::vector<float> u(rows.weights(), 0.0f);
    for (size_t j = 0; j <= 40; ++j) u[j] = static_cast<float>(random.uniform(-1, 1));
    const NystroemFeatures::Folded folded = features.fold(u);
    for (size_t i = 0; i < set.size(); ++i)
      ASSERT_NEAR(rows.dot(i, u.data()), features.logoddsAt(folded, set.points[i]), 1e-3);

    const RegularPoints points{random.inCube(2), 0.17, {19, 5, 3}};
    std::vector<float> block;
    features.logoddsAt(folded, points, block, Workers(1));
    ASSERT_EQ(block.size(), 19u * 5 * 3);
    for (int z = 0; z < 3; ++z)
      for (int y = 0; y < 5; ++y)
        for (int x = 0; x < 19; ++x)
          ASSERT_NEAR(block[static_cast<size_t>((z * 5 + y) * 19 + x)],
                      features.logoddsAt(folded, points.first + 0.17 * Eigen::Vector3d(x, y, z)), 1e-3);
  }
}

TEST(Nystroem, UncertainPointsHaveExpectedFeatures)
{
  Random random(3);
  HilbertTrainingSet set = randomTrainingSet(random, 60, 1.0);
  const NystroemFeatures features(set.points, 20, 3.0, 1);
  std::vector<float> u(features.weightCount(), 0.0f);
  for (size_t j = 0; j <= 20; ++j) u[j] = static_cast<float>(random.uniform(-1, 1));
  const NystroemFeatures::Folded folded = features.fold(u);
  for (size_t i = 0; i < set.size(); ++i)
    set.covariances.push_back(Eigen::Vector3d(0.04, 0.01, random.uniform(0, 0.1)).asDiagonal());
  FeatureRows rows;
  features.rowsOf(set, rows, Workers(1));
  std::mt19937_64 engine(5);
  std::normal_distribution<double> normal;
  for (size_t i = 0; i < set.size(); i += 12)
  {
    const double expected = features.logoddsAt(folded, set.points[i], set.covariances[i]);
    EXPECT_NEAR(rows.dot(i, u.data()), expected, 1e-3);
    double sum = 0, squares = 0;
    constexpr int kDraws = 20000;
    for (int draw = 0; draw < kDraws; ++draw)
    {
      const double x = normal(engine), y = normal(engine), z = normal(engine);
      const Eigen::Vector3d by =
          set.covariances[i].diagonal().cwiseSqrt().cwiseProduct(Eigen::Vector3d(x, y, z));
      const double f = features.logoddsAt(folded, set.points[i] + by);
      sum += f;
      squares += f * f;
    }
    const double error = std::sqrt((squares / kDraws - sum * sum / kDraws / kDraws) / kDraws);
    EXPECT_NEAR(expected, sum / kDraws, 5 * error);
  }
}

TEST(Nystroem, TakesCoincidingPointsAndRefusesNone)
{
  HilbertTrainingSet set;
  for (int i = 0; i < 30; ++i) set.add({1, 2, 3}, i % 2 == 0, 1.0);
  const NystroemFeatures features(set.points, 20, 3.0, 1);
  FeatureRows rows;
  features.rowsOf(set, rows, Workers(1));
  std::vector<float> u(rows.weights(), 0.0f), zero = u, ones(rows.weights(), 0.1f);
  Lbfgs().minimize({rows, set.labels, set.weights, zero, ones}, 25, u, Workers(1));
  EXPECT_NEAR(features.logoddsAt(features.fold(u), {1, 2, 3}), 0.0, 0.05);
  EXPECT_THROW(NystroemFeatures(std::vector<Eigen::Vector3d>{}, 3, 3.0, 1), std::invalid_argument);
  EXPECT_THROW(NystroemFeatures(set.points, 0, 3.0, 1), std::invalid_argument);
  EXPECT_THROW(NystroemFeatures(set.points, 3, 0.0, 1), std::invalid_argument);
}
}  // namespace
}  // namespace lamap::test
