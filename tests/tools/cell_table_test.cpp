#include <gtest/gtest.h>
#include <lamap_mrpt/files/map_file.h>
#include <lamap_mrpt/maps/CBGKMap.h>
#include <lamap_tools/cells/cell_table.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/maps/COctoMap.h>
#include <mrpt/maps/CSimplePointsMap.h>

#include <cmath>

#include "support/temporary_folder.h"
#include "tools/cell_rows.h"
#include "tools/hand_made_cells.h"

namespace
{
using namespace lamap;
using namespace lamap::tools;
using lamap::test::CellTable;
using lamap::test::readCellTable;
using test::HandMadeCells;

/// One layer after the other, each in an order that is not the table's.
HandMadeCells scattered()
{
  HandMadeCells map(0.25);
  for (const CellIndex& cell :
       {CellIndex{3, 0, 1}, {-2, 5, 1}, {3, -1, 1}, {0, 0, -4}, {1, 0, -4}, {0, 0, 7}})
    map.put(cell, 0.5 + 0.01 * cell.x, CellState::Unknown);
  return map;
}

TEST(CellTable, IsSortedByZThenYThenX)
{
  const CellTable table = readCellTable(scattered());
  std::vector<CellIndex> order;
  for (const CellRow& row : table.rows) order.push_back(row.index);
  const std::vector<CellIndex> expected = {{0, 0, -4}, {1, 0, -4}, {3, -1, 1},
                                           {3, 0, 1},  {-2, 5, 1}, {0, 0, 7}};
  EXPECT_EQ(order, expected);
}

TEST(CellTable, FindsTheRowsItHasAndNoOthers)
{
  const CellTable table = readCellTable(scattered());
  ASSERT_NE(table.find({-2, 5, 1}), nullptr);
  EXPECT_DOUBLE_EQ(table.find({-2, 5, 1})->estimate.prob, 0.48);
  EXPECT_EQ(table.find({-2, 5, 2}), nullptr);
  EXPECT_EQ(table.find({100, 100, 100}), nullptr);
}

TEST(CellTable, WalkInGroupsOfLayersEqualsTheWholeTable)
{
  const HandMadeCells map = scattered();
  const CellTable table = readCellTable(map);
  for (const size_t rowsInMemory : {1, 2, 3, 4, 5, 6, 100})
  {
    SCOPED_TRACE(rowsInMemory);
    std::vector<CellIndex> order;
    visitCellsSorted(
        map, [&](const CellRow& row) { order.push_back(row.index); }, rowsInMemory);
    ASSERT_EQ(order.size(), table.rows.size());
    for (size_t i = 0; i < order.size(); ++i) EXPECT_EQ(order[i], table.rows[i].index);
  }
}

TEST(CellTable, ExtentHoldsTheOutermostCells)
{
  const auto extent = cellExtent(scattered());
  ASSERT_TRUE(extent);
  EXPECT_EQ(extent->first, (CellIndex{-2, -1, -4}));
  EXPECT_EQ(extent->last, (CellIndex{3, 5, 7}));
  EXPECT_FALSE(cellExtent(HandMadeCells()));
}

TEST(CellMapOf, LearnedMapGivesItsOwnCells)
{
  auto map = std::make_shared<CBGKMap>(0.1);
  map->updateVoxel(0.05, 0.05, 0.05, true);
  map->updateVoxel(1.05, 0.05, 0.05, false);
  const auto cells = cellsOf(map);
  ASSERT_TRUE(cells);
  EXPECT_EQ(cells->className(), "lamap::CBGKMap");
  EXPECT_EQ(cells->evidenceNames(), (std::vector<std::string>{"alpha", "beta"}));
  size_t fromMap = 0;
  map->visitCells([&](const CellIndex&, const CellEstimate&) { ++fromMap; });
  EXPECT_EQ(readCellTable(*cells).rows.size(), fromMap);
  EXPECT_GT(fromMap, 0U);
  EXPECT_EQ(cells->estimateAt({0.05, 0.05, 0.05})->prob, map->estimateAt({0.05, 0.05, 0.05})->prob);
}

// MRPT's octree is asked for its leaves through what it draws: every cell must be found, pruned ones
// expanded.
TEST(CellMapOf, MrptOctoMapGivesEveryCellWithItsProbability)
{
  auto map = std::make_shared<mrpt::maps::COctoMap>(0.1);
  map->renderingOptions.generateFreeVoxels = false;
  for (int x = 0; x < 4; ++x)
    for (int y = 0; y < 4; ++y)
      for (int z = 0; z < 4; ++z) map->updateVoxel(0.1 * x + 0.05, 0.1 * y + 0.05, 0.1 * z + 0.05, false);
  map->updateVoxel(-0.35, 0.25, 1.05, true);
  map->updateVoxel(-0.35, 0.25, 1.05, true);

  const CellTable table = readCellTable(*cellsOf(map));
  ASSERT_EQ(table.rows.size(), 65U);
  EXPECT_FALSE(map->renderingOptions.generateFreeVoxels) << "what was to be drawn is as it was";
  for (int x = 0; x < 4; ++x)
    for (int y = 0; y < 4; ++y)
      for (int z = 0; z < 4; ++z)
      {
        ASSERT_NE(table.find({x, y, z}), nullptr);
        EXPECT_EQ(table.find({x, y, z})->estimate.state, CellState::Free);
      }
  const CellRow* hit = table.find({-4, 2, 10});
  ASSERT_NE(hit, nullptr);
  EXPECT_EQ(hit->estimate.state, CellState::Occupied);
  double prob = 0;
  ASSERT_TRUE(map->getPointOccupancy(-0.35F, 0.25F, 1.05F, prob));
  EXPECT_EQ(hit->estimate.prob, prob);
  EXPECT_NEAR(hit->estimate.evidence[0], std::log(prob / (1 - prob)), 1e-12);
  EXPECT_EQ(cellsOf(map)->estimateAt({-0.35, 0.25, 1.05})->prob, prob);
  EXPECT_FALSE(cellsOf(map)->estimateAt({5, 5, 5}));
}

TEST(CellMapOf, MrptGridGivesItsObservedCells)
{
  auto grid = std::make_shared<mrpt::maps::COccupancyGridMap2D>(-1.0F, 1.0F, -2.0F, 2.0F, 0.1F);
  grid->setCell(grid->x2idx(0.35F), grid->y2idx(-1.25F), 0.1F);  // MRPT: P(free)
  grid->setCell(grid->x2idx(-0.95F), grid->y2idx(1.95F), 0.9F);
  const CellTable table = readCellTable(*cellsOf(grid));
  EXPECT_EQ(table.resolution_m, 0.1);
  ASSERT_EQ(table.rows.size(), 2U);
  ASSERT_NE(table.find({3, -13, 0}), nullptr);
  EXPECT_NEAR(table.find({3, -13, 0})->estimate.prob, 0.9, 0.01);
  EXPECT_EQ(table.find({3, -13, 0})->estimate.state, CellState::Occupied);
  ASSERT_NE(table.find({-10, 19, 0}), nullptr);
  EXPECT_EQ(table.find({-10, 19, 0})->estimate.state, CellState::Free);
}

TEST(OpenMap, MapWithoutCellsIsNamedByItsClass)
{
  const test::TemporaryFolder folder;
  mrpt::maps::CSimplePointsMap points;
  points.insertPoint(1, 2, 3);
  saveMapFile(points, folder / "points.lamap.gz");
  EXPECT_TRUE(openMap(folder / "points.lamap.gz").map);
  EXPECT_FALSE(openMap(folder / "points.lamap.gz").cells);
  try
  {
    (void)openCellMap(folder / "points.lamap.gz");
    FAIL() << "no error";
  }
  catch (const std::runtime_error& error)
  {
    EXPECT_NE(std::string(error.what()).find("CSimplePointsMap"), std::string::npos) << error.what();
  }
}
}  // namespace
