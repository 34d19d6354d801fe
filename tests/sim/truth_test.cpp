#include <gtest/gtest.h>
#include <lamap_sim/scanner.h>
#include <lamap_sim/truth.h>

#include <cmath>
#include <map>
#include <stdexcept>
#include <tuple>

namespace lamap::sim
{
namespace
{
using Eigen::Vector3d;

Vector3d pointIn(Random& random, const CellIndex& cell, double resolution_m)
{
  const Vector3d share{random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)};
  return (Vector3d(cell.x, cell.y, cell.z) + share) * resolution_m;
}

using Key = std::tuple<int, int, int>;
std::map<Key, bool> labelsOf(const std::vector<TrueCell>& cells)
{
  std::map<Key, bool> labels;
  for (const TrueCell& cell : cells) labels[{cell.index.x, cell.index.y, cell.index.z}] = cell.occupied;
  return labels;
}

TEST(Truth, EveryPointOfACellAgreesWithItsLabel)
{
  for (const std::string& name : worldNames())
  {
    SCOPED_TRACE(name);
    const World world = makeWorld(name, 5);
    const double resolution = name == "corridor" ? 0.2 : 0.1;
    Random random(6);
    int solid = 0;
    for (const TrueCell& cell : truthOf(world, {resolution, 2}))
    {
      solid += cell.occupied ? 1 : 0;
      for (int i = 0; i < 6; ++i)
        ASSERT_EQ(world.scene.solidAt(pointIn(random, cell.index, resolution)), cell.occupied);
    }
    EXPECT_GT(solid, name == "flatland" ? 500 : 5000);
  }
}

// Cells without a label contain a surface, are deep in a wall, or are outside the interior.
TEST(Truth, OmitsNothingElseWithinTheWorld)
{
  const World world = makeWorld("structured", 9);
  const auto labels = labelsOf(truthOf(world, {0.1, 2}));
  const auto at = [&](const CellIndex& cell) { return labels.find({cell.x, cell.y, cell.z}); };
  Random random(2);
  int mixed = 0;
  for (int i = 0; i < 20000; ++i)
  {
    const Vector3d share{random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)};
    const Vector3d point = world.interior_map.min() + share.cwiseProduct(world.interior_map.sizes());
    const CellIndex cell = *cellAt(point, 0.1);
    if (at(cell) != labels.end()) continue;
    bool anySolid = false;
    bool anyOpen = false;
    for (int j = 0; j < 400; ++j)
      (world.scene.solidAt(pointIn(random, cell, 0.1)) ? anySolid : anyOpen) = true;
    for (int corner = 0; corner < 8; ++corner)  // random points miss a sliver at a face
    {
      const Vector3d offset((corner & 1), (corner >> 1 & 1), (corner >> 2));
      if (!world.scene.solidAt((Vector3d(cell.x, cell.y, cell.z) + offset) * 0.1)) anyOpen = true;
    }
    const bool atRim = !world.interior_map.contains(pointIn(random, {cell.x, cell.y, cell.z + 1}, 0.1));
    if (anyOpen && anySolid) ++mixed;
    EXPECT_TRUE(anySolid || atRim);
    if (anyOpen || !anySolid) continue;
    // Solid at all sample points: then every cell up to two away is solid, or the open part is a sliver.
    for (int j = 0; j < 50; ++j)
    {
      const CellIndex near{cell.x + random.integer(-2, 2), cell.y + random.integer(-2, 2),
                           cell.z + random.integer(-2, 2)};
      if (at(near) != labels.end() && !at(near)->second)
        ADD_FAILURE() << "a solid cell within two cells of an open one has no label: "
                      << cellCentre(cell, 0.1).transpose();
    }
  }
  EXPECT_GT(mixed, 500);
}

TEST(Truth, SolidCellsReachAsDeepAsAskedForOnEverySide)
{
  World world;
  world.name = "vault";
  world.interior_map = {Vector3d::Constant(0.05), Vector3d::Constant(0.95)};
  std::vector<Shape> shapes;
  for (int axis = 0; axis < 3; ++axis)
  {
    shapes.emplace_back(HalfSpace{Vector3d::Unit(axis), 0.05});
    shapes.emplace_back(HalfSpace{-Vector3d::Unit(axis), -0.95});
  }
  world.scene = Scene(shapes);
  for (const int depth : {1, 2, 5})
  {
    int count = 0;
    Eigen::Array3i low = Eigen::Array3i::Constant(100);
    Eigen::Array3i high = -low;
    for (const TrueCell& cell : truthOf(world, {0.1, depth}))
    {
      const Eigen::Array3i index(cell.index.x, cell.index.y, cell.index.z);
      low = low.min(index);
      high = high.max(index);
      count += cell.occupied ? 0 : 1;
    }
    // Cells 0 and 9 contain the surfaces.
    EXPECT_TRUE((low == -depth).all()) << low.transpose();
    EXPECT_TRUE((high == 9 + depth).all()) << high.transpose();
    EXPECT_EQ(count, 8 * 8 * 8);
  }
}

TEST(Truth, AFlatWorldHasOneLayer)
{
  for (const TrueCell& cell : truthOf(makeWorld("flatland", 1), {0.05, 2})) ASSERT_EQ(cell.index.z, 0);
}

TEST(Truth, IsSorted)
{
  const auto cells = truthOf(makeWorld("structured", 1), {0.2, 2});
  for (size_t i = 1; i < cells.size(); ++i)
  {
    const CellIndex& a = cells[i - 1].index;
    const CellIndex& b = cells[i].index;
    ASSERT_LT(std::tie(a.z, a.y, a.x), std::tie(b.z, b.y, b.x));
  }
}

// Rays from open space pass only free or unlabelled cells, and the cell just behind their end is never free.
TEST(Truth, AgreesWithRaysCastInTheWorld)
{
  for (const char* name : {"structured", "unstructured", "corridor", "pier"})
  {
    SCOPED_TRACE(name);
    const World world = makeWorld(name, 21);
    const auto labels = labelsOf(truthOf(world, {0.1, 2}));
    const auto labelAt = [&](const Vector3d& point)
    {
      const CellIndex cell = *cellAt(point, 0.1);
      const auto found = labels.find({cell.x, cell.y, cell.z});
      return found == labels.end() ? -1 : found->second ? 1 : 0;
    };
    Random random(8);
    const auto poses = makeTrajectory(world, makeSensor("lidar16"), Motion::Driving, 40);
    int ended = 0;
    for (const Pose& pose : poses)
      for (int i = 0; i < 60; ++i)
      {
        const Vector3d direction = random.normal3().normalized();
        const auto hit = world.scene.firstHit(pose.position_map, direction, 12);
        const double end = hit ? hit->range_m : 12;
        for (double range = 0; range < end; range += 0.01)
          ASSERT_NE(labelAt(pose.position_map + range * direction), 1);
        if (!hit) continue;
        ++ended;
        ASSERT_NE(labelAt(pose.position_map + (end + 1e-6) * direction), 0);
      }
    EXPECT_GT(ended, 1000);
  }
}

TEST(Truth, RefusesIllegalOptionsAndStopsWhenAsked)
{
  const World world = makeWorld("structured", 1);
  for (const double resolution : {0.0, -0.1, std::nan(""), 1e-6, HUGE_VAL})
    EXPECT_THROW((void)truthOf(world, {resolution, 2}), std::invalid_argument) << resolution;
  EXPECT_THROW((void)truthOf(world, {0.1, 0}), std::invalid_argument);
  EXPECT_TRUE(truthOf(world, {0.1, 2}, [] { return true; }).empty());
}
}  // namespace
}  // namespace lamap::sim
