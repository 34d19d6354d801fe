#include <lamap_tools/pictures/perspective_view.h>

#include <lamap_tools/cells/cell_table.h>
#include <lamap_tools/pictures/occupied_frame.h>
#include <lamap_tools/pictures/palette.h>
#include <lamap_tools/pictures/picture_frame.h>
#include <lamap_tools/pictures/pinhole_view.h>
#include <lamap_tools/pictures/voxel_mesh.h>
#include <mrpt/math/CMatrixF.h>
#include <mrpt/opengl/CFBORender.h>
#include <mrpt/opengl/COpenGLScene.h>
#include <mrpt/opengl/CSetOfLines.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace lamap::tools
{
namespace
{
using Eigen::Vector3d;
using mrpt::img::CImage;
using mrpt::img::TColor;

const TColor kBackground(255, 255, 255);
const TColor kGrid(205, 210, 215);
const TColor kFreeSurface(120, 175, 235);
constexpr double kFreeOpacity = 0.3;
constexpr double kPaletteEnd = 0.97;  // of the palette

/// The picture is drawn this much larger and averaged down, to avoid jagged edges.
constexpr int kOversampling = 2;
constexpr double kDegree = 3.14159265358979323846 / 180;
/// About 260 bytes each in MRPT and as much again in OpenGL; a picture has fewer pixels than this.
constexpr size_t kMaxFaces = 4'000'000;

uint8_t mixed(uint8_t below, uint8_t above, double opacity)
{
  return static_cast<uint8_t>(std::lround(below * (1 - opacity) + above * opacity));
}

TColor mixed(const TColor& below, const TColor& above, double opacity)
{
  return {mixed(below.R, above.R, opacity), mixed(below.G, above.G, opacity),
          mixed(below.B, above.B, opacity)};
}

/// Which cells are drawn.
struct Selection
{
  Selection(const RenderOptions& given, double resolution)
      : options(given), resolution_m(resolution), box(cellsOfBox(given, resolution))
  {
  }

  [[nodiscard]] bool has(const CellIndex& cell) const
  {
    const double z_m = (cell.z + 0.5) * resolution_m;
    return (!options.zMin_m || z_m >= *options.zMin_m) && (!options.zMax_m || z_m <= *options.zMax_m) &&
           (!box || inside(cell, *box));
  }

  const RenderOptions& options;
  double resolution_m = 0;
  std::optional<CellExtent> box;
};

/// The cells to draw, relative to the first cell of their extent, with edges of 2^coarseness finest cells.
struct Cells
{
  CellExtent extent;  ///< of the occupied ones
  CellExtent frame;   ///< what the picture should show
  int coarseness = 0;
  std::vector<CellIndex> occupied;
  std::vector<CellIndex> free;
  std::vector<std::pair<CellIndex, float>> quantity;  ///< for their colours (except for heights), sorted
  float greatestVariance = 0;
};

CellExtent occupiedExtent(const CellMap& map, const Selection& selection)
{
  const auto extent = cellExtent(map, [&](const CellIndex& cell, const CellEstimate& estimate)
                                 { return estimate.state == CellState::Occupied && selection.has(cell); });
  if (!extent)
    failNothingToDraw(map, std::string("occupied cell ") + (selection.box ? "in the box" : "at the heights") +
                               " asked for");
  return *extent;
}

CellIndex coarse(const CellIndex& cell, const CellExtent& extent, int coarseness)
{
  const auto index = [&](int32_t own, int32_t first)
  { return static_cast<int32_t>((int64_t{own} - first) >> coarseness); };
  return {index(cell.x, extent.first.x), index(cell.y, extent.first.y), index(cell.z, extent.first.z)};
}

Cells gather(const CellMap& map, const Selection& selection, const CellExtent& extent, int coarseness)
{
  const RenderOptions& options = selection.options;
  Cells cells;
  cells.extent = extent;
  cells.coarseness = coarseness;
  map.visitCells(
      [&](const CellIndex& cell, const CellEstimate& estimate)
      {
        if (!inside(cell, extent) || !selection.has(cell)) return;
        if (estimate.state == CellState::Free && options.showFree)
          cells.free.push_back(coarse(cell, extent, coarseness));
        if (estimate.state != CellState::Occupied) return;
        cells.occupied.push_back(coarse(cell, extent, coarseness));
        if (options.colorBy != ColorBy::Prob && options.colorBy != ColorBy::Variance) return;
        const float variance = static_cast<float>(estimate.variance.value_or(0));
        cells.greatestVariance = std::max(cells.greatestVariance, variance);
        cells.quantity.emplace_back(cells.occupied.back(), options.colorBy == ColorBy::Prob
                                                               ? static_cast<float>(estimate.prob)
                                                               : variance);
      });
  // If several finest cells share a coarse one, their maximum sets its colour.
  std::sort(cells.quantity.begin(), cells.quantity.end(),
            [](const auto& a, const auto& b)
            { return a.first == b.first ? a.second > b.second : inTableOrder(a.first, b.first); });
  return cells;
}

/// As fine as kMaxFaces allows.
Cells gatherWithinLimits(const CellMap& map, const RenderOptions& options)
{
  const Selection selection(options, map.resolution());
  const CellExtent extent = occupiedExtent(map, selection);
  const CellExtent frame =
      selection.box ? *selection.box
                    : occupiedFrame(map, [&](const CellIndex& cell) { return selection.has(cell); }).value();
  for (int coarseness = 0;; ++coarseness)
  {
    Cells cells = gather(map, selection, extent, coarseness);
    cells.frame = frame;
    if (VoxelMesh(cells.occupied, 1).faceCount() + VoxelMesh(cells.free, 1).faceCount() <= kMaxFaces)
      return cells;
  }
}

float quantityOf(const Cells& cells, const CellIndex& cell)
{
  const auto found =
      std::lower_bound(cells.quantity.begin(), cells.quantity.end(), cell,
                       [](const auto& a, const CellIndex& b) { return inTableOrder(a.first, b); });
  return found->second;
}

/// The palette's range: heights [m], probabilities, or variances.
Legend legendFor(const CellMap& map, const Cells& cells, const RenderOptions& options)
{
  Legend legend;
  const double r = map.resolution();
  if (options.colorBy == ColorBy::Prob)
  {
    legend.title = "P(occupied)";
    legend.from = 0.5;
    legend.fractionAtTo = kPaletteEnd;
  }
  else if (options.colorBy == ColorBy::Variance)
  {
    legend.title = "variance";
    legend.palette = Palette::Variance;
    legend.to = static_cast<double>(cells.greatestVariance);
  }
  else
  {
    legend.title = "z [m]";
    legend.fractionAtTo = kPaletteEnd;
    legend.from = cells.frame.first.z * r;
    legend.to = (cells.frame.last.z + 1.0) * r;
    // With a single layer, heights carry no information.
    if (cells.frame.first.z == cells.frame.last.z)
    {
      legend.to = legend.from;
      legend.swatches.push_back({paletteColor(legend.palette, 0.5 * kPaletteEnd), "occupied"});
    }
  }
  if (options.showFree)
    legend.swatches.push_back({mixed(kBackground, kFreeSurface, kFreeOpacity), "free space"});
  return legend;
}

VoxelMesh::ColorOf colorsFor(const Cells& cells, const Legend& legend, const RenderOptions& options, double r)
{
  return [&cells, &options, legend, r](const CellIndex& cell)
  {
    double quantity = 0;
    if (options.colorBy == ColorBy::Prob || options.colorBy == ColorBy::Variance)
      quantity = static_cast<double>(quantityOf(cells, cell));
    else
      quantity = cells.extent.first.z * r + (cell.z + 0.5) * std::ldexp(r, cells.coarseness);
    const double fraction =
        legend.to > legend.from ? (quantity - legend.from) / (legend.to - legend.from) : 0.5;
    return paletteColor(legend.palette, legend.fractionAtTo * fraction);
  };
}

/// Distance of the numbers from the grid [steps of the grid].
constexpr double kNumbersAway = 0.35;

/// The ground under the map, and its lines in metres of the map frame.
struct Ground
{
  Vector3d origin_map;  ///< of the scene's frame
  double z_m = 0;
  double step_m = 1;
  double xMin_m = 0, xMax_m = 0, yMin_m = 0, yMax_m = 0;  ///< in the map frame, multiples of the step
};

Ground groundUnder(const Cells& cells, double r)
{
  Ground ground;
  const CellIndex& origin = cells.extent.first;
  ground.origin_map = {origin.x * r, origin.y * r, origin.z * r};
  const auto& [first, last] = cells.frame;
  ground.z_m = first.z * r;
  const double xFrom = first.x * r;
  const double yFrom = first.y * r;
  const double xTo = (last.x + 1.0) * r;
  const double yTo = (last.y + 1.0) * r;
  ground.step_m = roundStep(std::max(xTo - xFrom, yTo - yFrom) / 12);
  const auto down = [&](double x) { return std::floor(x / ground.step_m) * ground.step_m; };
  const auto up = [&](double x) { return std::ceil(x / ground.step_m) * ground.step_m; };
  ground.xMin_m = down(xFrom);
  ground.yMin_m = down(yFrom);
  ground.xMax_m = up(xTo);
  ground.yMax_m = up(yTo);
  return ground;
}

mrpt::opengl::CSetOfLines::Ptr gridLines(const Ground& ground)
{
  auto lines = mrpt::opengl::CSetOfLines::Create();
  lines->setColor_u8(kGrid);
  lines->setLineWidth(kOversampling);
  const Vector3d& o = ground.origin_map;
  const double z = ground.z_m - o.z();
  for (const double x : multiplesWithin(ground.xMin_m, ground.xMax_m, ground.step_m))
    lines->appendLine(x - o.x(), ground.yMin_m - o.y(), z, x - o.x(), ground.yMax_m - o.y(), z);
  for (const double y : multiplesWithin(ground.yMin_m, ground.yMax_m, ground.step_m))
    lines->appendLine(ground.xMin_m - o.x(), y - o.y(), z, ground.xMax_m - o.x(), y - o.y(), z);
  return lines;
}

/// Chooses the picture's height so that it fits the points.
void fitWithHeight(PinholeView& view, const std::vector<Vector3d>& points, double margin)
{
  view.height = view.width;
  view.fit(points, margin);
  double top = view.height;
  double bottom = 0;
  for (const Vector3d& point : points)
    if (const auto pixel = view.project(point))
    {
      top = std::min(top, pixel->y);
      bottom = std::max(bottom, pixel->y);
    }
  const double height = std::clamp(bottom - top + 2 * margin, 0.4 * view.width, view.width);
  // The same focal length in a lower picture, so that the points keep their size.
  view.verticalFov_rad = 2 * std::atan(std::tan(view.verticalFov_rad / 2) * std::round(height) / view.height);
  view.height = std::round(height);
  view.fit(points, margin);
}

/// The points that must be in view: the occupied cells (a sample, if there are many) and the ground's
/// corners.
PinholeView viewOf(const Cells& cells, const Ground& ground, const RenderOptions& options, double edge_m,
                   int width, int height)
{
  std::vector<Vector3d> points;
  constexpr size_t kEnough = 200'000;
  const size_t stride = cells.occupied.size() / kEnough + 1;
  const CellIndex first = coarse(cells.frame.first, cells.extent, cells.coarseness);
  const CellIndex last = coarse(cells.frame.last, cells.extent, cells.coarseness);
  for (size_t i = 0; i < cells.occupied.size(); i += stride)
    if (inside(cells.occupied[i], {first, last})) points.push_back(cellCentre(cells.occupied[i], edge_m));
  const double numbers_m = kNumbersAway * ground.step_m;
  for (const double x : {ground.xMin_m - numbers_m, ground.xMax_m + numbers_m})
    for (const double y : {ground.yMin_m - numbers_m, ground.yMax_m + numbers_m})
      points.push_back(Vector3d(x, y, ground.z_m) - ground.origin_map);

  PinholeView view;
  view.azimuth_rad = options.azimuth_deg.value_or(kUsualAzimuth_deg) * kDegree;
  view.elevation_rad = options.elevation_deg.value_or(kUsualElevation_deg) * kDegree;
  view.verticalFov_rad = 30 * kDegree;
  view.width = width;
  constexpr double kMargin = 20;
  if (height > 0)
  {
    view.height = height;
    view.fit(points, kMargin);
  }
  else
    fitWithHeight(view, points, kMargin);
  view.distance /= options.zoom;
  return view;
}

struct Shot
{
  CImage color;
  mrpt::math::CMatrixFloat depth;  ///< 0: background
};

/// Clipping planes as close to the scene as possible, because OpenGL's depth has limited resolution.
struct Clip
{
  double nearest = 0;
  double farthest = 0;
};

Clip clipAround(const Ground& ground, const Cells& cells, double r, const PinholeView& view)
{
  Clip clip{view.distance, view.distance};
  const auto& [first, last] = cells.extent;
  for (const double x : {ground.xMin_m, ground.xMax_m, first.x * r, (last.x + 1.0) * r})
    for (const double y : {ground.yMin_m, ground.yMax_m, first.y * r, (last.y + 1.0) * r})
      for (const double z : {cells.extent.first.z * r, (cells.extent.last.z + 1.0) * r})
      {
        const double depth =
            view.distance - (Vector3d(x, y, z) - ground.origin_map - view.lookAt).dot(view.backward());
        clip.nearest = std::min(clip.nearest, depth);
        clip.farthest = std::max(clip.farthest, depth);
      }
  clip.farthest *= 1.01;
  clip.nearest = std::max(0.99 * clip.nearest, 1e-3 * clip.farthest);
  return clip;
}

Shot shoot(const std::vector<mrpt::opengl::CRenderizable::Ptr>& objects, const PinholeView& view,
           const Clip& clip)
{
  mrpt::opengl::COpenGLScene scene;
  for (const auto& object : objects) scene.insert(object);
  auto viewport = scene.getViewport();
  viewport->setCustomBackgroundColor(mrpt::img::TColorf(kBackground));
  viewport->setViewportClipDistances(static_cast<float>(clip.nearest), static_cast<float>(clip.farthest));

  Shot shot;
  try
  {
    mrpt::opengl::CFBORender renderer(static_cast<unsigned>(view.width) * kOversampling,
                                      static_cast<unsigned>(view.height) * kOversampling);
    auto& camera = renderer.getCamera(scene);
    camera.setPointingAt(static_cast<float>(view.lookAt.x()), static_cast<float>(view.lookAt.y()),
                         static_cast<float>(view.lookAt.z()));
    camera.setZoomDistance(static_cast<float>(view.distance));
    camera.setAzimuthDegrees(static_cast<float>(view.azimuth_rad / kDegree));
    camera.setElevationDegrees(static_cast<float>(view.elevation_rad / kDegree));
    camera.setProjectiveFOVdeg(static_cast<float>(view.verticalFov_rad / kDegree));
    renderer.render_RGBD(scene, shot.color, shot.depth);
  }
  catch (const std::exception& error)
  {
    throw std::runtime_error(
        std::string("the 3D view draws through EGL, which does not work here (it needs the packages "
                    "libegl1 and libgl1-mesa-dri, no display and no GPU): ") +
        error.what());
  }
  return shot;
}

/** Eye-dome lighting (Boucheny 2009): a pixel that is deeper than its neighbours is darkened, so that edges
 * are visible even if colours do not distinguish two walls. */
void shadeByDepth(Shot& shot)
{
  const int rows = static_cast<int>(shot.depth.rows());
  const int cols = static_cast<int>(shot.depth.cols());
  constexpr int kReach = kOversampling;
  constexpr double kStrength = 12.0;
  constexpr double kMostShade = 0.45;
  const auto logDepth = [&](int row, int col)
  { return std::log2(static_cast<double>(shot.depth(row, col))); };
  for (int row = kReach; row < rows - kReach; ++row)
  {
    uint8_t* pixels = shot.color.ptrLine<uint8_t>(static_cast<unsigned>(row));
    for (int col = kReach; col < cols - kReach; ++col)
    {
      if (shot.depth(row, col) <= 0) continue;
      const double own = logDepth(row, col);
      double deeper = 0;
      for (const auto& [dy, dx] : {std::pair{-kReach, 0}, {kReach, 0}, {0, -kReach}, {0, kReach}})
        if (shot.depth(row + dy, col + dx) > 0) deeper += std::max(0.0, own - logDepth(row + dy, col + dx));
      const double light = std::max(1 - kMostShade, std::exp(-kStrength * deeper / 4));
      for (int channel = 0; channel < 3; ++channel)
        pixels[3 * col + channel] = static_cast<uint8_t>(pixels[3 * col + channel] * light);
    }
  }
}

/// Draws a second scene over the first, translucent where it is in front.
void blendInFront(Shot& shot, const Shot& front, double opacity)
{
  for (int row = 0; row < static_cast<int>(shot.depth.rows()); ++row)
  {
    uint8_t* below = shot.color.ptrLine<uint8_t>(static_cast<unsigned>(row));
    const uint8_t* above = front.color.ptrLine<uint8_t>(static_cast<unsigned>(row));
    for (int col = 0; col < static_cast<int>(shot.depth.cols()); ++col)
    {
      const float depth = front.depth(row, col);
      if (depth <= 0 || (shot.depth(row, col) > 0 && shot.depth(row, col) < depth)) continue;
      for (int channel = 3 * col; channel < 3 * col + 3; ++channel)
        below[channel] = mixed(below[channel], above[channel], opacity);
    }
  }
}

/// Labels in metres along the two edges of the ground nearest to the camera.
/// @param top of the scene in the picture
void drawGridNumbers(CImage& picture, int top, const PinholeView& view, const Ground& ground)
{
  const Vector3d& o = ground.origin_map;
  const double nearX = std::cos(view.azimuth_rad) >= 0 ? ground.xMax_m : ground.xMin_m;
  const double nearY = std::sin(view.azimuth_rad) >= 0 ? ground.yMax_m : ground.yMin_m;
  const double away = kNumbersAway * ground.step_m;
  const auto write = [&](double x, double y, const std::string& text)
  {
    const auto pixel = view.project(Vector3d(x, y, ground.z_m) - o);
    if (pixel && pixel->x > 0 && pixel->x < view.width && pixel->y > 0 && pixel->y < view.height)
      drawText(picture, static_cast<int>(pixel->x), top + static_cast<int>(pixel->y) - kTextHeight / 2, text,
               Anchor::Middle);
  };
  const double outX = nearX + (nearX == ground.xMax_m ? away : -away);
  const double outY = nearY + (nearY == ground.yMax_m ? away : -away);
  for (const double x : multiplesWithin(ground.xMin_m, ground.xMax_m, ground.step_m))
    write(x, outY, roundText(x));
  for (const double y : multiplesWithin(ground.yMin_m, ground.yMax_m, ground.step_m))
    write(outX, y, roundText(y));
}
}  // namespace

CImage drawPerspective(const CellMap& map, const RenderOptions& options)
{
  const double r = map.resolution();
  const Cells cells = gatherWithinLimits(map, options);
  if (options.colorBy == ColorBy::Variance && !(cells.greatestVariance > 0))
    throw std::runtime_error("the map has no variance to be coloured by; colour it by height or prob");
  const double edge_m = std::ldexp(r, cells.coarseness);
  const Legend legend = legendFor(map, cells, options);
  const Ground ground = groundUnder(cells, r);
  constexpr int kTop = 50;
  const int sceneWidth = options.width - kLegendWidth;
  const PinholeView view =
      viewOf(cells, ground, options, edge_m, sceneWidth, std::max(0, options.height - kTop));
  const int height = kTop + static_cast<int>(view.height);

  const auto solid = VoxelMesh(cells.occupied, edge_m).triangles(colorsFor(cells, legend, options, r));
  const Clip clip = clipAround(ground, cells, r, view);
  Shot shot = shoot({gridLines(ground), solid}, view, clip);
  shadeByDepth(shot);
  if (options.showFree && !cells.free.empty())
  {
    const auto faint = VoxelMesh(cells.free, edge_m).triangles([](const CellIndex&) { return kFreeSurface; });
    blendInFront(shot, shoot({faint}, view, clip), kFreeOpacity);
  }

  CImage scene;
  shot.color.scaleImage(scene, static_cast<unsigned>(sceneWidth), static_cast<unsigned>(height - kTop),
                        mrpt::img::IMG_INTERP_AREA);
  CImage picture(static_cast<unsigned>(options.width), static_cast<unsigned>(height), mrpt::img::CH_RGB);
  picture.filledRectangle(0, 0, options.width, height, kBackground);
  picture.drawImage(0, kTop, scene);
  drawGridNumbers(picture, kTop, view, ground);
  drawLegend(picture, sceneWidth + 10, kTop, height - 2 * kTop, legend);
  drawTitle(picture, 20, 16,
            map.className() + ", cells of " + roundText(r) + " m, grid of " + roundText(ground.step_m) +
                " m" + (cells.coarseness > 0 ? ", drawn at " + roundText(edge_m) + " m" : ""));
  return picture;
}

}  // namespace lamap::tools
