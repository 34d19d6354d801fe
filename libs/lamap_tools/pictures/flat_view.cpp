#include <lamap_tools/pictures/flat_view.h>

#include <lamap_tools/cells/cell_table.h>
#include <lamap_tools/files/usage_error.h>
#include <lamap_tools/pictures/occupied_frame.h>
#include <lamap_tools/pictures/picture_frame.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <sstream>
#include <stdexcept>
#include <vector>

namespace lamap::tools
{
namespace
{
using mrpt::img::CImage;
using mrpt::img::TColor;

const TColor kUnobserved(222, 230, 240);
const TColor kUnsure(176, 176, 176);
const TColor kFree(255, 255, 255);
constexpr double kHighest = 0.78;  // of the palette: its bright end would vanish on white

/// The content of one square of the picture: one cell of its column.
struct Square
{
  float prob = -1;  ///< below 0: not observed
  float variance = 0;
  int32_t z = std::numeric_limits<int32_t>::min();
  CellState state = CellState::Unknown;
  bool anyFree = false;  ///< a cell of the column is free

  [[nodiscard]] bool observed() const { return prob >= 0; }
};

/// The highest occupied cell or, if there is none, the most probable one.
bool showsBetter(const Square& a, const Square& b)
{
  const bool aOccupied = a.state == CellState::Occupied;
  const bool bOccupied = b.observed() && b.state == CellState::Occupied;
  if (aOccupied != bOccupied) return aOccupied;
  if (aOccupied) return a.z > b.z;
  return a.prob > b.prob;
}

/// The map seen from above: squares of one or more cells, row by row from the lowest y.
struct Squares
{
  CellExtent extent;       ///< of what is shown
  int cellsPerSquare = 1;  ///< along each axis
  int width = 0;
  int height = 0;
  std::vector<Square> squares;
  int32_t lowestOccupied = std::numeric_limits<int32_t>::max();
  int32_t highestOccupied = std::numeric_limits<int32_t>::min();
  float greatestVariance = 0;

  [[nodiscard]] const Square* at(int x, int y) const
  {
    if (x < 0 || y < 0 || x >= width || y >= height) return nullptr;
    return &squares[static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)];
  }
};

/// The layers of cells that a picture shows.
struct Layers
{
  int32_t lowest = std::numeric_limits<int32_t>::min();
  int32_t highest = std::numeric_limits<int32_t>::max();

