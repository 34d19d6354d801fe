// What an accessor says is what the map says, cell by cell and to the last bit.
#include <gtest/gtest.h>
#include <lamap_core/bgk/map.h>
#include <lamap_core/gp/map.h>
#include <lamap_core/overlapping/map.h>
#include <support/seeded_scans.h>
#include <support/seeds.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

namespace lamap::test
{
namespace
{
void add(BgkMap& map, const CellIndex& cell, int strength, const StateThresholds& thresholds)
{
  map.addEvidence(cell, strength > 0 ? strength : 0, strength > 0 ? 0 : -strength, thresholds);
}
void add(GpMap& map, const CellIndex& cell, int strength, const StateThresholds& thresholds)
{
  map.addObservation(cell, strength > 0, thresholds);
}
void add(OverlappingHilbertMap& map, const CellIndex& cell, int strength, const StateThresholds& thresholds)
{
  map.addEvidence(cell, strength, thresholds);
}

template <typename Map>
class CellAccessorProperty : public ::testing::Test
{
};
using GridMaps = ::testing::Types<BgkMap, GpMap, OverlappingHilbertMap>;
TYPED_TEST_SUITE(CellAccessorProperty, GridMaps);

StateThresholds randomThresholds(Random& random)
{
  StateThresholds thresholds;
  if (random.chance(0.3)) thresholds.variance = random.uniform(0.001, 0.3);
  if (random.chance(0.3)) thresholds.occupied = 0.7;
  return thresholds;
}

/// Single cells, and cubes of equal cells, most of which are held once; around the origin and far away.
template <typename Map>
Map randomMap(Random& random, const StateThresholds& thresholds)
{
  typename Map::Structure structure;
  structure.blockDepth = random.integer(2, 5);
  structure.planar = random.chance(0.3);
  structure.planarHeight = random.uniform(-1, 1);
  structure.pruning = random.pick<Pruning>({Pruning::None, Pruning::Lossless, Pruning::State});
  Map map(structure);
  for (int i = 0; i < 25; ++i)
  {
    const int far = random.chance(0.1) ? 1000 : 0;
    const CellIndex corner{far + random.integer(-20, 20), random.integer(-20, 20) - far,
                           random.integer(-9, 9)};
    const int width = random.pick<int>({1, 2, 4});
    const int strength = random.pick<int>({-3, -1, 1, 5});
    for (int z = 0; z < (structure.planar ? 1 : width); ++z)
      for (int y = 0; y < width; ++y)
        for (int x = 0; x < width; ++x)
          add(map, {(corner.x & -width) + x, (corner.y & -width) + y, (corner.z & -width) + z}, strength,
              thresholds);
  }
  return map;
}

CellIndex randomCell(Random& random, const CellIndex& near)
{
  if (random.chance(0.02))
    return {random.pick<int>({kLastCell, -kLastCell}), random.integer(-5, 5), kLastCell};
  if (random.chance(0.3) || std::abs(static_cast<double>(near.x)) > 2000)
  {
    const int far = random.chance(0.1) ? 1000 : 0;
    return {far + random.integer(-20, 20), random.integer(-20, 20) - far, random.integer(-9, 9)};
  }
  return {near.x + random.integer(-1, 1), near.y + random.integer(-1, 1), near.z + random.integer(-1, 1)};
}

void expectSame(const std::optional<CellEstimate>& said, const std::optional<CellEstimate>& expected)
{
  ASSERT_EQ(said.has_value(), expected.has_value());
  if (!said) return;
  EXPECT_EQ(said->prob, expected->prob);
  EXPECT_EQ(said->variance, expected->variance);
  EXPECT_EQ(said->state, expected->state);
  EXPECT_EQ(said->evidence, expected->evidence);
}

/// Asks the accessor and the map for the same cells.
template <typename Map>
size_t compare(typename Map::Accessor& accessor, const Map& map, const StateThresholds& thresholds,
               Random& random, int questions)
{
  size_t known = 0;
  CellIndex cell;
  const double resolution_m = map.structure().resolution;
  for (int i = 0; i < questions; ++i)
  {
    cell = randomCell(random, cell);
    if (map.structure().planar && random.chance(0.8)) cell.z = map.planarLayer();
    const auto expected = map.cell(cell, thresholds);
    known += expected.has_value();
    const Eigen::Vector3d point = cellCentre(cell, resolution_m) + random.inCube(0.6 * resolution_m);
    const auto expectedAt = map.at(point, thresholds);
    switch (random.integer(0, 2))  // in any order: each must find the block by itself
    {
      case 0:
        expectSame(accessor.cell(cell), expected);
        expectSame(accessor.at(point), expectedAt);
        break;
      case 1:
        EXPECT_EQ(accessor.prob(cell), expected ? std::optional(expected->prob) : std::nullopt);
        EXPECT_EQ(accessor.probAt(point), expectedAt ? std::optional(expectedAt->prob) : std::nullopt);
        break;
      default:
        EXPECT_EQ(accessor.state(cell), expected ? std::optional(expected->state) : std::nullopt);
        EXPECT_EQ(accessor.stateAt(point), expectedAt ? std::optional(expectedAt->state) : std::nullopt);
    }
  }
  return known;
}

TYPED_TEST(CellAccessorProperty, SaysWhatTheMapSays)
{
  size_t known = 0;
  for (unsigned seed = 1; seed <= seeds(30); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    const StateThresholds thresholds = randomThresholds(random);
    const auto map = randomMap<TypeParam>(random, thresholds);
    typename TypeParam::Accessor accessor(map, thresholds);
    known += compare(accessor, map, thresholds, random, 400);
    for (const double odd : {std::numeric_limits<double>::quiet_NaN(), 1e300, -1e12})
      EXPECT_FALSE(accessor.stateAt({0, odd, 0}) || accessor.probAt({odd, 0, 0}) || accessor.at({0, odd, 0}));
  }
  EXPECT_GT(known * 30, 200 * seeds(30));
}

TYPED_TEST(CellAccessorProperty, NoticesThatTheMapChanged)
{
  for (unsigned seed = 1; seed <= seeds(20); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    const StateThresholds thresholds = randomThresholds(random);
    auto map = randomMap<TypeParam>(random, thresholds);
    typename TypeParam::Accessor accessor(map, thresholds);
    const CellIndex cell{1, 2, map.structure().planar ? map.planarLayer() : 3};
    const auto expectCurrent = [&](const char* change)
    {
      SCOPED_TRACE(change);
      expectSame(accessor.cell(cell), map.cell(cell, thresholds));
    };
    expectCurrent("none");
    for (int i = 0; i < 3; ++i)
    {
      add(map, cell, 2, thresholds);
      expectCurrent("evidence");
    }
    const TypeParam before = map;
    map.clear();
    EXPECT_FALSE(accessor.cell(cell));
    map = before;
    expectCurrent("another map in its place");
    TypeParam moved = std::move(map);
    map = TypeParam(moved.structure());
    EXPECT_FALSE(accessor.cell(cell));
    map = std::move(moved);
    expectCurrent("moved there");
    map.merge(before, thresholds);
    expectCurrent("merged");
  }
}

template <typename Map>
std::map<std::tuple<int, int, int>, std::array<double, 2>> evidenceOf(const Map& map)
{
  std::map<std::tuple<int, int, int>, std::array<double, 2>> evidence;
  map.visitCells({},
                 [&](const CellIndex& cell, const CellEstimate& estimate) {
                   evidence[{cell.x, cell.y, cell.z}] = estimate.evidence;
                 });
  return evidence;
}

// Copies share blocks until one of them changes.
TYPED_TEST(CellAccessorProperty, ACopyDoesNotChangeWithItsOriginal)
{
  for (unsigned seed = 1; seed <= seeds(10); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    auto map = randomMap<TypeParam>(random, {});
    const auto before = evidenceOf(map);
    TypeParam copy = map;
    const CellIndex cell{random.integer(-9, 9), random.integer(-9, 9), 0};
    for (int i = 0; i < 3; ++i) add(map, {cell.x + i, cell.y, cell.z}, 4, {});
    EXPECT_EQ(evidenceOf(copy), before);
    EXPECT_NE(evidenceOf(map), before);
    const auto after = evidenceOf(map);
    copy.merge(map, {});
    copy = TypeParam(map);
    add(copy, cell, -1, {});
    copy.clear();
    EXPECT_EQ(evidenceOf(map), after);
  }
}

using Box = std::pair<CellIndex, CellIndex>;

template <typename Map>
void expectBox(typename Map::Accessor& accessor, const Map& map, const StateThresholds& thresholds,
               const Box& box)
{
  using Place = std::tuple<int, int, int>;
  const CellIndex& low = box.first;
  const CellIndex& high = box.second;
  std::map<Place, CellEstimate> expected;
  map.visitCells(thresholds,
                 [&](const CellIndex& cell, const CellEstimate& estimate)
                 {
                   if (cell.x >= low.x && cell.y >= low.y && cell.z >= low.z && cell.x <= high.x &&
                       cell.y <= high.y && cell.z <= high.z)
                     expected[{cell.x, cell.y, cell.z}] = estimate;
                 });
  size_t visited = 0;
  accessor.visitBox(low, high,
                    [&](const KnownCell& known)
                    {
                      ++visited;
                      const auto found = expected.find({known.cell.x, known.cell.y, known.cell.z});
                      ASSERT_NE(found, expected.end());
                      EXPECT_EQ(known.prob, found->second.prob);
                      EXPECT_EQ(known.state, found->second.state);
                    });
  EXPECT_EQ(visited, expected.size());
}

TYPED_TEST(CellAccessorProperty, VisitsTheCellsOfABoxOnce)
{
  constexpr int kMost = std::numeric_limits<int>::max();
  for (unsigned seed = 1; seed <= seeds(20); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    const StateThresholds thresholds = randomThresholds(random);
    const auto map = randomMap<TypeParam>(random, thresholds);
    typename TypeParam::Accessor accessor(map, thresholds);
    for (int i = 0; i < 10; ++i)
    {
      const CellIndex low{random.integer(-25, 20), random.integer(-25, 20), random.integer(-12, 8)};
      const int size = random.integer(0, 20);
      expectBox(accessor, map, thresholds, {low, {low.x + size, low.y + 2 * size, low.z + size / 2}});
    }
    expectBox(accessor, map, thresholds, {{0, 0, 0}, {-1, 5, 5}});
    expectBox(accessor, map, thresholds, {{-kMost, -kMost, -kMost}, {kMost, kMost, kMost}});
  }
}

TEST(CellAccessor, ReadsAPriorMapToo)
{
  size_t known = 0;
  for (unsigned seed = 1; seed <= seeds(20); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    BgkStructure structure;
    structure.planar = random.chance(0.3);
    const auto prior = std::make_shared<BgkMap>(structure);
    structure.blockDepth = random.integer(2, 5);
    BgkMap map(structure);
    for (int i = 0; i < 60; ++i)
    {
      add(*prior, {random.integer(-8, 8), random.integer(-8, 8), random.integer(-4, 4)}, 2, {});
      add(map, {random.integer(-8, 8), random.integer(-8, 8), random.integer(-4, 4)}, -2, {});
    }
    map.setPriorMap(prior);
    CellAccessor accessor(map);
    known += compare(accessor, map, {}, random, 300);
    expectBox(accessor, map, {}, {{-5, -6, -3}, {6, 2, 1}});
    expectBox(accessor, map, {}, {{-100, -100, -100}, {100, 100, 100}});
  }
  EXPECT_GT(known * 20, 50 * seeds(20));
}
}  // namespace
}  // namespace lamap::test
