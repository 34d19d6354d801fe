#include <gtest/gtest.h>
#include <lamap_sim/scanner.h>
#include <lamap_sim/surface_truth.h>

#include <cmath>
#include <map>
#include <set>
#include <stdexcept>
#include <tuple>

namespace lamap::sim
{
namespace
{
using Eigen::Vector3d;
using Key = std::tuple<int, int, int>;

std::set<Key> cellsWith(const std::vector<TrueCell>& cells, bool occupied)
{
  std::set<Key> keys;
  for (const TrueCell& cell : cells)
    if (cell.occupied == occupied) keys.emplace(cell.index.x, cell.index.y, cell.index.z);
  return keys;
}

/// Looks everywhere, up to 8 m, with a single beam ahead.
SensorModel eye()
{
  SensorModel sensor;
  sensor.name = "eye";
  sensor.rangeMax_m = 8;
  sensor.beams = {Vector3d::UnitX()};
  sensor.azimuthSpan_rad = 2 * M_PI;
  sensor.elevationLow_rad = -M_PI / 2;
  sensor.elevationHigh_rad = M_PI / 2;
  return sensor;
}

/// 1 × 0.75 × 0.25 m, which are 4 × 3 × 1 cells of 0.25 m, with a wall across it.
World cellsBeforeAWall(double wallX, std::vector<Shape> others = {})
{
  World world;
  world.name = "wall";
  world.interior_map = {Vector3d(0, 0, 0), Vector3d(1, 0.75, 0.25)};
  others.emplace_back(HalfSpace{-Vector3d::UnitX(), -wallX});
  world.scene = Scene(std::move(others));
  return world;
}

Pose standing(double x, double y, double z)
{
  Pose pose;
  pose.position_map = {x, y, z};
  return pose;
}

// The wall is solid from x = 0.85, in the cells with index 3. Around the interior, one more layer of cells is
// looked at, in which nothing is called free.
TEST(SurfaceTruth, ByHandBeforeAWall)
{
  const auto cells = surfaceTruthOf(cellsBeforeAWall(0.85), eye(), {standing(0.1, 0.375, 0.125)}, 0.25);
  std::set<Key> wall;
  std::set<Key> open;
  for (int y = -1; y <= 3; ++y)
    for (int z = -1; z <= 1; ++z) wall.emplace(3, y, z);
  for (int x = 0; x < 3; ++x)
    for (int y = 0; y < 3; ++y) open.emplace(x, y, 0);
  EXPECT_EQ(cellsWith(cells, true), wall);
  EXPECT_EQ(cellsWith(cells, false), open);
}

TEST(SurfaceTruth, ASurfaceOnTheFaceOfTwoCellsBelongsToTheSolidOne)
{
  const auto cells = surfaceTruthOf(cellsBeforeAWall(0.75), eye(), {standing(0.1, 0.375, 0.125)}, 0.25);
  for (int y = 0; y < 3; ++y)
  {
    EXPECT_EQ(cellsWith(cells, true).count({3, y, 0}), 1U);
    EXPECT_EQ(cellsWith(cells, false).count({2, y, 0}), 1U);
  }
}

// A post of 2 cm in the middle of cell (1, 1, 0): the sensor sees past it on both sides, but not the centre
// of the cell behind it.
TEST(SurfaceTruth, AThinPostFillsItsCellAndHidesTheCentreBehindIt)
{
  const Cylinder post{{0.375, 0.375}, 0.01, -1, 1};
  const auto cells =
      surfaceTruthOf(cellsBeforeAWall(0.85, {post}), eye(), {standing(0.1, 0.375, 0.125)}, 0.25);
  EXPECT_EQ(cellsWith(cells, true).count({1, 1, 0}), 1U);
  EXPECT_EQ(cellsWith(cells, true).count({3, 1, 0}), 1U);
  EXPECT_EQ(cellsWith(cells, false).count({2, 1, 0}), 0U);
  EXPECT_EQ(cellsWith(cells, false).count({2, 0, 0}), 1U);
  EXPECT_EQ(cellsWith(cells, false).size(), 7U);
  const auto fromBeside = surfaceTruthOf(cellsBeforeAWall(0.85, {post}), eye(),
                                         {standing(0.1, 0.375, 0.125), standing(0.1, 0.1, 0.125)}, 0.25);
  EXPECT_EQ(cellsWith(fromBeside, false).size(), 8U) << "all but the post's";
}

TEST(SurfaceTruth, OnlyWhatLiesInTheFieldOfViewAndInRangeIsScored)
{
  SensorModel ahead = eye();
  ahead.azimuthSpan_rad = M_PI / 2;
  // From the middle, x = 0.5: the cells ahead of it at less than 45°, by their centres.
  auto cells = surfaceTruthOf(cellsBeforeAWall(0.85), ahead, {standing(0.5, 0.375, 0.125)}, 0.25);
  EXPECT_EQ(cellsWith(cells, false), (std::set<Key>{{2, 1, 0}}));
  SensorModel near = eye();
  near.rangeMax_m = 0.3;
  cells = surfaceTruthOf(cellsBeforeAWall(0.85), near, {standing(0.1, 0.375, 0.125)}, 0.25);
  EXPECT_TRUE(cellsWith(cells, true).empty()) << "the wall is 0.75 m away";
  EXPECT_EQ(cellsWith(cells, false), (std::set<Key>{{0, 0, 0}, {0, 1, 0}, {0, 2, 0}, {1, 1, 0}}));
}

TEST(SurfaceTruth, WhatASensorWithFewerBeamsLeavesOutIsScoredAllTheSame)
{
  const World world = makeWorld("structured", 3);
  SensorModel full = makeSensor("sector-laser");
  const auto shots = makeTrajectory(world, full, Motion::Stops, 3);
  SensorModel thinned = full;
  thinned.beams = {full.beams.front()};
  const size_t withAll = surfaceTruthOf(world, full, shots, 0.1).size();
  const size_t withOne = surfaceTruthOf(world, thinned, shots, 0.1).size();
  EXPECT_GT(withOne, withAll * 99 / 100);
  EXPECT_LE(withOne, withAll);
}

/// What a world is seen with.
SensorModel sensorOf(const std::string& world)
{
  return makeSensor(world == "flatland" ? "planar-laser" : world == "pier" ? "sonar" : "sector-laser");
}

/// The shots of an exact log.
std::vector<Pose> shotsIn(const World& world, const SensorModel& sensor)
{
  return makeTrajectory(world, sensor, Motion::Stops, sensor.kind == SensorKind::Sonar ? 1 : 6);
}

TEST(SurfaceTruthProperty, EveryExactReturnEndsInAnOccupiedCellOrOnItsFace)
{
  for (const std::string& name : worldNames())
    for (const uint64_t seed : {1U, 2U})
    {
      SCOPED_TRACE(name + " " + std::to_string(seed));
      const World world = makeWorld(name, seed);
      const SensorModel sensor = sensorOf(name);
      if (sensor.kind == SensorKind::Sonar) continue;  // a ping has a range, but no place
      const auto shots = shotsIn(world, sensor);
      const double resolution = name == "corridor" ? 0.2 : 0.1;
      const auto cells = surfaceTruthOf(world, sensor, shots, resolution);
      const std::set<Key> occupied = cellsWith(cells, true);
      const std::set<Key> open = cellsWith(cells, false);
      const Scanner scanner(world, sensor, {}, seed);
      size_t returns = 0;
      for (size_t i = 0; i < shots.size(); ++i)
        for (const BeamReading& reading : scanner.scan(shots[i], i))
        {
          if (!reading.range_m) continue;
          ++returns;
          const Vector3d end = rotationOf(shots[i]) * reading.point_sensor + shots[i].position_map;
          bool found = false;
          constexpr double kRounding_m = 1e-6;
          for (int corner = 0; corner < 8; ++corner)
          {
            const Vector3d side(corner & 1, corner >> 1 & 1, corner >> 2);
            const auto cell = *cellAt(end + kRounding_m * (2 * side.array() - 1).matrix(), resolution);
            found = found || occupied.count({cell.x, cell.y, world.flat ? 0 : cell.z}) == 1;
          }
          ASSERT_TRUE(found) << end.transpose();
        }
      EXPECT_GT(returns, 1000U);
      EXPECT_GT(open.size(), occupied.size());
    }
}

TEST(SurfaceTruthProperty, FreeCellsHoldNoSolidAndOccupiedOnesHoldASurface)
{
  for (const std::string& name : worldNames())
  {
    SCOPED_TRACE(name);
    const World world = makeWorld(name, 4);
    const SensorModel sensor = sensorOf(name);
    const double resolution = name == "corridor" || name == "pier" ? 0.25 : 0.1;
    Random random(3);
    size_t occupied = 0;
    for (const TrueCell& cell : surfaceTruthOf(world, sensor, shotsIn(world, sensor), resolution))
    {
      const Vector3d low = resolution * Vector3d(cell.index.x, cell.index.y, cell.index.z);
      const Eigen::AlignedBox3d box(low, low + Vector3d::Constant(resolution));
      occupied += cell.occupied ? 1 : 0;
      if (cell.occupied)
      {
        ASSERT_EQ(world.scene.relationOf(box), Relation::Mixed) << low.transpose();
      }
      else
        for (int i = 0; i < 4; ++i)
        {
          const Vector3d share{random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)};
          ASSERT_FALSE(world.scene.solidAt(low + resolution * share)) << low.transpose();
        }
    }
    EXPECT_GT(occupied, 200U);
  }
}

TEST(SurfaceTruth, IsSortedAndOfAFlatWorldOneLayer)
{
  for (const char* name : {"structured", "flatland"})
  {
    const World world = makeWorld(name, 1);
    const SensorModel sensor = sensorOf(name);
    const auto cells = surfaceTruthOf(world, sensor, shotsIn(world, sensor), 0.2);
    ASSERT_GT(cells.size(), 500U);
    for (size_t i = 1; i < cells.size(); ++i)
    {
      const CellIndex& a = cells[i - 1].index;
      const CellIndex& b = cells[i].index;
      ASSERT_LT(std::tie(a.z, a.y, a.x), std::tie(b.z, b.y, b.x));
      ASSERT_TRUE(!world.flat || b.z == 0);
    }
  }
}

TEST(SurfaceTruth, RefusesIllegalOptionsAndStopsWhenAsked)
{
  const World world = makeWorld("structured", 1);
  const SensorModel sensor = makeSensor("sector-laser");
  const auto shots = shotsIn(world, sensor);
  for (const double resolution : {0.0, -0.1, std::nan(""), 1e-6, HUGE_VAL})
    EXPECT_THROW((void)surfaceTruthOf(world, sensor, shots, resolution), std::invalid_argument) << resolution;
  for (int calls = 0; calls < 200; calls += 40)
  {
    int left = calls;
    EXPECT_TRUE(surfaceTruthOf(world, sensor, shots, 0.1, [&] { return left-- <= 0; }).empty()) << calls;
  }
}

TEST(SurfacePoints, LieOnSurfacesAndCoverThem)
{
  for (const std::string& name : worldNames())
  {
    SCOPED_TRACE(name);
    const World world = makeWorld(name, 6);
    const SensorModel sensor = sensorOf(name);
    const double resolution = name == "corridor" || name == "pier" ? 0.25 : 0.1;
    std::set<Key> holding;
    for (const Vector3d& point : surfacePointsOf(world, resolution))
    {
      bool differs = false;
      for (int axis = 0; axis < 3; ++axis)
      {
        const Vector3d step = 1e-7 * Vector3d::Unit(axis);
        differs = differs || world.scene.solidAt(point - step) != world.scene.solidAt(point + step);
      }
      ASSERT_TRUE(differs) << point.transpose();
      const auto cell = *cellAt(point, resolution);
      holding.emplace(cell.x, cell.y, cell.z);
    }
    size_t occupied = 0;
    size_t without = 0;
    for (const TrueCell& cell : surfaceTruthOf(world, sensor, shotsIn(world, sensor), resolution))
    {
      if (!cell.occupied) continue;
      ++occupied;
      without += 1 - holding.count({cell.index.x, cell.index.y, cell.index.z});
    }
    EXPECT_GT(occupied, 200U);
    EXPECT_LT(without, occupied / 20) << "only a surface that cuts a corner may be missed";
  }
}

TEST(Scene, CrossingsAreThoseOfTheUnion)
{
  const Scene scene({boxBetween({1, -1, -1}, {3, 1, 1}), boxBetween({2, -1, -1}, {4, 1, 1}),
                     Ellipsoid{{6, 0, 0}, {0.5, 1, 1}}, HalfSpace{-Vector3d::UnitX(), -8},
                     boxBetween({1, 5, 5}, {2, 6, 6})});
  EXPECT_EQ(scene.crossings({0, 0, 0}, Vector3d::UnitX(), 10), (std::vector<double>{1, 4, 5.5, 6.5, 8}));
  EXPECT_EQ(scene.crossings({10, 0, 0}, -Vector3d::UnitX(), 10), (std::vector<double>{2, 3.5, 4.5, 6, 9}));
  EXPECT_EQ(scene.crossings({2, 0, 0}, Vector3d::UnitX(), 2.5), (std::vector<double>{2}));
  const Scene touching(
      {boxBetween({0.125, -1, -1}, {0.3, 1, 1}), boxBetween({0.1 + 0.2, -1, -1}, {2, 1, 1})});
  EXPECT_EQ(touching.crossings({0, 0, 0}, Vector3d::UnitX(), 5), (std::vector<double>{0.125, 2}));
  EXPECT_TRUE(scene.crossings({0, 3, 0}, Vector3d::UnitX(), 7.5).empty());
}

TEST(FieldOfView, ContainsEveryBeamAndNothingBehind)
{
  for (const std::string& name : sensorNames())
  {
    SCOPED_TRACE(name);
    const SensorModel sensor = makeSensor(name);
    const FieldOfView field(sensor);
    for (const Vector3d& beam : sensor.beams) ASSERT_TRUE(field.contains(beam)) << beam.transpose();
    EXPECT_EQ(field.contains(-Vector3d::UnitX()), sensor.azimuthSpan_rad > 6) << "all around or not";
    if (sensor.kind != SensorKind::Planar)
    {
      EXPECT_FALSE(field.contains(Vector3d::UnitZ()));
    }
  }
  const FieldOfView sector(makeSensor("sector-laser"));  // 120° × 60°
  EXPECT_TRUE(sector.contains({std::cos(1.04), std::sin(1.04), 0}));
  EXPECT_FALSE(sector.contains({std::cos(1.06), std::sin(1.06), 0}));
  EXPECT_TRUE(sector.contains({std::cos(0.52), 0, -std::sin(0.52)}));
  EXPECT_FALSE(sector.contains({std::cos(0.53), 0, -std::sin(0.53)}));
}
}  // namespace
}  // namespace lamap::sim
