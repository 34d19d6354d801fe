#include <gtest/gtest.h>
#include <lamap_core/grid/cell_extent.h>
#include <lamap_core/grid/octant_rule.h>
#include <support/seeded_scans.h>

#include <algorithm>
#include <map>

namespace lamap::test
{
namespace
{
bool isSet(const std::vector<bool>& cells, const BlockShape& shape, int axis, int layer)
{
  for (uint32_t offset = 0; offset < shape.cellCount(); ++offset)
  {
    const CellIndex local = shape.localOf(offset);
    const int at = axis == 0 ? local.x : axis == 1 ? local.y : local.z;
    if (cells[offset] && at == layer) return true;
  }
  return false;
}

TEST(BlockLayers, AreThoseOfTheCellsOfABlockOfAnyShape)
{
  for (const bool planar : {false, true})
    for (int log2Edge = 1; log2Edge <= 5; ++log2Edge)
    {
      const BlockShape shape(log2Edge, planar);
      EXPECT_TRUE(EvidenceBlock().layers(shape) == BlockLayers{});
      Random random(static_cast<uint64_t>(log2Edge));
      for (int trial = 0; trial < 30; ++trial)
      {
        SCOPED_TRACE(testing::Message() << planar << " " << log2Edge << " " << trial);
        DenseBlock dense(shape);
        std::vector<bool> cells(shape.cellCount());
        for (int i = 0, count = random.integer(1, trial < 20 ? 3 : 200); i < count; ++i)
        {
          const auto offset =
              static_cast<uint32_t>(random.integer(0, static_cast<int>(shape.cellCount()) - 1));
          cells[offset] = true;
          dense.set(offset, {1, 0});
        }
        EvidenceBlock block;
        block.pack(shape, dense, mergeEqual);
        const BlockLayers layers = block.layers(shape);
        for (int axis = 0; axis < 3; ++axis)
          for (int layer = 0; layer < kMostBlockEdge; ++layer)
            ASSERT_EQ(layers[static_cast<size_t>(axis)] >> layer & 1u,
                      isSet(cells, shape, axis, layer) ? 1u : 0u);
      }
    }
}

/// Blocks with the layers of their cells, and the extent that a walk of them all finds.
struct ListedBlocks
{
  explicit ListedBlocks(const BlockShape& ofShape) : shape(ofShape) {}

  void expectSame(const CellExtent& extent) const
  {
    const auto bounds = extent.bounds();
    ASSERT_EQ(bounds.has_value(), !layers.empty());
    if (!bounds) return;
    std::array<int32_t, 3> low{INT32_MAX, INT32_MAX, INT32_MAX};
    std::array<int32_t, 3> high{INT32_MIN, INT32_MIN, INT32_MIN};
    for (const auto& [index, held] : layers)
    {
      const CellIndex first = shape.firstCellOf(index);
      const std::array<int32_t, 3> firsts{first.x, first.y, first.z};
      for (size_t axis = 0; axis < 3; ++axis)
        for (int layer = 0; layer < kMostBlockEdge; ++layer)
        {
          if ((held[axis] >> layer & 1u) == 0) continue;
          low[axis] = std::min(low[axis], firsts[axis] + layer);
          high[axis] = std::max(high[axis], firsts[axis] + layer);
        }
    }
    ASSERT_TRUE(bounds->first == (CellIndex{low[0], low[1], low[2]}));
    ASSERT_TRUE(bounds->second == (CellIndex{high[0], high[1], high[2]}));
  }

  BlockShape shape;
  std::map<BlockIndex, BlockLayers> layers;
};

BlockLayers randomLayers(Random& random, const BlockShape& shape)
{
  BlockLayers layers{};
  for (size_t axis = 0; axis < 3; ++axis)
  {
    const int edge = shape.planar() && axis == 2 ? 1 : shape.edge();
    for (int i = random.integer(1, 3); i > 0; --i) layers[axis] |= 1u << random.integer(0, edge - 1);
  }
  return layers;
}

BlockLayers joined(const BlockLayers& a, const BlockLayers& b)
{
  return {a[0] | b[0], a[1] | b[1], a[2] | b[2]};
}

TEST(CellExtent, FollowsBlocksThatGrowShrinkAndGo)
{
  for (unsigned seed = 1; seed <= 40; ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    ListedBlocks listed(BlockShape(random.integer(1, 5), seed % 3 == 0));
    CellExtent extent(listed.shape);
    const int reach = seed % 4 == 0 ? 30000000 : 6;
    for (int step = 0; step < 200; ++step)
    {
      const BlockIndex index{random.integer(-reach, reach), random.integer(-3, 3), random.integer(-2, 2)};
      const auto found = listed.layers.find(index);
      const BlockLayers before = found == listed.layers.end() ? BlockLayers{} : found->second;
      const BlockLayers other = randomLayers(random, listed.shape);
      if (step < 100 ? random.integer(0, 3) > 0 : random.integer(0, 3) == 0)
      {
        extent.grow(index, before, joined(before, other));
        listed.layers[index] = joined(before, other);
      }
      else if (!listed.layers.empty())
      {
        auto shrunk =
            std::next(listed.layers.begin(), random.integer(0, static_cast<int>(listed.layers.size()) - 1));
        const BlockLayers kept{shrunk->second[0] & other[0], shrunk->second[1] & other[1],
                               shrunk->second[2] & other[2]};
        const bool isGone = kept[0] == 0 || kept[1] == 0 || kept[2] == 0;
        extent.shrink(shrunk->first, shrunk->second, isGone ? BlockLayers{} : kept);
        if (isGone)
          listed.layers.erase(shrunk);
        else
          shrunk->second = kept;
      }
      listed.expectSame(extent);
      if (testing::Test::HasFatalFailure()) return;
    }
    for (const auto& [index, held] : listed.layers) extent.shrink(index, held, {});
    EXPECT_FALSE(extent.bounds());
    EXPECT_EQ(extent.emptyAround({5, 5, 5}), 23) << "all cubes are taken back";
  }
}

TEST(CellCubes, AreEmptyOnlyWhereNothingWasAddedBeside)
{
  CellCubes cubes;
  EXPECT_EQ(cubes.emptyAround({0, 0, 0}), 23);
  cubes.add({3, 40, -1});
  cubes.add({4, 41, -2});  // in the same cube
  EXPECT_EQ(cubes.emptyAround({3, 40, -1}), 0);
  EXPECT_EQ(cubes.emptyAround({-1, 40, 31}), 0) << "beside it";
  EXPECT_EQ(cubes.emptyAround({3, 40, 64}), 5);
  EXPECT_EQ(cubes.emptyAround({3, 40, 5000}), 11);
  cubes.remove({3, 40, -1});
  EXPECT_EQ(cubes.emptyAround({3, 40, 64}), 5);
  cubes.remove({3, 40, -1});
  EXPECT_EQ(cubes.emptyAround({3, 40, 64}), 23);
}

}  // namespace
}  // namespace lamap::test