  [[nodiscard]] bool has(const CellIndex& cell) const { return cell.z >= lowest && cell.z <= highest; }
};

int32_t layerWithMostOccupied(const CellMap& map, const std::optional<CellExtent>& box)
{
  std::map<int32_t, size_t> occupied;
  map.visitCells(
      [&](const CellIndex& cell, const CellEstimate& estimate)
      {
        if (!box || inside(cell, *box)) occupied[cell.z] += estimate.state == CellState::Occupied ? 1 : 0;
      });
  if (occupied.empty()) failNothingToDraw(map, "cell in the box asked for");
  return std::max_element(occupied.begin(), occupied.end(),
                          [](auto& a, auto& b) { return a.second < b.second; })
      ->first;
}

/// A layer's number, clamped to what cells can have.
int32_t layerNumber(double number)
{
  return static_cast<int32_t>(std::clamp(number, -2147483647.0, 2147483646.0));
}

Layers layersOf(const CellMap& map, const RenderOptions& options)
{
  Layers layers;
  const double r = map.resolution();
  const std::optional<CellExtent> box = cellsOfBox(options, r);
  if (box)
  {
    layers.lowest = box->first.z;
    layers.highest = box->last.z;
  }
  if (options.view == View::Slice)
  {
    const int32_t layer =
        options.z_m ? layerNumber(std::floor(*options.z_m / r)) : layerWithMostOccupied(map, box);
    if (layer < layers.lowest || layer > layers.highest)
      throw UsageError("a slice at z = " + roundText(*options.z_m) + " m is outside of the box");
    layers.lowest = layers.highest = layer;
    return layers;
  }
  if (options.zMin_m)
    layers.lowest = std::max(layers.lowest, layerNumber(std::ceil(*options.zMin_m / r - 0.5)));
  if (options.zMax_m)
    layers.highest = std::min(layers.highest, layerNumber(std::floor(*options.zMax_m / r - 0.5)));
  return layers;
}

std::string heightsText(const CellMap& map, const RenderOptions& options, const Layers& layers)
{
  const double r = map.resolution();
  if (options.view == View::Slice)
    return "slice at z = " + roundText(layers.lowest * r) + " .. " + roundText((layers.lowest + 1.0) * r) +
           " m";
  if (!options.zMin_m && !options.zMax_m) return "from above";
  return "from above, z " + (options.zMin_m ? roundText(*options.zMin_m) : "lowest") + " .. " +
         (options.zMax_m ? roundText(*options.zMax_m) : "highest") + " m";
}

/// Crops the whole extent to the frame with a margin, divided by the zoom; never larger than the whole.
void crop(int32_t& first, int32_t& last, int32_t frameFirst, int32_t frameLast, double zoom)
{
  const double middle = (static_cast<double>(frameFirst) + frameLast) / 2;
  const double cells = static_cast<double>(frameLast) - frameFirst + 1;
  constexpr double kRoom = 1.06;
  const double half = kRoom * cells / 2 / zoom;
  first = static_cast<int32_t>(std::max<double>(first, std::floor(middle - half + 0.5)));
  last =
      static_cast<int32_t>(std::min<double>(last, std::max<double>(first, std::ceil(middle + half - 0.5))));
}

CellExtent shownExtent(const CellMap& map, const RenderOptions& options, const Layers& layers)
{
  const std::optional<CellExtent> box = cellsOfBox(options, map.resolution());
  std::optional<CellExtent> extent = cellExtent(map, [&](const CellIndex& cell, const CellEstimate&)
                                                { return layers.has(cell) && (!box || inside(cell, *box)); });
  if (!extent)
    failNothingToDraw(map, std::string("cell ") + (box ? "in the box " : "") + "at the heights asked for (" +
                               heightsText(map, options, layers) + ")");
  if (box) extent = box;
  const CellExtent middle =
      box ? *box
          : occupiedFrame(map, [&](const CellIndex& cell) { return layers.has(cell); }).value_or(*extent);
  crop(extent->first.x, extent->last.x, middle.first.x, middle.last.x, options.zoom);
  crop(extent->first.y, extent->last.y, middle.first.y, middle.last.y, options.zoom);
  return *extent;
}

Squares flatten(const CellMap& map, const Layers& layers, const CellExtent& extent, int maxSquares)
{
  Squares flat;
  flat.extent = extent;
  const int64_t cellsX = int64_t{extent.last.x} - extent.first.x + 1;
  const int64_t cellsY = int64_t{extent.last.y} - extent.first.y + 1;
  flat.cellsPerSquare = static_cast<int>((std::max(cellsX, cellsY) + maxSquares - 1) / maxSquares);
  flat.width = static_cast<int>((cellsX + flat.cellsPerSquare - 1) / flat.cellsPerSquare);
  flat.height = static_cast<int>((cellsY + flat.cellsPerSquare - 1) / flat.cellsPerSquare);
  flat.squares.resize(static_cast<size_t>(flat.width) * static_cast<size_t>(flat.height));
  map.visitCells(
      [&](const CellIndex& cell, const CellEstimate& estimate)
      {
        const int64_t x = (int64_t{cell.x} - extent.first.x);
        const int64_t y = (int64_t{cell.y} - extent.first.y);
        if (!layers.has(cell) || x < 0 || y < 0 || x >= cellsX || y >= cellsY) return;
        if (estimate.state == CellState::Occupied)
        {
          flat.lowestOccupied = std::min(flat.lowestOccupied, cell.z);
          flat.highestOccupied = std::max(flat.highestOccupied, cell.z);
        }
        const float variance = static_cast<float>(estimate.variance.value_or(0));
        flat.greatestVariance = std::max(flat.greatestVariance, variance);
        Square candidate{static_cast<float>(estimate.prob), variance, cell.z, estimate.state};
        Square& square =
            flat.squares[static_cast<size_t>(y / flat.cellsPerSquare) * static_cast<size_t>(flat.width) +
                         static_cast<size_t>(x / flat.cellsPerSquare)];
        candidate.anyFree = square.anyFree || estimate.state == CellState::Free;
        if (showsBetter(candidate, square))
          square = candidate;
        else
          square.anyFree = candidate.anyFree;
      });
  return flat;
}

/// Darkens corners and feet of walls: each of the eight neighbours that is higher takes away light.
double light(const Squares& flat, int x, int y)
{
  const Square& own = *flat.at(x, y);
  int higher = 0;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx)
    {
      const Square* other = flat.at(x + dx, y + dy);
      if (other != nullptr && other->observed() && other->state == CellState::Occupied &&
          other->z > own.z + 1)
        ++higher;
    }
  constexpr double kShadow = 0.06;
  return 1.0 - kShadow * higher;
}

