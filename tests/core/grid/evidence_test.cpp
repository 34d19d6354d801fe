#include <gtest/gtest.h>
#include <lamap_core/grid/evidence.h>
#include <lamap_core/grid/scan_blocks.h>
#include <support/grid_words.h>
#include <support/seeded_scans.h>

#include <algorithm>
#include <map>
#include <stdexcept>
#include <string>
#include <tuple>

namespace lamap::test
{
namespace
{
void put(Evidence& grid, const CellIndex& cell, const CellSums& evidence)
{
  EvidenceBlock& block = grid.findOrCreate(grid.blockOf(cell));
  DenseBlock dense(grid.shape());
  block.unpack(grid.shape(), dense);
  dense.set(grid.shape().offsetOf(cell), evidence);
  block.pack(grid.shape(), dense, {});
}

TEST(Evidence, FindsTheBlockOfACellOnBothSidesOfTheOrigin)
{
  for (const bool planar : {false, true})
    for (int log2Edge = 1; log2Edge <= 5; ++log2Edge)
    {
      const Evidence grid(BlockShape(log2Edge, planar));
      const int edge = 1 << log2Edge;
      Random random(static_cast<uint64_t>(log2Edge));
      for (int i = 0; i < 200; ++i)
      {
        const int reach = i < 100 ? 3 * edge : 2147000000;
        const CellIndex cell{random.integer(-reach, reach), random.integer(-reach, reach),
                             random.integer(-reach, reach)};
        const auto floorDivided = [edge](int32_t index)
        { return static_cast<int32_t>(std::floor(index / double(edge))); };
        const BlockIndex block = grid.blockOf(cell);
        EXPECT_EQ(block.x, floorDivided(cell.x));
        EXPECT_EQ(block.y, floorDivided(cell.y));
        EXPECT_EQ(block.z, planar ? cell.z : floorDivided(cell.z));
        const CellIndex first = grid.firstCellOf(block);
        const CellIndex local = grid.shape().localOf(grid.shape().offsetOf(cell));
        EXPECT_TRUE((CellIndex{first.x + local.x, first.y + local.y, first.z + local.z}) == cell);
      }
    }
}

TEST(Evidence, GivesBackWhatWasPutAndZeroElsewhere)
{
  for (unsigned seed = 1; seed <= 20; ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    Evidence grid(BlockShape(random.integer(1, 5), seed % 2 == 0));
    std::map<std::tuple<int, int, int>, CellSums> truth;
    const int reach = 40;
    for (int i = 0; i < 100; ++i)
    {
      const CellIndex cell{random.integer(-reach, reach), random.integer(-reach, reach),
                           random.integer(-reach, reach)};
      const CellSums evidence{random.bits() >> 33, 1 + (random.bits() >> 33)};
      put(grid, cell, evidence);
      truth[{cell.z, cell.y, cell.x}] = evidence;
    }
    for (int i = 0; i < 2000; ++i)
    {
      const CellIndex cell{random.integer(-reach, reach), random.integer(-reach, reach),
                           random.integer(-reach, reach)};
      const auto found = truth.find({cell.z, cell.y, cell.x});
      EXPECT_TRUE(grid.at(cell) == (found == truth.end() ? CellSums{} : found->second));
    }
    const std::vector<CellEvidence> cells = cellsOf(grid);
    ASSERT_EQ(cells.size(), truth.size());
    auto expected = truth.begin();
    for (const CellEvidence& cell : cells) EXPECT_TRUE(cell.evidence == (expected++)->second);
  }
}

TEST(Evidence, SortsItsBlocksByZThenYThenX)
{
  Evidence grid(BlockShape(3, false));
  Random random(3);
  for (int i = 0; i < 300; ++i)
    grid.findOrCreate({random.integer(-5, 5), random.integer(-5, 5), random.integer(-5, 5)});
  const std::vector<BlockIndex> blocks = grid.sortedBlocks();
  ASSERT_EQ(blocks.size(), grid.blockCount());
  for (size_t i = 1; i < blocks.size(); ++i)
    EXPECT_LT(std::make_tuple(blocks[i - 1].z, blocks[i - 1].y, blocks[i - 1].x),
              std::make_tuple(blocks[i].z, blocks[i].y, blocks[i].x));
}

TEST(Evidence, CopiesItsBlocks)
{
  Evidence grid(BlockShape(2, false));
  put(grid, {1, 2, 3}, {4, 5});
  put(grid, {-1, 2, 3}, {6, 7});
  Evidence copy(grid), assigned(BlockShape(3, true));
  assigned = grid;
  EXPECT_EQ(differenceOf(copy, grid), "");
  EXPECT_EQ(differenceOf(assigned, grid), "");
  EXPECT_TRUE(assigned.shape() == grid.shape());
  put(copy, {1, 2, 3}, {40, 50});
  EXPECT_TRUE(grid.at({1, 2, 3}) == (CellSums{4, 5}));
  EXPECT_NE(differenceOf(copy, grid), "");
  grid.clear();
  EXPECT_EQ(grid.blockCount(), 0u);
  EXPECT_TRUE(assigned.at({-1, 2, 3}) == (CellSums{6, 7}));
}

TEST(Evidence, CountsTheBytesOfBlocksAndIndex)
{
  Evidence grid(BlockShape(3, false));
  for (int x = -64; x < 64; ++x) put(grid, {x, 0, 0}, {1, 1});
  // 16 blocks, each 8 mask words and 8 leaves.
  EXPECT_GE(grid.memoryBytes(), 16u * 16u * 8u);
  EXPECT_LE(grid.memoryBytes(), 16u * 16u * 8u + 16384u);
}
}  // namespace
TEST(ScanBlocks, NumberBlocksInTheOrderOfTheirFirstTouch)
{
  // A window that is held densely, and one that needs the hash table.
  for (const int32_t edge : {10, 1000})
  {
    ScanBlocks blocks;
    for (int round = 0; round < 2; ++round)
    {
      SCOPED_TRACE(edge);
      blocks.reset({-edge, -edge, -edge}, {edge, edge, edge});
      EXPECT_EQ(blocks.find({1, 2, 3}), -1);
      EXPECT_EQ(blocks.findOrAdd({1, 2, 3}), 0);
      EXPECT_EQ(blocks.findOrAdd({-edge, edge, 0}), 1);
      EXPECT_EQ(blocks.findOrAdd({1, 2, 3}), 0);
      EXPECT_EQ(blocks.find({-edge, edge, 0}), 1);
      EXPECT_EQ(blocks.find({edge + 1, 0, 0}), -1);
    }
  }
}

TEST(CellAt, ReachesEquallyFarOnBothSidesOfTheOrigin)
{
  constexpr double kFirstBeyond = 2'140'000'000;
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {1.0, -1.0})
    {
      Eigen::Vector3d point = Eigen::Vector3d::Constant(0.5);
      point[axis] = sign * (kFirstBeyond - 1) + 0.5;
      EXPECT_TRUE(cellAt(point, 1)) << point.transpose();
      point[axis] = sign * kFirstBeyond + 0.5;
      EXPECT_FALSE(cellAt(point, 1)) << point.transpose();
    }
}

TEST(ScanBlocks, RefuseMoreThanAMachineCanHold)
{
  constexpr auto kSide = int32_t{1} << 11;
  // Room for twice as many as are allowed, held densely; and for more, held in the hash table.
  for (const int32_t layers : {2, 9})
  {
    SCOPED_TRACE(layers);
    ScanBlocks blocks;
    blocks.reset({0, 0, 0}, {kSide - 1, kSide - 1, layers - 1});
    for (int32_t y = 0; y < kSide; ++y)
    {
      for (int32_t x = 0; x < kSide; ++x) ASSERT_EQ(blocks.findOrAdd({x, y, 0}), y * kSide + x);
    }
    EXPECT_EQ(blocks.findOrAdd({5, 5, 0}), 5 * kSide + 5) << "a block that is known";
    try
    {
      (void)blocks.findOrAdd({0, 0, 1});
      FAIL() << "one block too many was taken";
    }
    catch (const std::length_error& error)
    {
      EXPECT_NE(std::string(error.what()).find("maxRange"), std::string::npos) << error.what();
    }
  }
}

}  // namespace lamap::test
