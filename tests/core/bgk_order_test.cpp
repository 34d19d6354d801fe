// Invariant 2: any order, batching or merging of the same scans gives the same bytes.
#include <gtest/gtest.h>
#include <lamap_core/bgk/map.h>
#include <support/grid_words.h>
#include <support/random_options.h>
#include <support/seeded_scans.h>

#include <stdexcept>

namespace lamap::test
{
namespace
{
struct Case
{
  BgkStructure structure;
  BgkInference inference;
  std::vector<Scan> scans;
};

Case randomCase(Random& random)
{
  Case made;
  made.structure.blockDepth = random.integer(2, 6);
  made.structure.planar = random.chance(0.3);
  made.structure.pruning = random.pick<Pruning>({Pruning::None, Pruning::Lossless});
  made.inference = randomInference(random, made.structure.resolution);
  for (int i = 0; i < 7; ++i)
  {
    ScanRecipe recipe;
    recipe.halfEdge_m = 0.8;
    recipe.centre_map = random.inCube(0.5);
    made.scans.push_back(randomScan(random, recipe));
  }
  // Equal scans make cells with equal evidence, which lossless pruning holds once.
  made.scans.push_back(made.scans.front());
  return made;
}

BgkMap mapOf(const Case& from, const std::vector<size_t>& order)
{
  BgkMap map(from.structure);
  for (const size_t i : order) map.insert(from.scans[i], from.inference, 1);
  return map;
}

std::vector<size_t> inOrder(const Case& from)
{
  std::vector<size_t> order(from.scans.size());
  for (size_t i = 0; i < order.size(); ++i) order[i] = i;
  return order;
}

TEST(BgkMapProperty, OrderOfScansDoesNotMatter)
{
  for (unsigned seed = 1; seed <= 30; ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Case made = randomCase(random);
    std::vector<size_t> order = inOrder(made);
    const BgkMap reference = mapOf(made, order);
    ASSERT_FALSE(reference.empty());
    for (int i = 0; i < 3; ++i)
    {
      random.shuffle(order);
      ASSERT_EQ(differenceOf(reference.grid(), mapOf(made, order).grid()), "");
    }
  }
}

TEST(BgkMapProperty, BatchesThatAreMergedGiveTheSameMap)
{
  for (unsigned seed = 1; seed <= 30; ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Case made = randomCase(random);
    const BgkMap reference = mapOf(made, inOrder(made));
    std::vector<size_t> order = inOrder(made);
    random.shuffle(order);
    std::vector<BgkMap> batches(3, BgkMap(made.structure));
    for (const size_t i : order) batches[random.bits() % 3].insert(made.scans[i], made.inference, 1);
    random.shuffle(batches);
    BgkMap merged(made.structure);
    for (const BgkMap& batch : batches) merged.merge(batch, made.inference.thresholds);
    EXPECT_EQ(differenceOf(reference.grid(), merged.grid()), "");
    BgkMap other = batches[2];
    other.merge(batches[0], made.inference.thresholds);
    other.merge(batches[1], made.inference.thresholds);
    EXPECT_EQ(differenceOf(reference.grid(), other.grid()), "");
  }
}

TEST(BgkMapProperty, OrderOfRaysInAScanDoesNotMatter)
{
  for (unsigned seed = 1; seed <= 30; ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    Case made = randomCase(random);
    made.inference.rayDecimation = 1;
    BgkMap reference(made.structure), shuffled(made.structure);
    for (Scan scan : made.scans)
    {
      reference.insert(scan, made.inference, 1);
      for (RayFan& fan : scan.fans) random.shuffle(fan.rays);
      random.shuffle(scan.fans);
      shuffled.insert(scan, made.inference, 1);
    }
    EXPECT_EQ(differenceOf(reference.grid(), shuffled.grid()), "");
  }
}

TEST(BgkMapProperty, CopiesAreEqualAndIndependent)
{
  for (unsigned seed = 1; seed <= 10; ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Case made = randomCase(random);
    BgkMap map = mapOf(made, {0, 1, 2});
    const BgkMap copy = map;
    BgkMap assigned;
    assigned = map;
    EXPECT_EQ(differenceOf(copy.grid(), map.grid()), "");
    EXPECT_TRUE(assigned.structure() == map.structure());
    map.insert(made.scans[3], made.inference, 1);
    EXPECT_EQ(differenceOf(copy.grid(), assigned.grid()), "");
    assigned.insert(made.scans[3], made.inference, 1);
    EXPECT_EQ(differenceOf(assigned.grid(), map.grid()), "");
    const BgkMap moved = std::move(assigned);
    EXPECT_EQ(differenceOf(moved.grid(), map.grid()), "");
    map.clear();
    EXPECT_TRUE(map.empty());
    for (const size_t i : {3, 2, 1, 0}) map.insert(made.scans[i], made.inference, 1);
    EXPECT_EQ(differenceOf(moved.grid(), map.grid()), "");
  }
}

TEST(BgkMap, MergesWithItselfAsWithACopy)
{
  Random random(1);
  const Case made = randomCase(random);
  BgkMap map = mapOf(made, {0, 1, 2});
  BgkMap doubled = map;
  const BgkMap copy = map;
  doubled.merge(copy, {});
  map.merge(map, {});
  EXPECT_EQ(differenceOf(map.grid(), doubled.grid()), "");
}

TEST(BgkMap, RefusesToMergeAnotherStructure)
{
  BgkStructure structure;
  BgkMap map(structure);
  map.addEvidence({1, 2, 3}, 1, 1, {});
  const auto expectRefused = [&](const BgkStructure& other)
  {
    BgkMap from(other);
    from.addEvidence({1, 2, from.planarLayer()}, 1, 1, {});
    EXPECT_THROW(map.merge(from, {}), std::invalid_argument);
    EXPECT_EQ(cellsOf(map.grid()).size(), 1u);
  };
  BgkStructure other = structure;
  other.resolution = 0.2;
  expectRefused(other);
  other = structure;
  other.blockDepth = 5;
  expectRefused(other);
  other = structure;
  other.planar = true;
  expectRefused(other);

  other = structure;
  other.priorAlpha = 0.5;
  other.pruning = Pruning::None;
  BgkMap from(other);
  from.addEvidence({1, 2, 3}, 1, 1, {});
  map.merge(from, {});
  EXPECT_EQ(map.grid().at({1, 2, 3}).first, uint64_t{2} << kEvidenceFractionBits);
  EXPECT_EQ(map.structure().priorAlpha, structure.priorAlpha);
}

TEST(BgkMap, RefusesToMergeAnotherPlanarLayer)
{
  BgkStructure structure;
  structure.planar = true;
  structure.planarHeight = 0.05;
  BgkMap map(structure);
  structure.planarHeight = 0.08;  // the same layer of 0.1 m cells
  EXPECT_NO_THROW(map.merge(BgkMap(structure), {}));
  structure.planarHeight = 0.15;
  EXPECT_THROW(map.merge(BgkMap(structure), {}), std::invalid_argument);
}
}  // namespace
}  // namespace lamap::test