TColor heightColor(const Squares& flat, int x, int y)
{
  const Square& square = *flat.at(x, y);
  if (square.state != CellState::Occupied) return square.anyFree ? kFree : kUnsure;
  const double span = static_cast<double>(flat.highestOccupied) - flat.lowestOccupied;
  const double height = static_cast<double>(square.z) - flat.lowestOccupied;
  const double fraction = span > 0 ? std::clamp(height / span, 0.0, 1.0) : 0.5;
  return darkened(paletteColor(Palette::Height, kHighest * fraction), light(flat, x, y));
}

TColor squareColor(const Squares& flat, int x, int y, ColorBy colorBy)
{
  const Square& square = *flat.at(x, y);
  if (!square.observed()) return kUnobserved;
  if (colorBy == ColorBy::Height) return heightColor(flat, x, y);
  if (colorBy == ColorBy::Prob) return paletteColor(Palette::Prob, static_cast<double>(square.prob));
  return paletteColor(Palette::Variance,
                      static_cast<double>(square.variance) / static_cast<double>(flat.greatestVariance));
}

CImage paint(const Squares& flat, ColorBy colorBy)
{
  CImage image(static_cast<unsigned>(flat.width), static_cast<unsigned>(flat.height), mrpt::img::CH_RGB);
  for (int row = 0; row < flat.height; ++row)
  {
    uint8_t* pixel = image.ptrLine<uint8_t>(static_cast<unsigned>(row));
    for (int x = 0; x < flat.width; ++x)
    {
      const TColor color = squareColor(flat, x, flat.height - 1 - row, colorBy);
      *pixel++ = color.B;
      *pixel++ = color.G;
      *pixel++ = color.R;
    }
  }
  return image;
}

Legend legendFor(const CellMap& map, const Squares& flat, ColorBy colorBy)
{
  Legend legend;
  const double r = map.resolution();
  if (colorBy == ColorBy::Height)
  {
    legend.title = "z [m]";
    if (flat.highestOccupied > flat.lowestOccupied)
    {
      legend.from = (flat.lowestOccupied + 0.5) * r;
      legend.to = (flat.highestOccupied + 0.5) * r;
      legend.fractionAtTo = kHighest;
    }
    else
    {
      legend.to = legend.from;
      if (flat.highestOccupied == flat.lowestOccupied)
        legend.swatches.push_back({paletteColor(Palette::Height, 0.5 * kHighest), "occupied"});
    }
    legend.swatches.push_back({kFree, "free"});
    legend.swatches.push_back({kUnsure, "unknown"});
  }
  else
  {
    legend.title = colorBy == ColorBy::Prob ? "P(occupied)" : "variance";
    legend.palette = colorBy == ColorBy::Prob ? Palette::Prob : Palette::Variance;
    if (colorBy == ColorBy::Variance) legend.to = static_cast<double>(flat.greatestVariance);
  }
  legend.swatches.push_back({kUnobserved, "unobserved"});
  return legend;
}

ColorBy automaticColor(const RenderOptions& options, const Squares& flat)
{
  if (options.colorBy != ColorBy::Automatic) return options.colorBy;
  // A sensor that scans one plane fills only a few layers, whose heights carry no information.
  constexpr int64_t kFewLayers = 5;
  const bool flatMap = int64_t{flat.highestOccupied} - flat.lowestOccupied < kFewLayers;
  return options.view == View::Slice || flatMap ? ColorBy::Prob : ColorBy::Height;
}

