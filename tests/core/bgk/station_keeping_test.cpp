// Invariant 5, thesis section 4.3.3: n equal scans give exactly n times the evidence of one.
#include <gtest/gtest.h>
#include <lamap_core/bgk/map.h>
#include <support/grid_words.h>
#include <support/random_options.h>
#include <support/seeded_scans.h>
#include <support/seeds.h>

#include <stdexcept>

namespace lamap::test
{
namespace
{
BgkStructure randomStructure(Random& random)
{
  BgkStructure structure;
  structure.blockDepth = random.integer(2, 6);
  structure.planar = random.chance(0.3);
  structure.pruning = random.pick<Pruning>({Pruning::None, Pruning::Lossless});
  return structure;
}

/// n times the map, by doubling.
BgkMap repeated(const BgkMap& one, uint64_t n)
{
  BgkMap sum(one.structure()), power = one;
  for (; n > 0; n >>= 1)
  {
    if (n & 1) sum.merge(power, {});
    const BgkMap same = power;
    power.merge(same, {});
  }
  return sum;
}

/// Exactly n times the evidence, and the mean of eq. (4.26).
void expectTimes(const BgkMap& one, const BgkMap& many, uint64_t n)
{
  const std::vector<CellEvidence> cells = cellsOf(one.evidence());
  ASSERT_FALSE(cells.empty());
  ASSERT_EQ(cellsOf(many.evidence()).size(), cells.size());
  for (const CellEvidence& cell : cells)
  {
    const CellSums evidence = many.evidence().at(cell.cell);
    ASSERT_EQ(evidence.first, n * cell.evidence.first);
    ASSERT_EQ(evidence.second, n * cell.evidence.second);
    const double y = static_cast<double>(cell.evidence.first) * kEvidenceUnit;
    const double k = y + static_cast<double>(cell.evidence.second) * kEvidenceUnit;
    const double a0 = one.structure().priorAlpha, b0 = one.structure().priorBeta,
                 count = static_cast<double>(n);
    ASSERT_NEAR(many.cell(cell.cell, {})->prob, (a0 + count * y) / (a0 + b0 + count * k), 1e-12);
  }
}

TEST(BgkMapProperty, EqualScansMultiplyTheEvidence)
{
  for (unsigned seed = 1; seed <= seeds(20); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    const BgkStructure structure = randomStructure(random);
    const BgkInference inference = randomInference(random, structure.resolution);
    ScanRecipe recipe;
    recipe.halfEdge_m = 0.4;
    const Scan scan = randomScan(random, recipe);
    BgkMap one(structure), many(structure);
    one.insert(scan, inference, 1);
    if (one.empty()) continue;
    for (int i = 0; i < 300; ++i) many.insert(scan, inference, 1);
    expectTimes(one, many, 300);
    EXPECT_EQ(differenceOf(many.evidence(), repeated(one, 300).evidence()), "");
  }
}

TEST(BgkMapProperty, TenMillionEqualScansLoseNothing)
{
  bool anyWide = false;
  for (unsigned seed = 1; seed <= seeds(20); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    const BgkStructure structure = randomStructure(random);
    const BgkInference inference = randomInference(random, structure.resolution);
    ScanRecipe recipe;
    recipe.halfEdge_m = 0.4;
    BgkMap one(structure);
    one.insert(randomScan(random, recipe), inference, 1);
    if (one.empty()) continue;
    const uint64_t n = 10000000;
    const BgkMap many = repeated(one, n);
    expectTimes(one, many, n);
    for (const BlockWords& block : wordsOf(many.evidence())) anyWide |= block.wide;
    // One scan more on ten million.
    BgkMap more = many;
    more.merge(one, {});
    expectTimes(one, more, n + 1);
  }
  EXPECT_TRUE(anyWide);
}

TEST(BgkMapProperty, BlocksWidenWhereACountPasses32Bits)
{
  for (const Pruning pruning : {Pruning::None, Pruning::Lossless})
    for (unsigned seed = 1; seed <= seeds(20); ++seed)
    {
      SCOPED_TRACE(seed);
      Random random(seed);
      BgkStructure structure = randomStructure(random);
      structure.pruning = pruning;
      BgkInference inference = randomInference(random, structure.resolution);
      ScanRecipe recipe;
      recipe.halfEdge_m = 0.4;
      const Scan scan = randomScan(random, recipe);
      BgkMap one(structure);
      one.insert(scan, inference, 1);
      if (one.empty()) continue;
      const std::vector<CellEvidence> cells = cellsOf(one.evidence());

      // A cell of the scan just below 2³²: in its occupied count, its free count, or both.
      const CellEvidence chosen = random.pick(cells);
      const uint64_t below = (uint64_t{1} << 32) - 1;
      const bool occupied = random.chance(0.6), free = !occupied || random.chance(0.3);
      const CellSums start{occupied ? below : 0, free ? below : 0};
      BgkMap map(structure);
      map.addEvidence(chosen.cell, static_cast<double>(start.first) * kEvidenceUnit,
                      static_cast<double>(start.second) * kEvidenceUnit, {});
      ASSERT_TRUE(map.evidence().at(chosen.cell) == start);
      ASSERT_FALSE(map.evidence().find(map.evidence().blockOf(chosen.cell))->wide());
      map.insert(scan, inference, 1);
      for (const CellEvidence& cell : cells)
      {
        const bool isChosen = cell.cell == chosen.cell;
        const CellSums expected{cell.evidence.first + (isChosen ? start.first : 0),
                                cell.evidence.second + (isChosen ? start.second : 0)};
        ASSERT_TRUE(map.evidence().at(cell.cell) == expected);
      }
      const CellSums now = map.evidence().at(chosen.cell);
      EXPECT_EQ(map.evidence().find(map.evidence().blockOf(chosen.cell))->wide(),
                std::max(now.first, now.second) > below);

      // The same the other way round, and merged.
      BgkMap scanFirst = one;
      scanFirst.addEvidence(chosen.cell, static_cast<double>(start.first) * kEvidenceUnit,
                            static_cast<double>(start.second) * kEvidenceUnit, {});
      EXPECT_EQ(differenceOf(scanFirst.evidence(), map.evidence()), "");
      BgkMap alone(structure);
      alone.addEvidence(chosen.cell, static_cast<double>(start.first) * kEvidenceUnit,
                        static_cast<double>(start.second) * kEvidenceUnit, {});
      alone.merge(one, {});
      EXPECT_EQ(differenceOf(alone.evidence(), map.evidence()), "");
    }
}

TEST(BgkMap, RefusesEvidenceBeyond63BitsAndKeepsWhatItHas)
{
  BgkStructure structure;
  BgkInference inference;
  inference.freeSpace = FreeSpace::None;
  BgkMap map(structure);
  // 2⁶³ units are 2⁴³ pseudo-counts.
  for (int i = 0; i < 8; ++i) map.addEvidence({0, 0, 0}, 1e12, 0.125, {});
  map.addEvidence({0, 0, 0}, std::ldexp(1.0, 43) - 8e12 - 1.5, 0.0, {});
  const BgkMap before = map;
  EXPECT_THROW(map.addEvidence({0, 0, 0}, 2.0, 0.0, {}), std::overflow_error);
  EXPECT_EQ(differenceOf(map.evidence(), before.evidence()), "");
  EXPECT_THROW(map.merge(before, {}), std::overflow_error);
  EXPECT_EQ(differenceOf(map.evidence(), before.evidence()), "");

  // A scan whose one hit is that cell.
  const Scan scan = scanWith({fanOf({5, 0, 0}, {{0.05, 0.05, 0.05}})});
  map = before;
  map.insert(scan, inference, 1);  // room for one more
  EXPECT_THROW(
      {
        for (int i = 0; i < 3; ++i) map.insert(scan, inference, 1);
      },
      std::overflow_error);
  EXPECT_GE(map.evidence().at({0, 0, 0}).first, before.evidence().at({0, 0, 0}).first);
  EXPECT_LT(map.evidence().at({0, 0, 0}).first, uint64_t{1} << 63);
}
TEST(BgkMapProperty, EvidenceCountsUpToItsLimitInItsProportions)
{
  BgkStructure structure;
  BgkMap plain(structure);
  structure.maxEvidence = 2.0;
  BgkMap limited(structure);
  const CellIndex few{0, 0, 0}, many{1, 0, 0};
  for (BgkMap* map : {&plain, &limited})
  {
    map->addEvidence(few, 1.5, 0.25, {});
    map->addEvidence(many, 30, 10, {});
  }
  EXPECT_EQ(limited.cell(few, {})->prob, plain.cell(few, {})->prob);
  // By hand: 40 pseudo-counts read as 2, three quarters of them for occupied.
  EXPECT_NEAR(limited.cell(many, {})->prob, (0.003 + 1.5) / (0.006 + 2.0), 1e-12);
  EXPECT_NEAR(*limited.cell(many, {})->variance, *plain.cell(many, {})->variance * 41.006 / 3.006, 1e-3);
  EXPECT_EQ(limited.cell(many, {})->evidence, plain.cell(many, {})->evidence);
  // What is stored is all of it: maps with other limits, or none, merge.
  EXPECT_TRUE(limited.evidence() == plain.evidence());
  plain.merge(limited, {});
  limited.merge(limited, {});
  EXPECT_TRUE(limited.evidence() == plain.evidence());
}

}  // namespace
}  // namespace lamap::test
