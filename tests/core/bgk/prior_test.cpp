// Priors as functions of position (thesis 5.1), evidence from elsewhere, and what counts mean.
#include <gtest/gtest.h>
#include <lamap_core/bgk/map.h>
#include <support/grid_words.h>
#include <support/random_options.h>
#include <support/seeded_scans.h>
#include <support/seeds.h>

#include <limits>
#include <map>
#include <stdexcept>
#include <tuple>

namespace lamap::test
{
namespace
{
TEST(BgkEquations, MeanAndVarianceAreThoseOfABetaDistribution)
{
  EXPECT_DOUBLE_EQ(bgkMean(3, 1), 0.75);
  EXPECT_DOUBLE_EQ(bgkVariance(3, 1), 3.0 / (16.0 * 5.0));
  EXPECT_DOUBLE_EQ(bgkMean(0.001, 0.001), 0.5);
  EXPECT_NEAR(bgkVariance(0.001, 0.001), 0.25 / 1.002, 1e-15);
  EXPECT_DOUBLE_EQ(bgkMean(1e13, 3e13), 0.25);
  EXPECT_NEAR(bgkVariance(1e13, 3e13) * 4e13, 0.1875, 1e-9);
}

TEST(BgkEquations, StateIsEquation49)
{
  const StateThresholds noVariance{0.3, 0.7, 0.0};
  EXPECT_EQ(bgkState(0.29, 9.9, noVariance), CellState::Free);
  EXPECT_EQ(bgkState(0.3, 0.0, noVariance), CellState::Unknown);  // strictly below
  EXPECT_EQ(bgkState(0.5, 0.0, noVariance), CellState::Unknown);
  EXPECT_EQ(bgkState(0.7, 0.0, noVariance), CellState::Unknown);  // strictly above
  EXPECT_EQ(bgkState(0.71, 9.9, noVariance), CellState::Occupied);
  const StateThresholds withVariance{0.3, 0.7, 0.1};
  EXPECT_EQ(bgkState(0.1, 0.09, withVariance), CellState::Free);
  EXPECT_EQ(bgkState(0.1, 0.1, withVariance), CellState::Unknown);  // strictly below
  EXPECT_EQ(bgkState(0.9, 0.09, withVariance), CellState::Occupied);
  EXPECT_EQ(bgkState(0.9, 0.11, withVariance), CellState::Unknown);
  EXPECT_EQ(bgkState(0.5, 0.0, {0.5, 0.5, 0.0}), CellState::Unknown);
}

TEST(BgkMap, AddsEvidenceFromElsewhere)
{
  BgkStructure structure;
  structure.priorAlpha = 0.5;
  structure.priorBeta = 0.25;
  BgkMap map(structure);
  map.addEvidence({-1, 20, 3}, 2.0, 0.75, {});
  map.addEvidence({-1, 20, 3}, 0.0, 0.5, {});
  const auto estimate = map.cell({-1, 20, 3}, {});
  ASSERT_TRUE(estimate.has_value());
  EXPECT_EQ(estimate->evidence[0], 2.5);
  EXPECT_EQ(estimate->evidence[1], 1.5);
  EXPECT_DOUBLE_EQ(estimate->prob, 0.625);
  EXPECT_DOUBLE_EQ(*estimate->variance, 2.5 * 1.5 / (16.0 * 5.0));
  EXPECT_EQ(map.at({-0.05, 2.01, 0.39}, {})->evidence[0], 2.5);
  EXPECT_FALSE(map.at({0.05, 2.01, 0.39}, {}).has_value());
  EXPECT_EQ(cellsOf(map.evidence()).size(), 1u);
  // To the nearest 2^-20.
  map.addEvidence({0, 0, 0}, 0.7 * kEvidenceUnit, 1.4 * kEvidenceUnit, {});
  EXPECT_TRUE(map.evidence().at({0, 0, 0}) == (CellSums{1, 1}));
}

TEST(BgkMap, RefusesEvidenceThatIsNone)
{
  BgkMap map;
  for (const double bad :
       {-1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
  {
    EXPECT_THROW(map.addEvidence({0, 0, 0}, bad, 0.0, {}), std::invalid_argument);
    EXPECT_THROW(map.addEvidence({0, 0, 0}, 0.0, bad, {}), std::invalid_argument);
  }
  EXPECT_TRUE(cellsOf(map.evidence()).empty());
  EXPECT_FALSE(map.cell({0, 0, 0}, {}).has_value());
}

TEST(BgkMap, AnswersPointsOfAPlanarMapAtAnyHeight)
{
  BgkStructure structure;
  structure.planar = true;
  structure.planarHeight = -0.25;
  BgkMap map(structure);
  EXPECT_EQ(map.planarLayer(), -3);
  map.addEvidence({2, 3, -3}, 1, 0, {});
  for (const double z : {-0.25, 0.0, 77.0})
  {
    EXPECT_TRUE(map.at({0.25, 0.35, z}, {}).has_value()) << z;
    EXPECT_FALSE(map.at({0.15, 0.35, z}, {}).has_value()) << z;
  }
  EXPECT_FALSE(map.at({std::numeric_limits<double>::quiet_NaN(), 0, 0}, {}).has_value());
  EXPECT_FALSE(map.at({1e300, 0, 0}, {}).has_value());
}

// Thesis 5.1: α₀ and β₀ as functions of position.
TEST(BgkMapProperty, AnotherMapIsThePriorWhereItHasEvidence)
{
  for (unsigned seed = 1; seed <= seeds(20); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    BgkStructure structure;
    structure.planar = random.chance(0.3);
    structure.priorAlpha = 0.01;
    structure.priorBeta = 0.02;
    BgkStructure priorStructure = structure;
    priorStructure.blockDepth = random.integer(2, 6);
    priorStructure.pruning = random.pick<Pruning>({Pruning::None, Pruning::Lossless, Pruning::State});
    priorStructure.priorAlpha = 0.3;
    priorStructure.priorBeta = 0.4;
    const BgkInference inference = randomInference(random, structure.resolution);
    auto prior = std::make_shared<BgkMap>(priorStructure);
    prior->insert(randomScan(random, {}), inference, 1);
    BgkMap plain(structure), map(structure);
    map.setPriorMap(prior);
    EXPECT_EQ(map.priorMap(), prior);
    for (int i = 0; i < 2; ++i)
    {
      ScanRecipe recipe;
      recipe.centre_map = {0.4, 0, 0};
      const Scan scan = randomScan(random, recipe);
      plain.insert(scan, inference, 1);
      map.insert(scan, inference, 1);
    }
    // The evidence is the map's own.
    EXPECT_EQ(differenceOf(map.evidence(), plain.evidence()), "");

    std::map<std::tuple<int, int, int>, int> expected;
    for (const CellEvidence& cell : cellsOf(plain.evidence()))
      expected[{cell.cell.x, cell.cell.y, cell.cell.z}] |= 1;
    for (const CellEvidence& cell : cellsOf(prior->evidence()))
      expected[{cell.cell.x, cell.cell.y, cell.cell.z}] |= 2;
    size_t visited = 0;
    map.visitCells(
        {},
        [&](const CellIndex& cell, const CellEstimate& estimate)
        {
          ++visited;
          const auto found = expected.find({cell.x, cell.y, cell.z});
          ASSERT_NE(found, expected.end());
          double alpha0 = 0.01, beta0 = 0.02;
          if (found->second & 2)
          {
            alpha0 = prior->cell(cell, {})->evidence[0];
            beta0 = prior->cell(cell, {})->evidence[1];
          }
          EXPECT_EQ(map.priorOf(cell), (std::array<double, 2>{alpha0, beta0}));
          const CellSums own = plain.evidence().at(cell);
          EXPECT_NEAR(estimate.evidence[0], alpha0 + static_cast<double>(own.first) * kEvidenceUnit, 1e-12);
          EXPECT_NEAR(estimate.evidence[1], beta0 + static_cast<double>(own.second) * kEvidenceUnit, 1e-12);
          EXPECT_NEAR(estimate.prob, bgkMean(estimate.evidence[0], estimate.evidence[1]), 1e-15);
          const auto asked = map.cell(cell, {});
          ASSERT_TRUE(asked.has_value());
          EXPECT_EQ(asked->evidence, estimate.evidence);
          EXPECT_EQ(asked->state, estimate.state);
        });
    EXPECT_EQ(visited, expected.size());

    map.setPriorMap(nullptr);
    EXPECT_EQ(map.priorOf({0, 0, 0}), (std::array<double, 2>{0.01, 0.02}));
  }
}

TEST(BgkMap, RefusesAPriorMapOfOtherCells)
{
  BgkStructure structure, other;
  other.resolution = 0.2;
  BgkMap map(structure);
  EXPECT_THROW(map.setPriorMap(std::make_shared<BgkMap>(other)), std::invalid_argument);
  other = structure;
  other.planar = true;
  EXPECT_THROW(map.setPriorMap(std::make_shared<BgkMap>(other)), std::invalid_argument);
  BgkStructure higher = other;
  higher.planarHeight = 0.5;
  BgkMap planar(other);
  EXPECT_THROW(planar.setPriorMap(std::make_shared<BgkMap>(higher)), std::invalid_argument);
  EXPECT_EQ(map.priorMap(), nullptr);
}

TEST(BgkMap, TakesAPriorMapOfOtherBlocksPriorAndPruning)
{
  BgkStructure other;
  other.blockDepth = 3;
  other.priorAlpha = 0.5;
  other.pruning = Pruning::None;
  BgkMap map;
  EXPECT_NO_THROW(map.setPriorMap(std::make_shared<BgkMap>(other)));
}

TEST(BgkMap, KeepsItsPriorMapWhenCopiedAndCleared)
{
  auto prior = std::make_shared<BgkMap>();
  prior->addEvidence({1, 1, 1}, 2, 1, {});
  BgkMap map;
  map.setPriorMap(prior);
  BgkMap copy = map;
  copy.addEvidence({1, 1, 1}, 1, 0, {});
  copy.clear();
  EXPECT_NEAR(copy.cell({1, 1, 1}, {})->evidence[0], 2.003, 1e-12);
  EXPECT_EQ(copy.priorMap(), prior);
}

// State pruning asks for the state with the prior of each cell.
TEST(BgkMapProperty, StatePruningWithAPriorMapChangesNoState)
{
  for (unsigned seed = 1; seed <= seeds(20); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    BgkStructure structure;
    BgkInference inference = randomInference(random, structure.resolution);
    auto prior = std::make_shared<BgkMap>(structure);
    prior->insert(randomScan(random, {}), inference, 1);
    const Scan scan = randomScan(random, {});
    structure.pruning = Pruning::None;
    BgkMap exact(structure);
    structure.pruning = Pruning::State;
    BgkMap pruned(structure);
    exact.setPriorMap(prior);
    pruned.setPriorMap(prior);
    exact.insert(scan, inference, 1);
    pruned.insert(scan, inference, 1);
    exact.visitCells(inference.thresholds, [&](const CellIndex& cell, const CellEstimate& estimate)
                     { ASSERT_EQ(pruned.cell(cell, inference.thresholds)->state, estimate.state); });
  }
}
}  // namespace
}  // namespace lamap::test
