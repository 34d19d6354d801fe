// Where the cells of a map are, for all four maps, against a walk of them.
#include <gtest/gtest.h>
#include <support/seeds.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include "law_maps.h"

namespace lamap::test
{
namespace
{
template <typename Map>
class ExtentLaws : public testing::Test
{
};
TYPED_TEST_SUITE(ExtentLaws, AllMaps);

std::vector<CellIndex> cellsByAWalk(const CLearnedMap& map)
{
  std::vector<CellIndex> cells;
  map.visitCells([&](const CellIndex& cell, const CellEstimate&) { cells.push_back(cell); });
  return cells;
}

void expectItKnowsItsExtent(const CLearnedMap& map, const std::string& when)
{
  SCOPED_TRACE(when);
  const std::vector<CellIndex> cells = cellsByAWalk(map);
  const auto bounds = map.cellBounds();
  ASSERT_EQ(bounds.has_value(), !cells.empty());
  if (!bounds) return;
  CellIndex low = cells.front();
  CellIndex high = low;
  for (const CellIndex& cell : cells)
  {
    low = {std::min(low.x, cell.x), std::min(low.y, cell.y), std::min(low.z, cell.z)};
    high = {std::max(high.x, cell.x), std::max(high.y, cell.y), std::max(high.z, cell.z)};
    // No cell is in a cube that is said to be empty.
    ASSERT_EQ(map.emptyAround(cell), 0);
  }
  const auto textOf = [](const CellIndex& cell)
  { return std::to_string(cell.x) + " " + std::to_string(cell.y) + " " + std::to_string(cell.z); };
  ASSERT_EQ(textOf(bounds->first), textOf(low));
  ASSERT_EQ(textOf(bounds->second), textOf(high));

  // Nor in one beside it.
  Random random(3);
  for (int i = 0; i < 10; ++i)
  {
    const int reach = 1 << random.integer(3, 24);
    const auto away = [&](int32_t from) { return from + random.integer(-reach, reach); };
    const CellIndex from{away(low.x), away(low.y), away(low.z)};
    const int empty = map.emptyAround(from);
    if (empty == 0) continue;
    const auto isBeside = [&](int32_t a, int32_t b) { return std::abs((a >> empty) - (b >> empty)) <= 1; };
    for (const CellIndex& cell : cells)
      ASSERT_FALSE(isBeside(cell.x, from.x) && isBeside(cell.y, from.y) && isBeside(cell.z, from.z));
  }
}

/// Another place far away, so that cells come and go at both ends.
TakenScan farAway(const TakenScan& scan)
{
  return moved(scan, 57.6, -41.6, 3.2);
}

TYPED_TEST(ExtentLaws, TheBoxAndTheEmptySpaceAreThoseOfAWalk)
{
  for (unsigned seed = 1; seed <= seeds(8); ++seed)
  {
    Random random(seed);
    const Settings settings = randomSettingsForFiles<TypeParam>(random);
    SCOPED_TRACE("seed " + std::to_string(seed) + ": " + nameOf(settings));
    std::vector<TakenScan> scans = randomScans(random, 4);
    scans.push_back(farAway(scans.front()));
    scans.push_back(scans.front());
    TypeParam map = mapOf<TypeParam>(settings, {});
    ASSERT_FALSE(map.cellBounds());
    for (const TakenScan& scan : scans)
    {
      map.insertObservation(*scan.observation, scan.robotPose_map);
      expectItKnowsItsExtent(map, "a scan later");
    }
    const TypeParam copy = map;
    expectItKnowsItsExtent(copy, "in a copy");
    const auto loaded = std::dynamic_pointer_cast<TypeParam>(objectFrom(bytesOf(map)));
    expectItKnowsItsExtent(*loaded, "read from a file");
    map.clear();
    ASSERT_FALSE(map.cellBounds());
    map.insertObservation(*scans[1].observation, scans[1].robotPose_map);
    expectItKnowsItsExtent(map, "after it was cleared");
    map = copy;
    expectItKnowsItsExtent(map, "assigned");
  }
}

/// Counts how often all cells are visited.
template <typename Map>
class WalkedMap : public Map
{
 public:
  using Map::Map;
  void visitCells(const CLearnedMap::CellVisitor& visitor) const override
  {
    ++walks;
    Map::visitCells(visitor);
  }
  mutable int walks = 0;
};

TYPED_TEST(ExtentLaws, AReadingAfterAnInsertionWalksNoCells)
{
  Random random(4);
  WalkedMap<TypeParam> map;
  for (const TakenScan& scan : randomScans(random, 3))
  {
    map.insertObservation(*scan.observation, scan.robotPose_map);
    mrpt::math::TPoint3D end;
    (void)map.castRay({0, 0, 0}, {1, 0.2, 0.1}, end, true);
    (void)map.castRay({0, 0, 0}, {1, 0.2, 0.1}, end, false);
    (void)map.boundingBox();
    (void)map.computeObservationLikelihood(*scan.observation, scan.robotPose_map);
    EXPECT_EQ(map.walks, 0);
  }
}

TEST(Extent, CountsThePriorMapOfABgkMap)
{
  Random random(8);
  const TakenScan scan = randomCloud(random);
  const CBGKMap known = mapOf<CBGKMap>({}, {scan});
  BgkStructure structure;
  BgkMap map(structure);
  map.setPriorMap(std::make_shared<BgkMap>(known.core()));
  EXPECT_TRUE(map.cellBounds() == known.core().cellBounds());
  const auto [low, high] = *map.cellBounds();
  map.addEvidence({high.x + 70, low.y, low.z}, 1, 0, {});
  EXPECT_TRUE(map.cellBounds()->first == low);
  EXPECT_TRUE(map.cellBounds()->second == (CellIndex{high.x + 70, high.y, high.z}));
  EXPECT_EQ(map.emptyAround(low), 0);
  EXPECT_GT(map.emptyAround({high.x + 7000, low.y, low.z}), 5);
}

TEST(Extent, ShrinksWhereAModelOfAnOverlappingMapIsMovedAway)
{
  Random random(9);
  std::vector<TakenScan> scans = randomScans(random, 3);
  for (int i = 0; i < 3; ++i)
    scans[static_cast<size_t>(i)] = moved(scans[static_cast<size_t>(i)], 3.0 * i, 0, 0);
  COverlappingHilbertMap map = mapOf<COverlappingHilbertMap>({}, scans);
  for (const double shift_m : {40.0, 0.0, -25.6})
  {
    mrpt::poses::CPose3D pose = map.modelPose(2);
    pose.y(shift_m);
    map.setModelPose(2, pose);
    expectItKnowsItsExtent(map, "a model moved");
    if (shift_m > 0)
    {
      EXPECT_LT(map.cellBounds()->first.y, 100);
      EXPECT_GT(map.cellBounds()->second.y, 300);
    }
  }
}

TEST(Extent, OfAHilbertMapOfUncertainPointsIsThatOfAWalk)
{
  for (unsigned seed = 1; seed <= seeds(4); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    CHilbertMap map;
    map.insertionOptions.rangeStd = random.pick<double>({0.05, 0.15, 0.4});
    for (const TakenScan& scan : randomScans(random, 3))
    {
      map.insertObservation(*scan.observation, scan.robotPose_map);
      expectItKnowsItsExtent(map, "a scan later");
      map.insertionOptions.rangeStd = random.pick<double>({0.0, 0.2});
    }
  }
}

}  // namespace
}  // namespace lamap::test
