#include <gtest/gtest.h>
#include <lamap_mrpt/maps/CBGKMap.h>
#include <mrpt/opengl/CSetOfObjects.h>

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
