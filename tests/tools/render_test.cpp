#include <gtest/gtest.h>
#include <lamap_tools/files/usage_error.h>
#include <lamap_tools/pictures/render_map.h>

#include <cmath>
#include <map>
#include <tuple>

#include "support/temporary_folder.h"
#include "tools/hand_made_cells.h"

namespace
{
using namespace lamap;
using namespace lamap::tools;
using mrpt::img::CImage;
using mrpt::img::TColor;
using test::HandMadeCells;

/// Number of pixels of each colour in a picture.
using Colors = std::map<std::tuple<int, int, int>, size_t>;

Colors colorsOf(const CImage& picture)
{
  Colors colors;
  for (unsigned row = 0; row < picture.getHeight(); ++row)
  {
    const uint8_t* pixel = picture.ptrLine<uint8_t>(row);
    for (size_t column = 0; column < picture.getWidth(); ++column, pixel += 3)
      ++colors[{pixel[2], pixel[1], pixel[0]}];
  }
  return colors;
}

/// A room of ten by six cells: a free floor, walls eight cells high.
HandMadeCells room()
{
  HandMadeCells map(0.5);
  for (int x = 0; x < 10; ++x)
    for (int y = 0; y < 6; ++y)
      for (int z = 0; z < 8; ++z)
      {
        const bool wall = x == 0 || y == 0 || x == 9;
        map.put({x, y, z}, wall ? 0.9 : 0.1, wall ? CellState::Occupied : CellState::Free,
                wall ? 0.01 : 0.04);
      }
  return map;
}

RenderOptions sized(View view)
{
  RenderOptions options;
  options.view = view;
  options.width = 640;
  options.height = 400;
  return options;
}

TEST(Render, HasTheSizeAskedForAndIsTheSameEachTime)
{
  for (const View view : {View::Top, View::Slice, View::Perspective})
  {
    const CImage first = drawMap(room(), sized(view));
    EXPECT_EQ(first.getWidth(), 640U);
    EXPECT_EQ(first.getHeight(), 400U);
    EXPECT_EQ(colorsOf(first), colorsOf(drawMap(room(), sized(view))));
  }
}

// 27 wall cells and 33 others of ten by six: the shares of the two greys in the plot are known.
TEST(Render, SliceShowsProbabilityAsGrey)
{
  RenderOptions options = sized(View::Slice);
  options.z_m = 1.2;
  const Colors colors = colorsOf(drawMap(room(), options));
  const auto grey = [&](int level)
  {
    const auto found = colors.find({level, level, level});
    return found == colors.end() ? 0.0 : static_cast<double>(found->second);
  };
  const double walls = grey(26);  // 255 · 0.1, rounded
  const double floor = grey(229);
  ASSERT_GT(walls, 1000);
  EXPECT_NEAR(walls / floor, 20.0 / 40.0, 0.05);
}

TEST(Render, UnobservedCellsDifferFromUnknownOnes)
{
  HandMadeCells map(0.5);
  map.put({0, 0, 0}, 0.9, CellState::Occupied)
      .put({3, 3, 0}, 0.9, CellState::Occupied)
      .put({1, 1, 0}, 0.5, CellState::Unknown);
  const Colors colors = colorsOf(drawMap(map, sized(View::Slice)));
  EXPECT_GT(colors.at({222, 230, 240}), 1000U);
  EXPECT_GT(colors.at({128, 128, 128}), 1000U);
}

TEST(Render, HeightLimitsTakeTheCeilingOff)
{
  HandMadeCells map = room();
  for (int x = 1; x < 9; ++x)
    for (int y = 1; y < 6; ++y) map.put({x, y, 8}, 0.9, CellState::Occupied);
  RenderOptions options = sized(View::Top);
  const auto white = [](const CImage& picture) { return colorsOf(picture).at({255, 255, 255}); };
  const size_t whole = white(drawMap(map, options));
  options.zMax_m = 4;
  EXPECT_GT(white(drawMap(map, options)), whole + 10000) << "the free floor is seen";
}

TEST(Render, StrayCellsDoNotShrinkTheMap)
{
  HandMadeCells map = room();
  map.put({100'000, 0, 0}, 0.9, CellState::Occupied);
  const auto background = [](const HandMadeCells& cells) {
    return colorsOf(drawMap(cells, sized(View::Perspective))).at({255, 255, 255});
  };
  EXPECT_LT(static_cast<double>(background(map)), 1.05 * static_cast<double>(background(room())));
}

TEST(Render, PerspectiveShowsTheSidesOfCells)
{
  const Colors colors = colorsOf(drawMap(room(), sized(View::Perspective)));
  size_t drawn = 0;
  for (const auto& [color, count] : colors)
    if (color != std::tuple{255, 255, 255}) drawn += count;
  EXPECT_GT(drawn, 30'000U);
  EXPECT_GT(colors.size(), 100U) << "heights, sides and shade give many colours";
}

TEST(Render, FreeSpaceIsSeenOnlyWhenAskedFor)
{
  RenderOptions options = sized(View::Perspective);
  const Colors without = colorsOf(drawMap(room(), options));
  options.showFree = true;
  EXPECT_NE(colorsOf(drawMap(room(), options)), without);
}

TEST(Render, MapsAThousandKilometresAwayLookTheSame)
{
  HandMadeCells near(0.5);
  HandMadeCells far(0.5);
  for (int x = 0; x < 10; ++x)
    for (int z = 0; z < 5; ++z)
    {
      near.put({x, 0, z}, 0.9, CellState::Occupied);
      far.put({x + 2'000'000, -2'000'000, z}, 0.9, CellState::Occupied);
    }
  const auto saturated = [](const HandMadeCells& map)
  {
    double count = 0;
    for (const auto& [color, pixels] : colorsOf(drawMap(map, sized(View::Perspective))))
    {
      const auto [r, g, b] = color;
      if (std::max({r, g, b}) - std::min({r, g, b}) > 60) count += static_cast<double>(pixels);
    }
    return count;
  };
  EXPECT_GT(saturated(near), 1000);
  // Longer numbers along the grid cover a few cells.
  EXPECT_NEAR(saturated(near), saturated(far), 0.01 * saturated(near));
}

TEST(Render, ABoxFramesDifferentMapsAlike)
{
  HandMadeCells more = room();
  for (int z = 0; z < 20; ++z) more.put({40, 30, z}, 0.9, CellState::Occupied);
  RenderOptions options = sized(View::Top);
  EXPECT_NE(colorsOf(drawMap(room(), options)), colorsOf(drawMap(more, options)));
  options.box_map.emplace();
  options.box_map->min = {-0.5, -0.5, 0};
  options.box_map->max = {5.5, 3.5, 4};
  EXPECT_EQ(colorsOf(drawMap(room(), options)), colorsOf(drawMap(more, options)));
  // Cells outside it are omitted.
  HandMadeCells outside = room();
  for (int x = 60; x < 64; ++x) outside.put({x, 10, 1}, 0.9, CellState::Occupied);
  for (int z = 45; z < 50; ++z) outside.put({20, 20, z}, 0.9, CellState::Occupied);
  for (const View view : {View::Top, View::Slice, View::Perspective})
  {
    RenderOptions boxed = sized(view);
    boxed.box_map = options.box_map;
    EXPECT_EQ(colorsOf(drawMap(room(), boxed)), colorsOf(drawMap(outside, boxed))) << static_cast<int>(view);
    boxed.box_map->min = {90, 90, 0};
    boxed.box_map->max = {91, 91, 4};
    EXPECT_THROW((void)drawMap(room(), boxed), std::runtime_error) << static_cast<int>(view);
  }
  RenderOptions slice = sized(View::Slice);
  slice.box_map = options.box_map;
  slice.z_m = 4.5;
  EXPECT_THROW((void)drawMap(room(), slice), UsageError);
  // It may extend beyond the map, and its heights set the colours.
  options.box_map->max.z = 8;
  EXPECT_NE(colorsOf(drawMap(more, options)), colorsOf(drawMap(room(), sized(View::Top))));
  for (const double bad : {-0.5, -1.0, std::nan(""), 1e9})
  {
    options.box_map->max.x = bad;
    EXPECT_THROW((void)drawMap(room(), options), UsageError) << bad;
  }
}

TEST(Render, SaysWhatIsMissingWhereThereIsNothingToDraw)
{
  const auto refusal = [](const CellMap& map, const RenderOptions& options) -> std::string
  {
    try
    {
      (void)drawMap(map, options);
    }
    catch (const std::runtime_error& error)
    {
      return error.what();
    }
    return "drawn";
  };
  for (const View view : {View::Top, View::Slice, View::Perspective})
    EXPECT_EQ(refusal(HandMadeCells(), sized(view)), "the map is empty; there is nothing to draw");
  RenderOptions options = sized(View::Perspective);
  options.zMin_m = 100;
  EXPECT_EQ(refusal(room(), options),
            "the map has no occupied cell at the heights asked for; there is nothing to draw");
  options.view = View::Top;
  EXPECT_EQ(
      refusal(room(), options),
      "the map has no cell at the heights asked for (from above, z 100 .. highest m); there is nothing to "
      "draw");
}

TEST(Render, RefusesWhatItCannotDraw)
{
  const test::TemporaryFolder folder;
  RenderOptions options = sized(View::Slice);
  options.colorBy = ColorBy::Height;
  EXPECT_THROW((void)drawMap(room(), options), UsageError);
  options = {};
  options.zoom = 0;
  EXPECT_THROW((void)drawMap(room(), options), UsageError);
  options = {};
  options.zMin_m = 2;
  options.zMax_m = 1;
  EXPECT_THROW((void)drawMap(room(), options), UsageError);
  options = {};
  options.width = 20;
  EXPECT_THROW((void)drawMap(room(), options), UsageError);
  options = {};
  options.colorBy = ColorBy::Variance;
  HandMadeCells noVariance(0.5);
  noVariance.put({0, 0, 0}, 0.9, CellState::Occupied);
  EXPECT_THROW((void)drawMap(noVariance, options), std::runtime_error);
  EXPECT_THROW(renderMap(room(), folder / "a.jpg"), UsageError);
  EXPECT_EQ(folder.size(), 0U);
}

TEST(Render, WritesAPngThatReadsBack)
{
  const test::TemporaryFolder folder;
  renderMap(room(), folder / "a.png", sized(View::Top));
  CImage back;
  ASSERT_TRUE(back.loadFromFile(folder / "a.png"));
  EXPECT_EQ(back.getWidth(), 640U);
  EXPECT_EQ(folder.size(), 1U);
}

TEST(ParseSize, TakesTwoNumbersOnly)
{
  RenderOptions options;
  parseSize("800x600", options);
  EXPECT_EQ(options.width, 800);
  EXPECT_EQ(options.height, 600);
  for (const char* text : {"", "800", "800x", "x600", "800x600x3", "800,600", "ax b"})
    EXPECT_THROW(parseSize(text, options), UsageError) << text;
}
}  // namespace
