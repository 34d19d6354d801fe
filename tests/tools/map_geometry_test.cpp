#include <gtest/gtest.h>
#include <lamap_tools/scores/map_geometry.h>
#include <lamap_tools/scores/map_scores.h>
#include <lamap_tools/scores/score_report.h>

#include <cmath>
#include <limits>
#include <random>
#include <sstream>

#include "tools/hand_made_cells.h"

namespace
{
using namespace lamap;
using namespace lamap::tools;
using Eigen::Vector3d;
using test::HandMadeCells;

Truth truthWith(const std::vector<CellIndex>& occupied, const std::vector<CellIndex>& free,
                double edge_m = 0.1)
{
  Truth truth;
  truth.name = "t.csv";
  truth.spacing_m = edge_m;
  for (const CellIndex& cell : occupied) truth.cells.push_back({cellCentre(cell, edge_m), true});
  for (const CellIndex& cell : free) truth.cells.push_back({cellCentre(cell, edge_m), false});
  return truth;
}

MapScores scored(const HandMadeCells& map, const Truth& truth)
{
  return scoreMap({nullptr, std::make_unique<HandMadeCells>(map), std::nullopt}, "a", truth, {0.7});
}

/// A wall in the cells with x = 5, before which is open space.
Truth wall()
{
  return truthWith(
      {{5, 0, 0}, {5, 1, 0}, {5, 2, 0}, {5, 3, 0}, {5, 0, 1}},
      {{4, 0, 0}, {4, 1, 0}, {4, 2, 0}, {4, 3, 0}, {3, 0, 0}, {3, 1, 0}, {3, 2, 0}, {3, 3, 0}, {4, 0, 1}});
}

/// Two cells of the wall, one behind it, one before it, and one far behind it are occupied.
HandMadeCells mapOfTheWall()
{
  HandMadeCells map(0.1);
  map.put({5, 0, 0}, 0.9, CellState::Occupied).put({5, 1, 0}, 0.8, CellState::Occupied);
  map.put({6, 1, 0}, 0.9, CellState::Occupied).put({4, 2, 0}, 0.75, CellState::Occupied);
  map.put({9, 0, 0}, 0.95, CellState::Occupied);
  map.put({5, 2, 0}, 0.2, CellState::Free).put({5, 3, 0}, 0.4, CellState::Unknown);
  map.put({4, 0, 0}, 0.1, CellState::Free).put({4, 1, 0}, 0.2, CellState::Free);
  map.put({3, 0, 0}, 0.25, CellState::Free);
  return map;
}

TEST(MapGeometry, ByHandBeforeAWall)
{
  const MapGeometry shape = *scored(mapOfTheWall(), wall()).geometry;
  EXPECT_FALSE(shape.toPoints);
  EXPECT_EQ(shape.occupiedCells, 5U);
  EXPECT_EQ(shape.surfaceCells, 5U);
  EXPECT_NEAR(*shape.meanDistance_m, (0 + 0 + 0.1 + 0.1 + 0.4) / 5, 1e-12);
  EXPECT_NEAR(*shape.distance95_m, 0.4, 1e-12);
  EXPECT_DOUBLE_EQ(*shape.covered, 0.8) << "(5,3,0) is next to (4,2,0) by an edge only";
  EXPECT_DOUBLE_EQ(*shape.occupiedPerSurfaceCell, 1);
  EXPECT_DOUBLE_EQ(*shape.surfaceCalledFree, 0.2);
  EXPECT_DOUBLE_EQ(*shape.freeCalledFree, 3.0 / 9);
  EXPECT_DOUBLE_EQ(*shape.f1, 2 * 2.0 / (3 + 5)) << "three of the truth's cells are called occupied, two are";
}

TEST(MapGeometry, DistancesAreToSurfacePointsWhereThereAreAny)
{
  Truth truth = wall();
  truth.surface_map = {{0.52, 0.05, 0.05}, {0.52, 0.15, 0.05}, {0.52, 0.25, 0.05}};
  const MapGeometry shape = *scored(mapOfTheWall(), truth).geometry;
  EXPECT_TRUE(shape.toPoints);
  EXPECT_NEAR(*shape.meanDistance_m, (0.03 + 0.03 + 0.13 + 0.07 + 0.43) / 5, 1e-12);
  EXPECT_NEAR(*shape.distance95_m, 0.43, 1e-12);
  EXPECT_DOUBLE_EQ(*shape.covered, 0.8) << "of the cells, as before";
}

// A map whose cells say no more than "below 0.5" calls free what is sure enough for all maps.
TEST(MapGeometry, FreeIsTheSameForAMapWithOneThreshold)
{
  HandMadeCells map(0.1);
  map.put({5, 0, 0}, 0.4, CellState::Free).put({5, 1, 0}, 0.29, CellState::Free);
  map.put({4, 0, 0}, 0.4, CellState::Free).put({4, 1, 0}, 0.1, CellState::Free);
  const MapGeometry shape = *scored(map, wall()).geometry;
  EXPECT_DOUBLE_EQ(*shape.surfaceCalledFree, 0.2);
  EXPECT_DOUBLE_EQ(*shape.freeCalledFree, 1.0 / 9);
}

TEST(MapGeometry, OfAMapWithoutOccupiedCellsHasNoDistance)
{
  HandMadeCells map(0.1);
  map.put({5, 0, 0}, 0.2, CellState::Free);
  const MapGeometry shape = *scored(map, wall()).geometry;
  EXPECT_FALSE(shape.meanDistance_m || shape.distance95_m);
  EXPECT_EQ(*shape.covered, 0);
  EXPECT_EQ(*shape.occupiedPerSurfaceCell, 0);
  EXPECT_EQ(*shape.f1, 0);
}

TEST(MapGeometry, CountsForEachSurfaceCellNeedCellsOfOneSize)
{
  HandMadeCells map(0.1);
  map.put({0, 0, 0}, 0.9, CellState::Occupied);
  const MapGeometry shape = *scored(map, truthWith({{0, 0, 0}, {1, 0, 0}}, {{3, 0, 1}}, 0.2)).geometry;
  EXPECT_FALSE(shape.occupiedPerSurfaceCell);
  EXPECT_NEAR(*shape.meanDistance_m, std::sqrt(3) * 0.05, 1e-12);
  EXPECT_DOUBLE_EQ(*shape.covered, 0.5) << "one cell of the truth, 0.2 m, is the reach";
}

TEST(MapGeometry, OfOneLayerIsInItsPlane)
{
  HandMadeCells map(0.1);
  map.put({0, 0, 3}, 0.9, CellState::Occupied).put({2, 0, 3}, 0.9, CellState::Occupied);
  const StateCounts states;
  // A truth of one layer, wherever it is.
  const Truth flat = truthWith({{0, 0, 70}}, {{1, 0, 70}});
  EXPECT_NEAR(*geometryOf(map, 3, flat, states).meanDistance_m, 0.1, 1e-12);
  // One in 3D: its layer.
  Truth deep = truthWith({{0, 0, 3}, {2, 0, 4}}, {{1, 0, 5}});
  EXPECT_NEAR(*geometryOf(map, 3, deep, states).meanDistance_m, 0.1, 1e-12);
  EXPECT_EQ(geometryOf(map, 3, deep, states).surfaceCells, 1U);
  deep.surface_map = {{0.05, 0.05, 0.301}, {0.25, 0.05, 0.401}};
  EXPECT_NEAR(*geometryOf(map, 3, deep, states).meanDistance_m, 0.1, 1e-12);
}

TEST(MapGeometry, OfAMapIn3DAndATruthOfOneLayerCountsThatLayer)
{
  HandMadeCells map(0.1);
  map.put({0, 0, 0}, 0.9, CellState::Occupied).put({3, 0, 1}, 0.9, CellState::Occupied);
  const MapGeometry shape =
      geometryOf(map, std::nullopt, truthWith({{0, 0, 0}, {1, 0, 0}}, {{4, 0, 0}}), StateCounts());
  EXPECT_EQ(shape.occupiedCells, 1U);
  EXPECT_EQ(*shape.meanDistance_m, 0);
  EXPECT_EQ(*shape.covered, 1);
}

TEST(MapGeometryProperty, DistancesAreThoseOfAllPairs)
{
  for (unsigned seed = 1; seed <= 10; ++seed)
  {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const auto any = [&] { return static_cast<int32_t>(random() % 40) - 20; };
    HandMadeCells map(0.1);
    std::vector<Vector3d> occupied;
    for (int i = 0; i < 60; ++i)
    {
      const CellIndex cell{any(), any(), any()};
      map.put(cell, 0.9, CellState::Occupied);
      occupied.push_back(cellCentre(cell, 0.1));
    }
    Truth truth = truthWith({{0, 0, 0}, {1, 2, 3}}, {{7, 7, 7}});
    for (int i = 0; i < 80; ++i) truth.surface_map.emplace_back(0.09 * any(), 0.09 * any(), 0.09 * any());
    std::vector<double> distances;
    double sum = 0;
    for (const Vector3d& centre : occupied)
    {
      double least = std::numeric_limits<double>::infinity();
      for (const Vector3d& point : truth.surface_map) least = std::min(least, (point - centre).norm());
      distances.push_back(least);
      sum += least;
    }
    std::sort(distances.begin(), distances.end());
    const MapGeometry shape = geometryOf(map, std::nullopt, truth, StateCounts());
    EXPECT_NEAR(*shape.meanDistance_m, sum / 60, 1e-12);
    EXPECT_NEAR(*shape.distance95_m, distances[56], 1e-12) << "57 of 60 are 95 %";
  }
}

TEST(MapGeometry, IsReportedForPeopleAndPrograms)
{
  const MapScores scores = scored(mapOfTheWall(), wall());
  std::ostringstream text;
  printScores({scores}, "cells", text);
  for (const char* part : {"12.00", "40.00", "80.0 %", "20.0 %", "33.3 %", "0.5000", "p < 0.3",
                           "centre of an occupied cell of the truth"})
    EXPECT_NE(text.str().find(part), std::string::npos) << part << "\n" << text.str();
  const Json json = scoresJson(scores).at("geometry");
  EXPECT_EQ(json.at("distancesTo"), "cells");
  EXPECT_NEAR(json.at("meanDistance").get<double>(), 0.12, 1e-12);
  EXPECT_NEAR(json.at("distance95").get<double>(), 0.4, 1e-12);
  EXPECT_EQ(json.at("covered"), 0.8);
  EXPECT_EQ(json.at("surfaceCalledFree"), 0.2);
  EXPECT_EQ(scoringJson().at("calledFreeBelow"), kCalledFreeBelow);
}
}  // namespace
