// A ray visits the cells that single steps visit, whatever is skipped between them.
#include <gtest/gtest.h>
#include <lamap_mrpt/learned_map/cell_walk.h>
#include <lamap_mrpt/maps/CBGKMap.h>
#include <lamap_mrpt/maps/CGPMap.h>
#include <lamap_mrpt/maps/COverlappingHilbertMap.h>
#include <support/seeded_scans.h>
#include <support/seeds.h>

#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace lamap::test
{
namespace
{
/// All cells from the origin on that are entered by tLast, step by step.
std::vector<CellIndex> everyCell(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                 double resolution, double tLast)
{
  const Eigen::Vector3d from = origin / resolution;
  const Eigen::Vector3d along = direction / resolution;
  std::vector<CellIndex> cells{*cellAt(origin, resolution)};
  while (true)
  {
    const CellIndex& cell = cells.back();
    const std::array<int, 3> index{cell.x, cell.y, cell.z};
    double nextT = std::numeric_limits<double>::infinity();
    size_t nextAxis = 0;
    for (size_t axis = 0; axis < 3; ++axis)
    {
      const int i = static_cast<int>(axis);
      if (along[i] == 0) continue;
      const double crossing = (index[axis] + (along[i] > 0 ? 1 : 0) - from[i]) / along[i];
      if (crossing >= nextT) continue;
      nextT = crossing;
      nextAxis = axis;
    }
    if (!(nextT <= tLast)) return cells;
    std::array<int, 3> next = index;
    next[nextAxis] += along[static_cast<int>(nextAxis)] > 0 ? 1 : -1;
    cells.push_back({next[0], next[1], next[2]});
  }
}

struct RandomRay
{
  explicit RandomRay(Random& random)
      : origin(random.inCube(3)), direction(random.inCube(1)), range(random.uniform(0, 8))
  {
    // Along axes and diagonals, from faces, edges and corners of cells: crossings coincide.
    if (random.chance(0.4)) origin = (origin * 8).array().round() / 8;
    if (random.chance(0.4))
      for (int axis = 0; axis < 3; ++axis) direction[axis] = random.integer(-1, 1);
    if (random.chance(0.1)) direction[random.integer(0, 2)] = random.pick<double>({0, -0.0, 1e-300, -1e-20});
    if (!(direction.norm() > 0.01)) direction = {0.3, -1, 0};
    direction.normalize();
  }
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;
  double range;
};

bool isIn(const CellIndex& cell, const CellIndex& other, int n)
{
  return cell.x >> n == other.x >> n && cell.y >> n == other.y >> n && cell.z >> n == other.z >> n;
}

TEST(CellWalk, LeavesCubesWhereSingleStepsDo)
{
  size_t skipped = 0;
  for (unsigned seed = 1; seed <= seeds(2000); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    const double resolution = random.pick<double>({0.125, 0.1});
    const RandomRay ray(random);
    const auto emptyAround = [seed](const CellIndex& cell)
    {
      for (const int n : {5, 3, 1})
        if (((cell.x >> n) * 7 + (cell.y >> n) * 13 + (cell.z >> n) * 5 + static_cast<int>(seed) + n) % 3 ==
            0)
          return n;
      return 0;
    };
    const std::vector<CellIndex> all = everyCell(ray.origin, ray.direction, resolution, ray.range);
    std::vector<CellIndex> expected;
    for (size_t i = 0; i < all.size();)
    {
      expected.push_back(all[i]);
      const int n = emptyAround(all[i]);
      size_t next = i + 1;
      while (n > 0 && next < all.size() && isIn(all[i], all[next], n)) ++next;
      skipped += next - i - 1;
      if (next == all.size() && next > i + 1) expected.push_back(all.back());
      i = next;
    }
    std::vector<CellIndex> visited;
    const auto visit = [&](const CellIndex& cell)
    {
      visited.push_back(cell);
      return true;
    };
    walkCells(ray.origin, ray.direction, resolution, 0, ray.range, visit, emptyAround);
    ASSERT_EQ(visited, expected);
    visited.clear();
    walkCells(ray.origin, ray.direction, resolution, 0, ray.range, visit);
    ASSERT_EQ(visited, all);
  }
  EXPECT_GT(skipped, 1000U);
}

template <typename Map>
class RayCasting : public ::testing::Test
{
};
using GridMaps = ::testing::Types<CBGKMap, CGPMap, COverlappingHilbertMap>;
TYPED_TEST_SUITE(RayCasting, GridMaps);

TYPED_TEST(RayCasting, MeetsTheCellThatSingleStepsMeet)
{
  size_t met = 0;
  size_t notMet = 0;
  for (unsigned seed = 1; seed <= seeds(12); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    typename TypeParam::TCreationOptions creation;
    creation.resolution = random.pick<double>({0.125, 0.1});
    creation.blockDepth = random.integer(2, 5);
    creation.planar = random.chance(0.3);
    TypeParam map(creation);
    // Clusters of free cells and single occupied ones, with nothing between most of them.
    for (int i = 0; i < 40; ++i)
    {
      const Eigen::Vector3d centre = random.inCube(3);
      for (int j = 0; j < 20; ++j)
      {
        const Eigen::Vector3d place = centre + random.inCube(0.3);
        map.updateVoxel(place.x(), place.y(), place.z(), random.chance(0.1));
      }
    }
    for (int i = 0; i < 200; ++i)
    {
      SCOPED_TRACE(i);
      RandomRay ray(random);
      if (creation.planar)
      {
        ray.direction.z() = 0;
        if (!(ray.direction.norm() > 0.01)) ray.direction = {1, 0, 0};
        ray.direction.normalize();
        ray.origin.z() = (*map.planarLayer() + 0.5) * map.resolution();
      }
      const bool ignoreUnknown = random.chance(0.6);
      mrpt::math::TPoint3D end(7, 7, 7);
      const bool isMet = map.castRay({ray.origin.x(), ray.origin.y(), ray.origin.z()},
                                     {ray.direction.x(), ray.direction.y(), ray.direction.z()}, end,
                                     ignoreUnknown, ray.range);
      // The direction as castRay() has it.
      const Eigen::Vector3d unit = ray.direction.normalized();
      bool expected = false;
      CellIndex last;
      for (const CellIndex& cell : everyCell(ray.origin, unit, map.resolution(), ray.range))
      {
        last = cell;
        const auto estimate = map.estimateCell(cell);
        expected = estimate && estimate->state == CellState::Occupied;
        if (expected || (!estimate && !ignoreUnknown)) break;
      }
      ASSERT_EQ(isMet, expected);
      if (ignoreUnknown && !isMet) continue;  // the walk ends with the box of what is known
      const Eigen::Vector3d centre = cellCentre(last, map.resolution());
      EXPECT_EQ(end, mrpt::math::TPoint3D(centre.x(), centre.y(), centre.z()));
      met += isMet;
      notMet += !isMet;
    }
  }
  // Worlds differ: a few of them say nothing of the rest.
  const bool areAll = seeds(12) >= 12;
  EXPECT_GT(met, areAll ? 100U : 0U);
  EXPECT_GT(notMet, areAll ? 100U : 0U);
}
}  // namespace
}  // namespace lamap::test
