// The order of rays in a scan does not matter; maps of other cells are not merged. Orders of scans:
// tests/laws.
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

TEST(BgkMapProperty, OrderOfRaysInAScanDoesNotMatter)
{
  for (unsigned seed = 1; seed <= seeds(30); ++seed)
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
    EXPECT_EQ(differenceOf(reference.evidence(), shuffled.evidence()), "");
  }
}

TEST(BgkMap, RefusesToMergeAnotherStructure)
{
  BgkStructure structure;
  BgkMap map(structure);
  map.addEvidence({1, 2, 3}, 1, 1, {});
  const auto expectRefused = [&](const BgkStructure& other, const std::string& message)
  {
    BgkMap from(other);
    from.addEvidence({1, 2, from.planarLayer()}, 1, 1, {});
    try
    {
      map.merge(from, {});
      ADD_FAILURE() << "not refused: " << message;
    }
    catch (const std::invalid_argument& error)
    {
      EXPECT_EQ(error.what(), message);
    }
    EXPECT_EQ(cellsOf(map.evidence()).size(), 1u);
  };
  BgkStructure other = structure;
  other.resolution = 0.2;
  expectRefused(other, "resolution of the other map = 0.2: must be that of this map, 0.1");
  other = structure;
  other.blockDepth = 5;
  expectRefused(other, "blockDepth of the other map = 5: must be that of this map, 4");
  other = structure;
  other.planar = true;
  expectRefused(other, "planar of the other map = true: must be that of this map, false");

  other = structure;
  other.priorAlpha = 0.5;
  other.pruning = Pruning::None;
  BgkMap from(other);
  from.addEvidence({1, 2, 3}, 1, 1, {});
  map.merge(from, {});
  EXPECT_EQ(map.evidence().at({1, 2, 3}).first, uint64_t{2} << kEvidenceFractionBits);
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
