#pragma once

#include <lamap_tools/pictures/palette.h>
#include <mrpt/img/CImage.h>

#include <string>
#include <vector>

namespace lamap::tools
{
constexpr int kTextWidth = 9;  // of the fonts used here [pixels per character]
constexpr int kTextHeight = 15;

/// A part of the map frame [m] and its position in a picture [pixels]; y points up in the map, down in the
/// picture.
struct PlotArea
{
  int left = 0;
  int top = 0;
  int width = 0;
  int height = 0;
  double xMin_m = 0;
  double xMax_m = 0;
  double yMin_m = 0;
  double yMax_m = 0;
};

struct Swatch
{
  mrpt::img::TColor color;
  std::string text;
};

/// A bar of colours with its scale, and single colours below it.
struct Legend
{
  std::string title;
  Palette palette = Palette::Height;
  double from = 0;
  double to = 1;
  double fractionAtTo = 1;  ///< of the palette
  std::vector<Swatch> swatches;
};

/// The smallest of 1, 2 or 5 times a power of ten that is at least this length.
[[nodiscard]] double roundStep(double atLeast);

/// The multiples of the step within the range, both ends included.
[[nodiscard]] std::vector<double> multiplesWithin(double from, double to, double step);

/// At most ten digits, which hides the binary rounding of e.g. 0.1.
[[nodiscard]] std::string roundText(double number);

enum class Anchor
{
  Left,
  Middle,
  Right
};
void drawText(mrpt::img::CImage& picture, int x, int y, const std::string& text,
              Anchor anchor = Anchor::Left);

/// A frame around the plot, with ticks and metres on its left and below it.
void drawAxes(mrpt::img::CImage& picture, const PlotArea& plot);

/// @param left, top, height  of the whole legend [pixels]; it is about kLegendWidth wide.
void drawLegend(mrpt::img::CImage& picture, int left, int top, int height, const Legend& legend);
constexpr int kLegendWidth = 150;

/// A bold line of text at the top left.
void drawTitle(mrpt::img::CImage& picture, int left, int top, const std::string& text);

}  // namespace lamap::tools
