// GP maps against dense algebra: block by block, and as one plain GP.
#include <gtest/gtest.h>
#include <lamap_core/gp/map.h>
#include <lamap_core/gp/regression.h>
#include <lamap_core/gp/tile.h>
#include <lamap_core/math/portable_math.h>
#include <support/gp_oracle.h>
#include <support/random_gp_options.h>
#include <support/seeded_scans.h>
#include <support/seeds.h>

#include <algorithm>
#include <cmath>

namespace lamap::test
{
namespace
{
/// A scan of some twenty rays in a cube of a few blocks.
Scan smallScan(Random& random, double resolution)
{
  ScanRecipe recipe;
  recipe.halfEdge_m = 5 * resolution;
  recipe.clusterRadius_m = resolution;
  recipe.rays = 7;
  recipe.statedRanges = false;
  return randomScan(random, recipe);
}

TEST(GpMapProperty, BlocksSayWhatDenseAlgebraSays)
{
  for (unsigned seed = 1; seed <= seeds(60); ++seed)
  {
    Random random(seed);
    const GpStructure structure = randomGpStructure(random);
    GpInference inference = randomGpInference(random, structure.resolution);
    inference.maxPoints = 4096;
    SCOPED_TRACE("seed " + std::to_string(seed) + ": " + nameOf(structure, inference));
    const std::vector<Scan> scans{smallScan(random, structure.resolution),
                                  smallScan(random, structure.resolution)};
    GpMap map(structure);
    for (const Scan& scan : scans) map.insert(scan, inference, 1);
    ASSERT_EQ(differenceFromOracle(map, scans, inference), "");
  }
}

// Thesis section 2.3: with a block that holds everything, eq. (2.22), (2.23), (2.25) of all the data at once,
// and eq. (2.28), (2.29) as printed over the scans.
TEST(GpMapProperty, OneBlockForAllIsThePlainGp)
{
  for (unsigned seed = 1; seed <= seeds(8); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    GpStructure structure;
    structure.blockDepth = 6;
    structure.signalVariance = random.pick<double>({1.0, 0.4, 3.0});
    GpInference inference = randomGpInference(random, structure.resolution);
    inference.kernelSupport = 6.0;  // more than the block's diagonal
    inference.maxPoints = 4096;
    inference.protectHits = 0;  // else hits would stay where the GP forgets them
    inference.nested = random.chance(0.5);
    std::vector<Scan> scans;
    std::vector<OracleGp> gps;
    GpMap map(structure);
    for (int i = 0; i < 3; ++i)
    {
      ScanRecipe recipe;
      recipe.rays = 6;
      recipe.centre_map = {1.6, 1.6, 1.6};  // of the block
      scans.push_back(randomScan(random, recipe));
      if (map.insert(scans.back(), inference, 1).used() == 0) continue;
      const OraclePoints points = gpTrainingSetOf(scans.back(), structure, inference);
      if (points.labels.empty()) continue;
      gps.emplace_back(points, inference.lengthScale, structure.signalVariance, structure.noiseVariance);
    }
    ASSERT_FALSE(gps.empty());
    const auto k = static_cast<double>(gps.size());
    for (int i = 0; i < 25; ++i)
    {
      const CellIndex cell{random.integer(0, 31), random.integer(0, 31), random.integer(0, 31)};
      long double precision = -(k - 1) / structure.signalVariance;
      long double weighted = 0;
      for (const OracleGp& gp : gps)
      {
        const OracleGp::Normal said = gp.at(cellCentre(cell, structure.resolution));
        precision += 1 / said.variance;
        weighted += said.mean / said.variance;
      }
      const double variance = static_cast<double>(1 / precision);
      const double mean = static_cast<double>(weighted / precision);
      const double least = structure.resolvedMinVariance();
      const double prob = 1 / (1 + std::exp(-structure.squashGain * least * mean / variance));
      const auto estimate = map.cell(cell, inference.thresholds);
      ASSERT_TRUE(estimate);
      // Each scan's sums are rounded to 2^-20.
      const double tolerance = 1e-6 * k * std::max(1.0, variance * variance);
      EXPECT_NEAR(estimate->evidence[0], static_cast<double>(precision), 1e-6 * k);
      EXPECT_NEAR(estimate->evidence[1], mean, tolerance);
      EXPECT_NEAR(*estimate->variance, variance, tolerance);
      EXPECT_NEAR(estimate->prob, prob, tolerance);
    }
  }
}

// A GP of one point says μ = k·y/(σ_f² + σ_n²), σ² = σ_f² − k²/(σ_f² + σ_n²).
TEST(GpMapProperty, CommitteesOfSinglePointsAddUp)
{
  for (unsigned seed = 1; seed <= seeds(20); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    const GpStructure structure = randomGpStructure(random);
    GpInference inference = randomGpInference(random, structure.resolution);
    inference.maxPoints = 1;
    const Scan scan = smallScan(random, structure.resolution);
    GpMap map(structure);
    map.insert(scan, inference, 1);
    const GpInference resolved = inference.resolved(structure.resolution);
    const OraclePoints points = gpTrainingSetOf(scan, structure, inference);
    const std::set<Cell> hits = gpHitCellsOf(scan, structure, inference);
    map.visitCells(inference.thresholds,
                   [&](const CellIndex& cell, const CellEstimate& estimate)
                   {
                     const Eigen::Vector3d centre = cellCentre(cell, structure.resolution);
                     const double f = structure.signalVariance;
                     double precision = 1 / f, weighted = 0;
                     for (size_t i = 0; i < points.labels.size(); ++i)
                     {
                       const double distance = (points.places_map[i] - centre).norm();
                       if (std::abs(distance / *resolved.kernelSupport - 1) < 1e-6) return;
                       if (distance >= *resolved.kernelSupport) continue;
                       const auto k = static_cast<double>(
                           oracleMatern(static_cast<long double>(distance), inference.lengthScale, f));
                       const double variance = f - k * k / (f + structure.noiseVariance);
                       precision += 1 / variance - 1 / f;
                       weighted += k * points.labels[i] / (f + structure.noiseVariance) / variance;
                     }
                     if (hits.count({cell.x, cell.y, cell.z}) > 0)
                     {
                       precision = std::max(precision, 1 / f + 3 / structure.noiseVariance);
                       weighted = std::max(weighted, 3 / structure.noiseVariance);
                     }
                     ASSERT_NEAR(estimate.evidence[0], precision, 2e-6);
                     ASSERT_NEAR(estimate.evidence[1] * precision, weighted, 1e-4);
                   });
  }
}

// Squashed as in eq. (2.25), log-odds are linear in mean/variance: whoever adds them adds what the committee
// adds.
TEST(GpMapProperty, LogoddsOfScansAddUpToTheCommittees)
{
  for (unsigned seed = 1; seed <= seeds(20); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    GpStructure structure = randomGpStructure(random);
    structure.maxEvidence = 0;
    structure.pruning = Pruning::None;
    const GpInference inference = randomGpInference(random, structure.resolution);
    GpStructure other = structure;
    other.fusion = GpFusion::Bayes;
    GpMap bcm(structure), bayes(other);
    for (int i = 0; i < 3; ++i)
    {
      const Scan scan = smallScan(random, structure.resolution);
      bcm.insert(scan, inference, 1);
      bayes.insert(scan, inference, 1);
    }
    size_t cells = 0;
    bcm.visitCells(inference.thresholds,
                   [&](const CellIndex& cell, const CellEstimate& estimate)
                   {
                     ++cells;
                     const auto same = bayes.cell(cell, inference.thresholds);
                     ASSERT_TRUE(same);
                     ASSERT_NEAR(same->prob, estimate.prob, 1e-5 * (1 + structure.squash()));
                     ASSERT_FALSE(same->variance);
                   });
    EXPECT_GT(cells, 0u);
  }
}

TEST(GpCovariance, IsEquation224)
{
  const GpCovariance covariance(2.5, 1.7, 0);
  EXPECT_DOUBLE_EQ(covariance(0), 1.7);
  const double t = std::sqrt(3.0) * 3.0 / 2.5;
  EXPECT_NEAR(covariance(9.0), 1.7 * (1 + t) * std::exp(-t), 1e-14);
  EXPECT_NEAR(covariance(1e12), 0.0, 1e-300);
}

TEST(GpCovariance, TilesAndTablesHoldTheSameBits)
{
  const GpCovariance direct(3.1, 0.8, 0), tabulated(3.1, 0.8, 12);
  for (int first = 0; first + 8 <= 3 * 12 * 12; first += 8)
  {
    GpTile a, b;
    for (size_t c = 0; c < 8; ++c) a[c] = b[c] = first + static_cast<int>(c);
    direct.replace(1, &a);
    tabulated.replace(1, &b);
    for (size_t c = 0; c < 8; ++c)
    {
      ASSERT_EQ(a[c], b[c]);
      ASSERT_EQ(a[c], direct(first + static_cast<int>(c)));
    }
  }
  GpTile far{1e9, 1e12, 0, 0, 0, 0, 0, 0};
  direct.replace(1, &far);
  EXPECT_EQ(far[0], direct(1e9));
  EXPECT_EQ(far[1], 0.0);
}

// However many cells a processor works on at once, each gets the operations it would get by itself.
TEST(GpTile, CellsComeOutAsEachByItself)
{
  Random random(7);
  for (size_t count = 1; count <= 13; ++count)
  {
    std::vector<double> factor(count * (count + 1) / 2), inverse(count), weights(count), x(count), y(count),
        z(count);
    for (auto* numbers : {&factor, &inverse, &weights, &x, &y, &z})
      for (double& number : *numbers) number = random.uniform(-1, 1);
    GpPlaces places;
    for (auto* numbers : {&places.x, &places.y, &places.z})
      for (double& number : *numbers) number = random.uniform(-3, 3);
    std::vector<GpTile> rows(count);
    GpTile nearest, mean, squares;
    squaredDistances(x.data(), y.data(), z.data(), count, places, rows.data(), nearest);
    std::vector<GpTile> solved = rows;
    matern32(0.7, 1.3, count, solved.data());
    std::vector<GpTile> covariances = solved;
    solveForward(factor.data(), inverse.data(), count, solved.data());
    sumRows(weights.data(), count, solved.data(), mean, squares);
    std::array<GpTile, 8> square{};
    subtractProducts(count, solved.data(), square.data());
    for (size_t c = 0; c < 8; ++c)
    {
      double least = 1e300, sum = 0, squared = 0;
      std::vector<double> v(count);
      for (size_t i = 0; i < count; ++i)
      {
        const double dx = places.x[c] - x[i], dy = places.y[c] - y[i], dz = places.z[c] - z[i];
        const double distance = dx * dx + dy * dy + dz * dz;
        ASSERT_EQ(rows[i][c], distance);
        least = std::min(least, distance);
        const double t = 0.7 * std::sqrt(distance);
        ASSERT_EQ(covariances[i][c], 1.3 * ((1.0 + t) * portableExp(-t)));
        v[i] = covariances[i][c];
        for (size_t j = 0; j < i; ++j) v[i] -= factor[i * (i + 1) / 2 + j] * v[j];
        v[i] *= inverse[i];
        ASSERT_EQ(solved[i][c], v[i]);
        sum += v[i] * weights[i];
        squared += v[i] * v[i];
      }
      for (size_t r = 0; r < 8; ++r)
      {
        double product = 0;
        for (size_t i = 0; i < count; ++i) product -= solved[i][r] * solved[i][c];
        ASSERT_EQ(square[r][c], product);
      }
      ASSERT_EQ(nearest[c], least);
      ASSERT_EQ(mean[c], sum);
      ASSERT_EQ(squares[c], squared);
    }
  }
}

TEST(GpExpert, SaysTheSameOfACellWhoeverElseIsAsked)
{
  Random random(3);
  std::vector<GpPoint> points;
  for (int i = 0; i < 37; ++i) points.push_back({random.inCube(4), random.chance(0.5) ? 1.0 : -1.0});
  const GpCovariance covariance(6, 1, 0);
  GpExpert expert;
  GpExpert::Scratch scratch;
  expert.train(points.data(), points.size(), covariance, 0.01, scratch);
  GpPlaces together{};
  for (size_t c = 0; c < 8; ++c)
  {
    const Eigen::Vector3d place = random.inCube(5);
    together.x[c] = place.x();
    together.y[c] = place.y();
    together.z[c] = place.z();
  }
  GpExpert::Prediction all, one;
  ASSERT_TRUE(expert.predict(together, 100, covariance, scratch, all));
  for (size_t c = 0; c < 8; ++c)
  {
    GpPlaces alone;
    alone.x.fill(together.x[c]);
    alone.y.fill(together.y[c]);
    alone.z.fill(together.z[c]);
    ASSERT_TRUE(expert.predict(alone, 100, covariance, scratch, one));
    EXPECT_EQ(one.mean[5], all.mean[c]);
    EXPECT_EQ(one.variance[5], all.variance[c]);
  }
}

}  // namespace
}  // namespace lamap::test
