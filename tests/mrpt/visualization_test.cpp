#include <gtest/gtest.h>
#include <lamap_mrpt/maps/CBGKMap.h>
#include <mrpt/opengl/CSetOfObjects.h>

#include <cmath>
#include <set>

#include <support/small_maps.h>

namespace
{
using lamap::CBGKMap;
using lamap::Option;
using namespace lamap::test;
using mrpt::opengl::COctoMapVoxels;
using mrpt::opengl::VOXEL_SET_FREESPACE;
using mrpt::opengl::VOXEL_SET_OCCUPIED;

/// A solid block of 4 × 4 × 4 occupied cells with different evidence, and a free cell above it.
CBGKMap solid()
{
  CBGKMap map;
  for (int x = 0; x < 4; ++x)
    for (int y = 0; y < 4; ++y)
      for (int z = 0; z < 4; ++z)
        for (int n = 0; n <= x; ++n) map.updateVoxel(0.05 + 0.1 * x, 0.05 + 0.1 * y, 0.05 + 0.1 * z, true);
  map.updateVoxel(0.05, 0.05, 0.95, false);
  return map;
}

COctoMapVoxels::Ptr viewOf(const CBGKMap& map)
{
  mrpt::opengl::CSetOfObjects scene;
  map.getVisualizationInto(scene);
  return scene.getByClass<COctoMapVoxels>();
}

TEST(Visualization, EachVisibleOccupiedCellIsACube)
{
  const auto voxels = viewOf(solid());
  ASSERT_TRUE(voxels);
  ASSERT_EQ(voxels->getVoxelSetCount(), 2u);
  EXPECT_EQ(voxels->getVoxelCount(VOXEL_SET_OCCUPIED), 64u - 8u) << "the eight in the middle cannot be seen";
  EXPECT_EQ(voxels->getVoxelCount(VOXEL_SET_FREESPACE), 0u);
  EXPECT_EQ(voxels->getGridCubeCount(), 0u);
  std::set<std::array<int, 3>> cells;
  for (size_t i = 0; i < voxels->getVoxelCount(VOXEL_SET_OCCUPIED); ++i)
  {
    const auto& voxel = voxels->getVoxel(VOXEL_SET_OCCUPIED, i);
    EXPECT_FLOAT_EQ(static_cast<float>(voxel.side_length), 0.1f);
    EXPECT_EQ(voxel.color.A, 255);
    cells.insert({static_cast<int>(std::floor(voxel.coords.x * 10)),
                  static_cast<int>(std::floor(voxel.coords.y * 10)),
                  static_cast<int>(std::floor(voxel.coords.z * 10))});
  }
  EXPECT_EQ(cells.size(), 56u);
}

// In UTM coordinates, floats are 0.5 m apart: cells of 0.1 m would fall together.
TEST(Visualization, CubesFarAwayAreApartAndRelativeToTheirPose)
{
  struct Place
  {
    mrpt::math::TPoint3D first;
    bool isFar;
  };
  for (const Place& place :
       {Place{{448123.45, 5412345.65, 310.25}, true}, Place{{-448123.45, 0.05, 0.05}, true},
        Place{{0.05, 0.05, -200000.05}, true}, Place{{1000.05, -2000.05, 0.05}, false}})
  {
    SCOPED_TRACE(place.first.asString());
    CBGKMap map;
    constexpr int kCells = 7;
    for (int i = 0; i < kCells; ++i)
      map.updateVoxel(place.first.x + 0.1 * i, place.first.y + 0.2 * i, place.first.z, true);
    map.renderingOptions.generateGridLines = true;
    const auto voxels = viewOf(map);
    ASSERT_EQ(voxels->getVoxelCount(VOXEL_SET_OCCUPIED), static_cast<size_t>(kCells));
    const mrpt::poses::CPose3D pose(voxels->getPose());
    EXPECT_EQ(pose.norm() != 0, place.isFar);
    std::set<double> found;
    for (size_t i = 0; i < kCells; ++i)
    {
      const auto& cube = voxels->getVoxel(VOXEL_SET_OCCUPIED, i).coords;
      const mrpt::math::TPoint3D centre(pose.x() + cube.x, pose.y() + cube.y, pose.z() + cube.z);
      const double step = std::round((centre.x - place.first.x) / 0.1);
      EXPECT_NEAR(centre.x, place.first.x + 0.1 * step, 1e-3);
      EXPECT_NEAR(centre.y, place.first.y + 0.2 * step, 1e-3);
      EXPECT_NEAR(centre.z, place.first.z, 1e-3);
      found.insert(step);
    }
    EXPECT_EQ(found.size(), static_cast<size_t>(kCells));
    ASSERT_EQ(voxels->getGridCubeCount(), 1U);
    const auto size = voxels->getGridCube(0).max - voxels->getGridCube(0).min;
    EXPECT_NEAR(size.x, 0.7, 1e-3);
    EXPECT_NEAR(size.y, 1.3, 1e-3);
  }
}

TEST(Visualization, HeightGoesFromBlueToRed)
{
  const auto voxels = viewOf(solid());
  for (size_t i = 0; i < voxels->getVoxelCount(VOXEL_SET_OCCUPIED); ++i)
  {
    const auto& voxel = voxels->getVoxel(VOXEL_SET_OCCUPIED, i);
    if (voxel.coords.z < 0.1f)
    {
      EXPECT_GT(voxel.color.B, voxel.color.R);
    }
    if (voxel.coords.z > 0.3f)
    {
      EXPECT_GT(voxel.color.R, voxel.color.B);
    }
  }
}

TEST(Visualization, NothingIsShownWhereTheMapIsNotToBe)
{
  CBGKMap map = solid();
  map.genericMapParams.enableSaveAs3DObject = false;
  mrpt::opengl::CSetOfObjects scene;
  map.getVisualizationInto(scene);
  EXPECT_EQ(scene.size(), 0u);
}

TEST(Visualization, AnEmptyMapIsAnEmptyView)
{
  const auto voxels = viewOf(CBGKMap());
  ASSERT_TRUE(voxels);
  EXPECT_EQ(voxels->getVoxelCount(VOXEL_SET_OCCUPIED), 0u);
}

TEST(Visualization, ATurnedOffSetIsMadeButHidden)
{
  CBGKMap map = solid();
  map.renderingOptions.visibleOccupiedVoxels = false;
  const auto voxels = viewOf(map);
  EXPECT_EQ(voxels->getVoxelCount(VOXEL_SET_OCCUPIED), 56u);
  EXPECT_FALSE(voxels->areVoxelsVisible(VOXEL_SET_OCCUPIED));
}

/// Everything that a viewer receives.
std::string looksOf(const CBGKMap& map)
{
  const auto voxels = viewOf(map);
  std::string looks =
      std::to_string(voxels->getGridCubeCount()) + (voxels->areGridLinesVisible() ? "lines" : "");
  for (const size_t set : {size_t{VOXEL_SET_OCCUPIED}, size_t{VOXEL_SET_FREESPACE}})
  {
    looks += voxels->areVoxelsVisible(static_cast<unsigned>(set)) ? " shown" : " hidden";
    std::multiset<std::string> cubes;
    for (size_t i = 0; i < voxels->getVoxelCount(set); ++i)
    {
      const auto& voxel = voxels->getVoxel(set, i);
      cubes.insert(voxel.coords.asString() + " " + std::to_string(voxel.color.R) + " " +
                   std::to_string(voxel.color.G) + " " + std::to_string(voxel.color.B) + " " +
                   std::to_string(voxel.color.A));
    }
    for (const std::string& cube : cubes) looks += "\n" + cube;
  }
  return looks;
}

TEST(Visualization, EveryOptionTakesEffect)
{
  CBGKMap map = solid();
  map.renderingOptions.generateFreeVoxels = true;
  int number = 0;
  for (const Option& option : map.renderingOptions.optionTable().options())
  {
    CBGKMap changed(map);
    setToAnother(option, changed.renderingOptions, number++);
    EXPECT_NE(looksOf(changed), looksOf(map)) << option.key;
  }
  CBGKMap byProbability(map);
  byProbability.renderingOptions.colourBy = CBGKMap::ColourBy::Probability;
  CBGKMap byVariance(map);
  byVariance.renderingOptions.colourBy = CBGKMap::ColourBy::Variance;
  EXPECT_NE(looksOf(byProbability), looksOf(byVariance));
}

}  // namespace