constexpr int kMarginLeft = 90;
constexpr int kMarginTop = 76;
constexpr int kMarginBottom = 60;
constexpr int kMarginRight = kLegendWidth + 30;

int pictureHeight(const RenderOptions& options, const CellExtent& extent)
{
  if (options.height > 0) return options.height;
  const double cellsX = static_cast<double>(extent.last.x) - extent.first.x + 1;
  const double cellsY = static_cast<double>(extent.last.y) - extent.first.y + 1;
  const double plotWidth = options.width - kMarginLeft - kMarginRight;
  const double plotHeight = std::clamp(plotWidth * cellsY / cellsX, 0.15 * plotWidth, 1.0 * plotWidth);
  return std::max(260, static_cast<int>(plotHeight) + kMarginTop + kMarginBottom);
}

/// The plot as large as it fits, with whole pixels per square if squares are large enough to look uneven
/// otherwise.
PlotArea placePlot(const RenderOptions& options, int height, const Squares& flat, double resolution_m)
{
  const double room = options.width - kMarginLeft - kMarginRight;
  const double roomY = height - kMarginTop - kMarginBottom;
  double pixels = std::min(room / flat.width, roomY / flat.height);
  constexpr double kWholeFrom = 4;
  if (pixels >= kWholeFrom) pixels = std::floor(pixels);

  PlotArea plot;
  plot.width = std::max(1, static_cast<int>(pixels * flat.width));
  plot.height = std::max(1, static_cast<int>(pixels * flat.height));
  plot.left = kMarginLeft + (static_cast<int>(room) - plot.width) / 2;
  plot.top = kMarginTop + (static_cast<int>(roomY) - plot.height) / 2;
  const double square_m = flat.cellsPerSquare * resolution_m;
  plot.xMin_m = flat.extent.first.x * resolution_m;
  plot.yMin_m = flat.extent.first.y * resolution_m;
  plot.xMax_m = plot.xMin_m + flat.width * square_m;
  plot.yMax_m = plot.yMin_m + flat.height * square_m;
  return plot;
}

/// Enlarged without smoothing, then averaged down: sharp at every scale.
CImage scaled(const CImage& squares, const PlotArea& plot)
{
  const unsigned enlarge = static_cast<unsigned>(
      std::max(1.0, std::ceil(2.0 * plot.width / static_cast<double>(squares.getWidth()))));
  CImage large;
  squares.scaleImage(large, static_cast<unsigned>(squares.getWidth()) * enlarge,
                     static_cast<unsigned>(squares.getHeight()) * enlarge, mrpt::img::IMG_INTERP_NN);
  CImage result;
  large.scaleImage(result, static_cast<unsigned>(plot.width), static_cast<unsigned>(plot.height),
                   mrpt::img::IMG_INTERP_AREA);
  return result;
}
}  // namespace

CImage drawFlat(const CellMap& map, const RenderOptions& options)
{
  const Layers layers = layersOf(map, options);
  const CellExtent extent = shownExtent(map, options, layers);
  const int height = pictureHeight(options, extent);
  Squares flat = flatten(map, layers, extent, 2 * std::max(options.width, height));
  const ColorBy colorBy = automaticColor(options, flat);
  if (options.box_map)
  {
    flat.lowestOccupied = extent.first.z;
    flat.highestOccupied = extent.last.z;
  }
  if (colorBy == ColorBy::Variance && !(flat.greatestVariance > 0))
    throw std::runtime_error("the map has no variance to be coloured by; colour it by prob");
  const PlotArea plot = placePlot(options, height, flat, map.resolution());

  CImage picture(static_cast<unsigned>(options.width), static_cast<unsigned>(height), mrpt::img::CH_RGB);
  picture.filledRectangle(0, 0, options.width, height, TColor(255, 255, 255));
  picture.drawImage(plot.left, plot.top, scaled(paint(flat, colorBy), plot));
  drawAxes(picture, plot);
  drawLegend(picture, plot.left + plot.width + 24, plot.top, plot.height, legendFor(map, flat, colorBy));
  drawTitle(picture, plot.left, std::max(8, plot.top - 60),
            map.className() + ", " + heightsText(map, options, layers) + ", cells of " +
                roundText(map.resolution()) + " m");
  return picture;
}

}  // namespace lamap::tools
