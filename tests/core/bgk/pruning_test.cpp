// Invariant 6: pruning changes no state, and what is pruned splits again.
#include <gtest/gtest.h>
#include <lamap_core/bgk/map.h>
#include <support/grid_words.h>
#include <support/random_options.h>
#include <support/seeded_scans.h>
#include <support/seeds.h>

namespace lamap::test
{
namespace
{
size_t leavesOf(const Evidence& grid)
{
  size_t leaves = 0;
  for (const BlockIndex& index : grid.sortedBlocks()) leaves += grid.find(index)->leafCount(grid.shape());
  return leaves;
}

/// A box of cells with the same evidence each.
void fill(BgkMap& map, const CellIndex& from, int width, double alpha, double beta,
          const StateThresholds& thresholds)
{
  for (int x = 0; x < width; ++x)
    for (int y = 0; y < width; ++y)
      for (int z = 0; z < (map.structure().planar ? 1 : width); ++z)
        map.addEvidence({from.x + x, from.y + y, from.z + z}, alpha, beta, thresholds);
}

struct Case
{
  BgkStructure structure;
  BgkInference inference;
  std::vector<Scan> scans;
};

/// Dense rays, so that whole octants are free.
Case randomCase(Random& random)
{
  Case made;
  made.structure.blockDepth = random.integer(2, 6);
  made.structure.planar = random.chance(0.4);
  made.inference = randomInference(random, made.structure.resolution);
  made.inference.kernelSupport = random.uniform(1, 3) * made.structure.resolution;
  if (random.chance(0.3)) made.inference.thresholds.variance = 0.05;
  if (made.inference.freeSpace == FreeSpace::None) made.inference.freeSpace = FreeSpace::Line;
  for (int i = 0; i < 4; ++i)
  {
    ScanRecipe recipe;
    recipe.rays = 60;
    made.scans.push_back(randomScan(random, recipe));
  }
  return made;
}

TEST(BgkMapProperty, LosslessPruningEqualsNoneCellByCell)
{
  size_t observed = 0, leaves = 0;
  for (unsigned seed = 1; seed <= seeds(20); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    Case made = randomCase(random);
    made.structure.pruning = Pruning::None;
    BgkMap exact(made.structure);
    made.structure.pruning = Pruning::Lossless;
    BgkMap pruned(made.structure);
    for (const Scan& scan : made.scans)
    {
      exact.insert(scan, made.inference, 1);
      pruned.insert(scan, made.inference, 1);
      ASSERT_EQ(evidenceDifferenceOf(exact.evidence(), pruned.evidence()), "");
    }
    observed += cellsOf(pruned.evidence()).size();
    leaves += leavesOf(pruned.evidence());
    for (const BlockWords& block : wordsOf(exact.evidence())) EXPECT_FALSE(block.pruned);
  }
  EXPECT_LE(leaves, observed);
}

TEST(BgkMapProperty, LosslessPruningHoldsEqualOctantsOnce)
{
  for (const bool planar : {false, true})
    for (int blockDepth = 2; blockDepth <= (planar ? 6 : 4); ++blockDepth)
    {
      SCOPED_TRACE(std::to_string(blockDepth) + (planar ? ", planar" : ", 3D"));
      BgkStructure structure;
      structure.planar = planar;
      structure.blockDepth = blockDepth;
      BgkMap map(structure);
      const int edge = 1 << (blockDepth - 1);
      fill(map, {-edge, edge, 0}, edge, 0.25, 1.5, {});
      EXPECT_EQ(map.evidence().blockCount(), 1u);
      EXPECT_EQ(leavesOf(map.evidence()), 1u);
      // A cell that disagrees splits its octants and leaves every other cell as it was.
      const CellIndex odd{-edge + 1, edge, 0};
      map.addEvidence(odd, 0.0, 0.5, {});
      EXPECT_EQ(leavesOf(map.evidence()),
                (map.evidence().shape().branching() - 1) * static_cast<size_t>(blockDepth - 1) + 1);
      for (const CellEvidence& cell : cellsOf(map.evidence()))
      {
        EXPECT_EQ(cell.evidence.first, uint64_t{1} << 18);
        EXPECT_EQ(cell.evidence.second, cell.cell == odd ? uint64_t{1} << 21 : uint64_t{3} << 19);
      }
      // Agreement joins them again.
      const BgkMap split = map;
      for (const CellEvidence& cell : cellsOf(split.evidence()))
        if (!(cell.cell == odd)) map.addEvidence(cell.cell, 0.0, 0.5, {});
      EXPECT_EQ(leavesOf(map.evidence()), 1u);
    }
}

TEST(BgkMapProperty, StatePruningChangesNoState)
{
  size_t observed = 0, leaves = 0;
  for (unsigned seed = 1; seed <= seeds(30); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    Case made = randomCase(random);
    const StateThresholds thresholds = made.inference.thresholds;
    made.structure.pruning = Pruning::State;
    BgkMap pruned(made.structure);
    made.structure.pruning = Pruning::None;
    for (const Scan& scan : made.scans)
    {
      // What the pruned map held, with the scan's evidence added to every cell by itself.
      BgkMap unpruned(made.structure);
      unpruned.merge(pruned, thresholds);
      unpruned.insert(scan, made.inference, 1);
      pruned.insert(scan, made.inference, 1);
      const std::vector<CellEvidence> cells = cellsOf(unpruned.evidence());
      ASSERT_EQ(cellsOf(pruned.evidence()).size(), cells.size());
      for (const CellEvidence& cell : cells)
      {
        const auto estimate = pruned.cell(cell.cell, thresholds);
        ASSERT_TRUE(estimate.has_value());
        ASSERT_EQ(estimate->state, unpruned.cell(cell.cell, thresholds)->state)
            << cell.cell.x << ", " << cell.cell.y << ", " << cell.cell.z;
      }
      // A held octant holds the mean of its cells, to rounding.
      for (const BlockIndex& index : pruned.evidence().sortedBlocks())
      {
        const CellIndex first = pruned.evidence().firstCellOf(index);
        pruned.evidence().find(index)->visitLeaves(
            pruned.evidence().shape(),
            [&](uint32_t begin, uint32_t count, const CellSums& evidence)
            {
              double occupied = 0, free = 0;
              for (uint32_t offset = begin; offset < begin + count; ++offset)
              {
                const CellIndex local = unpruned.evidence().shape().localOf(offset);
                const CellSums own =
                    unpruned.evidence().at({first.x + local.x, first.y + local.y, first.z + local.z});
                occupied += static_cast<double>(own.first) / count;
                free += static_cast<double>(own.second) / count;
              }
              ASSERT_NEAR(static_cast<double>(evidence.first), occupied, 1.0);
              ASSERT_NEAR(static_cast<double>(evidence.second), free, 1.0);
            });
      }
    }
    observed += cellsOf(pruned.evidence()).size();
    leaves += leavesOf(pruned.evidence());
  }
  // It does prune.
  EXPECT_LT(leaves, observed * 9 / 10);
}

TEST(BgkMapProperty, StatePruningNeverJoinsObservedWithUnobservedCells)
{
  for (unsigned seed = 1; seed <= seeds(20); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    Case made = randomCase(random);
    made.structure.pruning = Pruning::None;
    BgkMap exact(made.structure);
    made.structure.pruning = Pruning::State;
    BgkMap pruned(made.structure);
    for (const Scan& scan : made.scans)
    {
      exact.insert(scan, made.inference, 1);
      pruned.insert(scan, made.inference, 1);
      const std::vector<CellEvidence> a = cellsOf(exact.evidence()), b = cellsOf(pruned.evidence());
      ASSERT_EQ(a.size(), b.size());
      for (size_t i = 0; i < a.size(); ++i) ASSERT_TRUE(a[i].cell == b[i].cell);
    }
  }
}

TEST(BgkMap, SplitsAnOctantOfOneStateWhenEvidenceDisagrees)
{
  for (const bool planar : {false, true})
  {
    SCOPED_TRACE(planar ? "planar" : "3D");
    BgkStructure structure;
    structure.pruning = Pruning::State;
    structure.planar = planar;
    BgkMap map(structure);
    fill(map, {0, 0, 0}, 8, 0.0, 2.0, {});
    fill(map, {0, 0, 0}, 4, 0.0, 1.0, {});  // more evidence, the same state
    EXPECT_EQ(leavesOf(map.evidence()), 1u);
    EXPECT_EQ(map.cell({7, 7, 0}, {})->state, CellState::Free);
    const double pooled = map.cell({7, 7, 0}, {})->evidence[1];

    map.addEvidence({3, 3, 0}, 50.0, 0.0, {});
    EXPECT_GT(leavesOf(map.evidence()), 1u);
    EXPECT_EQ(map.cell({3, 3, 0}, {})->state, CellState::Occupied);
    for (const CellEvidence& cell : cellsOf(map.evidence()))
    {
      if (cell.cell == CellIndex{3, 3, 0}) continue;
      EXPECT_EQ(map.cell(cell.cell, {})->state, CellState::Free);
      EXPECT_NEAR(map.cell(cell.cell, {})->evidence[1], pooled, 1e-5);
    }
    // Free again: held once again.
    map.addEvidence({3, 3, 0}, 0.0, 500.0, {});
    EXPECT_EQ(leavesOf(map.evidence()), 1u);
  }
}

// By hand: three cells with α = 0.095, β = 0.005 are unknown for want of evidence (variance 0.0432), one with
// α = 20.97, β = 9.03 is unknown as undecided (P = 0.699). Their mean is occupied (P = 0.7015, variance
// 0.0244).
TEST(BgkMap, HoldsNoOctantWhoseMeanHasAnotherState)
{
  BgkStructure structure;
  structure.pruning = Pruning::State;
  structure.planar = true;
  structure.blockDepth = 2;
  structure.priorAlpha = structure.priorBeta = 0.001;
  StateThresholds thresholds;
  thresholds.occupied = 0.7;
  thresholds.variance = 0.04;
  BgkMap map(structure);
  map.addEvidence({0, 0, 0}, 0.094, 0.004, thresholds);
  map.addEvidence({1, 0, 0}, 0.094, 0.004, thresholds);
  map.addEvidence({0, 1, 0}, 0.094, 0.004, thresholds);
  map.addEvidence({1, 1, 0}, 20.969, 9.029, thresholds);
  ASSERT_EQ(bgkState(bgkMean(5.31375, 2.26125), bgkVariance(5.31375, 2.26125), thresholds),
            CellState::Occupied);
  for (const CellIndex& cell : {CellIndex{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}})
    EXPECT_EQ(map.cell(cell, thresholds)->state, CellState::Unknown) << cell.x << ", " << cell.y;
  EXPECT_EQ(leavesOf(map.evidence()), 4u);
}
}  // namespace
}  // namespace lamap::test
