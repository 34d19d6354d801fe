#include <lamap_tools/pictures/picture_frame.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace lamap::tools
{
namespace
{
using mrpt::img::TColor;

const TColor kInk(40, 40, 40);
const TColor kFrame(120, 120, 120);
}  // namespace

double roundStep(double atLeast)
{
  const double decade = std::pow(10.0, std::floor(std::log10(atLeast)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * decade >= atLeast * (1 - 1e-9)) return factor * decade;
  return 10 * decade;
}

std::vector<double> multiplesWithin(double from, double to, double step)
{
  std::vector<double> multiples;
  const double slack = 1e-6;
  for (double i = std::ceil(from / step - slack); i * step <= to + slack * step; ++i)
    multiples.push_back(i * step);
  return multiples;
}

std::string roundText(double number)
{
  std::ostringstream text;
  text.precision(10);
  text << (std::abs(number) < 1e-12 ? 0.0 : number);
  return text.str();
}

void drawText(mrpt::img::CImage& picture, int x, int y, const std::string& text, Anchor anchor)
{
  const int width = kTextWidth * static_cast<int>(text.size());
  if (anchor == Anchor::Middle) x -= width / 2;
  if (anchor == Anchor::Right) x -= width;
  picture.selectTextFont("9x15");
  picture.textOut(x, y, text, kInk);
}

void drawTitle(mrpt::img::CImage& picture, int left, int top, const std::string& text)
{
  picture.selectTextFont("9x15B");
  picture.textOut(left, top, text, kInk);
}

void drawAxes(mrpt::img::CImage& picture, const PlotArea& plot)
{
  constexpr int kPixelsBetweenTicks = 90;
  constexpr int kTick = 6;
  const int right = plot.left + plot.width;
  const int bottom = plot.top + plot.height;
  const double metresPerPixel = (plot.xMax_m - plot.xMin_m) / plot.width;
  const double step = roundStep(kPixelsBetweenTicks * metresPerPixel);
  picture.rectangle(plot.left - 1, plot.top - 1, right, bottom, kFrame);

  for (const double x_m : multiplesWithin(plot.xMin_m, plot.xMax_m, step))
  {
    const int x = plot.left + static_cast<int>(std::lround((x_m - plot.xMin_m) / metresPerPixel));
    picture.line(x, bottom, x, bottom + kTick, kFrame);
    drawText(picture, x, bottom + kTick + 4, roundText(x_m), Anchor::Middle);
  }
  for (const double y_m : multiplesWithin(plot.yMin_m, plot.yMax_m, step))
  {
    const int y = bottom - static_cast<int>(std::lround((y_m - plot.yMin_m) / metresPerPixel));
    picture.line(plot.left - 1 - kTick, y, plot.left - 1, y, kFrame);
    drawText(picture, plot.left - kTick - 5, y - kTextHeight / 2, roundText(y_m), Anchor::Right);
  }
  drawText(picture, (plot.left + right) / 2, bottom + kTick + 8 + kTextHeight, "x [m]", Anchor::Middle);
  drawText(picture, plot.left - 1, plot.top - 6 - kTextHeight, "y [m]", Anchor::Right);
}

namespace
{
void drawColorBar(mrpt::img::CImage& picture, int left, int top, int height, const Legend& legend)
{
  constexpr int kBarWidth = 22;
  for (int row = 0; row < height; ++row)
  {
    const TColor color = paletteColor(legend.palette, legend.fractionAtTo * (1.0 - (row + 0.5) / height));
    picture.line(left, top + row, left + kBarWidth, top + row, color);
  }
  picture.rectangle(left - 1, top - 1, left + kBarWidth + 1, top + height, kFrame);

  constexpr int kPixelsBetweenTicks = 45;
  const double span = legend.to - legend.from;
  for (const double tick : multiplesWithin(
           legend.from, legend.to, roundStep(span * std::min(1.0, kPixelsBetweenTicks / double(height)))))
  {
    const int y = top + height - static_cast<int>(std::lround((tick - legend.from) / span * height));
    picture.line(left + kBarWidth + 1, y, left + kBarWidth + 6, y, kFrame);
    drawText(picture, left + kBarWidth + 11, y - kTextHeight / 2, roundText(tick));
  }
}
}  // namespace

void drawLegend(mrpt::img::CImage& picture, int left, int top, int height, const Legend& legend)
{
  constexpr int kSwatchHeight = 24;
  constexpr int kMaxBar = 400;
  const int swatches = kSwatchHeight * static_cast<int>(legend.swatches.size());
  int y = top;
  if (legend.to > legend.from)
  {
    const int bar = std::clamp(height - swatches - 3 * kTextHeight, 30, kMaxBar);
    drawText(picture, left, y, legend.title);
    y += kTextHeight + 10;
    drawColorBar(picture, left, y, bar, legend);
    y += bar + 20;
  }
  for (const Swatch& swatch : legend.swatches)
  {
    picture.filledRectangle(left, y, left + 15, y + 15, swatch.color);
    picture.rectangle(left, y, left + 15, y + 15, kFrame);
    drawText(picture, left + 24, y + 1, swatch.text);
    y += kSwatchHeight;
  }
}

}  // namespace lamap::tools
