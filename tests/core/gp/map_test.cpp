// What GP maps promise beside the laws of all maps.
#include <gtest/gtest.h>
#include <lamap_core/gp/map.h>
#include <lamap_core/grid/cell_sums.h>
#include <support/grid_words.h>
#include <support/random_gp_options.h>
#include <support/seeded_scans.h>
#include <support/seeds.h>

#include <cmath>

namespace lamap::test
{
namespace
{
Scan someScan(Random& random, double resolution = 0.1)
{
  ScanRecipe recipe;
  recipe.halfEdge_m = 7 * resolution;
  recipe.clusterRadius_m = resolution;
  recipe.statedRanges = false;
  return randomScan(random, recipe);
}

// Thesis eq. (4.12) to (4.22): and so any mean that is not zero ends in certainty, eq. (4.23).
TEST(GpMapProperty, EqualScansMultiplyTheEvidence)
{
  for (unsigned seed = 1; seed <= seeds(10); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    GpStructure structure = randomGpStructure(random);
    structure.maxEvidence = 0;  // as in the thesis
    const GpInference inference = randomGpInference(random, structure.resolution);
    const Scan scan = someScan(random);
    GpMap one(structure), many(structure);
    one.insert(scan, inference, 1);
    const int n = 7;
    for (int i = 0; i < n; ++i) many.insert(scan, inference, 1);
    // Ten million scans, by doubling.
    GpMap station(structure), power = one;
    const uint64_t scans = 10'000'000;
    for (uint64_t rest = scans; rest > 0; rest >>= 1)
    {
      if (rest & 1) station.merge(power, {});
      const GpMap same = power;
      power.merge(same, {});
    }
    const std::vector<CellEvidence> cells = cellsOf(one.evidence());
    ASSERT_EQ(cellsOf(many.evidence()).size(), cells.size());
    for (const CellEvidence& cell : cells)
    {
      const auto expectTimes = [&](const GpMap& map, int64_t times)
      {
        const CellSums evidence = map.evidence().at(cell.cell);
        ASSERT_EQ(*SignedSums::decoded(evidence.first), times * *SignedSums::decoded(cell.evidence.first));
        ASSERT_EQ(*SignedSums::decoded(evidence.second), times * *SignedSums::decoded(cell.evidence.second));
      };
      expectTimes(many, n);
      expectTimes(station, static_cast<int64_t>(scans));
      const int64_t weighted = *SignedSums::decoded(cell.evidence.second);
      const double prob = station.cell(cell.cell, inference.thresholds)->prob;
      const double logodds =
          structure.squash() * static_cast<double>(weighted) * kEvidenceUnit * static_cast<double>(scans);
      EXPECT_NEAR(prob, 1 / (1 + std::exp(-logodds)), 1e-9);
      if (weighted == 0)
      {
        EXPECT_EQ(prob, 0.5);
      }
    }
  }
}

TEST(GpMapProperty, CellsBeyondTheSupportOfAllDataHoldNothing)
{
  for (unsigned seed = 1; seed <= seeds(20); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    GpStructure structure = randomGpStructure(random);
    structure.planar = false;
    GpInference inference = randomGpInference(random, structure.resolution);
    inference.freeSpace = GpFreeSpace::None;
    inference.trainingPoints = TrainingPoints::Centroids;
    inference.hitDownsampling = 0.0;
    inference.maxRange = 0.0;
    inference.minRange = 0.0;
    inference.rayDecimation = 1;
    const Scan scan = someScan(random);
    GpMap map(structure);
    map.insert(scan, inference, 1);
    const double support = *inference.resolved(structure.resolution).kernelSupport;
    for (int x = -12; x <= 12; ++x)
      for (int y = -12; y <= 12; ++y)
        for (int z = -12; z <= 12; ++z)
        {
          const Eigen::Vector3d centre = cellCentre({x, y, z}, structure.resolution);
          double nearest = 1e9;
          for (const RayFan& fan : scan.fans)
            for (const Eigen::Vector3d& end : endsOf(fan))
              if (end.allFinite() && fan.centre.allFinite() && end != fan.centre)
                nearest = std::min(nearest, (end - centre).norm());
          if (std::abs(nearest - support) < 1e-9) continue;
          ASSERT_EQ(map.cell({x, y, z}, inference.thresholds).has_value(), nearest < support);
        }
  }
}

TEST(GpMap, EvidenceCountsForSevenAndAHalfSharpPointsUnlessToldOtherwise)
{
  for (const double noise : {0.05, 0.01})
  {
    GpStructure structure;
    structure.noiseVariance = noise;
    GpMap map(structure);
    for (int i = 0; i < 100; ++i) map.addObservation({0, 0, 0}, true, {});
    EXPECT_NEAR(*map.cell({0, 0, 0}, {})->variance, 1 / (1 + 7.5 / noise), 1e-9);
    EXPECT_NEAR(map.cell({0, 0, 0}, {})->prob, 1 / (1 + std::exp(-7.5)), 1e-4);
  }
  EXPECT_EQ(presetOptions(GpPreset::Thesis).structure.resolvedMaxEvidence(), 0);
  EXPECT_EQ(presetOptions(GpPreset::La3dm).structure.resolvedMaxEvidence(), 0);
}

// Split GPs are an approximation, but one that agrees where it matters.
TEST(GpMap, MorePointsThanOneGpTakesAreSplitAndFused)
{
  Random random(5);
  Scan scan;
  scan.fans.resize(1);
  RayFan& fan = scan.fans[0];
  fan.centre = {0.05, 0.05, 0.05};
  for (int i = 0; i < 3000; ++i) fan.addReturn({1.25, random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4)});
  GpInference inference;
  inference.trainingPoints = TrainingPoints::Centroids;
  inference.hitDownsampling = 0.0;
  for (const bool nested : {false, true})
  {
    inference.nested = nested;
    GpMap map;
    inference.maxPoints = 50;
    map.insert(scan, inference, 1);
    EXPECT_EQ(map.at({1.25, 0.0, 0.0}, inference.thresholds)->state, CellState::Occupied);
    EXPECT_EQ(map.at({0.75, 0.0, 0.0}, inference.thresholds)->state, CellState::Free);
    EXPECT_FALSE(map.at({1.75, 0.0, 0.0}, inference.thresholds));
  }
}

TEST(GpMap, AnObservationOfACellIsAGpOfOnePoint)
{
  GpStructure structure;
  structure.signalVariance = 2.0;
  GpInference inference;
  structure.noiseVariance = 0.5;
  GpMap map(structure);
  map.addObservation({1, 2, 3}, true, {});
  const auto cell = map.cell({1, 2, 3}, inference.thresholds);
  ASSERT_TRUE(cell);
  EXPECT_NEAR(*cell->variance, 2.0 - 4.0 / 2.5, 1e-6);
  EXPECT_NEAR(cell->evidence[1], 2.0 / 2.5, 1e-6);
  map.addObservation({1, 2, 3}, false, {});
  EXPECT_EQ(map.cell({1, 2, 3}, inference.thresholds)->prob, 0.5);
  EXPECT_FALSE(map.cell({1, 2, 4}, inference.thresholds));
}

TEST(GpMap, UncertainCellsAreUnknownWhereAThresholdSaysSo)
{
  GpStructure structure;
  structure.noiseVariance = 0.1;
  structure.minVariance = 1.0;
  GpMap map(structure);
  GpInference inference;
  map.addObservation({0, 0, 0}, true, {});
  EXPECT_EQ(map.cell({0, 0, 0}, inference.thresholds)->state, CellState::Occupied);
  inference.thresholds.variance = 0.05;
  EXPECT_EQ(map.cell({0, 0, 0}, inference.thresholds)->state, CellState::Unknown);
  map.addObservation({0, 0, 0}, true, {});
  EXPECT_EQ(map.cell({0, 0, 0}, inference.thresholds)->state, CellState::Occupied);
}

TEST(GpMap, MapsOfOtherStructureAreNotMerged)
{
  GpStructure other;
  other.pruning = Pruning::None;
  other.signalVariance = 2;
  GpMap map;
  try
  {
    map.merge(GpMap(other), {});
    ADD_FAILURE() << "merged";
  }
  catch (const std::invalid_argument& error)
  {
    EXPECT_STREQ(error.what(), "signalVariance of the other map = 2: must be that of this map, 1");
  }
}

// What scans gave a cell counts as one precision at most, with the same mean: certainty ends.
TEST(GpMap, EvidenceCountsUpToItsLimitWithTheSameMean)
{
  GpStructure structure;
  structure.maxEvidence = 0;
  GpMap plain(structure);
  structure.maxEvidence = 100;  // of five points, each known to 0.05
  GpMap limited(structure);
  const auto observe = [&](int times)
  {
    for (int i = 0; i < times; ++i)
      for (GpMap* map : {&plain, &limited}) map->addObservation({0, 0, 0}, true, {});
  };
  observe(3);
  EXPECT_EQ(limited.cell({0, 0, 0}, {})->prob, plain.cell({0, 0, 0}, {})->prob);
  observe(597);
  const double given = plain.cell({0, 0, 0}, {})->evidence[0] - 1;
  const double mean = plain.cell({0, 0, 0}, {})->evidence[1] * (given + 1) / given;  // of the scans
  EXPECT_GT(given, 1000);
  EXPECT_NEAR(*limited.cell({0, 0, 0}, {})->variance, 1.0 / 101, 1e-9);
  EXPECT_NEAR(limited.cell({0, 0, 0}, {})->prob, 1 / (1 + std::exp(-0.05 * mean * 100)), 1e-9);
  EXPECT_GT(plain.cell({0, 0, 0}, {})->prob, 1 - 1e-9);
  EXPECT_EQ(limited.cell({0, 0, 0}, {})->evidence, plain.cell({0, 0, 0}, {})->evidence);
  // What is stored is all of it: maps with other limits, or none, merge.
  EXPECT_TRUE(limited.evidence() == plain.evidence());
  plain.merge(limited, {});
  limited.merge(limited, {});
  EXPECT_TRUE(limited.evidence() == plain.evidence());
}

}  // namespace
}  // namespace lamap::test
