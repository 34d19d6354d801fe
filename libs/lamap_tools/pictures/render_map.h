#pragma once

#include <lamap_tools/cells/cell_map.h>
#include <mrpt/img/CImage.h>
#include <mrpt/math/TBoundingBox.h>

#include <optional>
#include <string>

namespace lamap::tools
{
enum class View
{
  Top,         ///< from above; a column shows its highest occupied cell or else its most probable one
  Slice,       ///< the layer of cells at one height
  Perspective  ///< occupied cells in 3D
};

enum class ColorBy
{
  Automatic,  ///< Slice and maps of few layers: Prob, else Height
  Height,
  Prob,
  Variance
};

constexpr double kUsualAzimuth_deg = -60;
constexpr double kUsualElevation_deg = 40;

struct RenderOptions
{
  View view = View::Top;
  ColorBy colorBy = ColorBy::Automatic;
  /// Height [m] of the slice. Default: the layer with the most occupied cells.
  std::optional<double> z_m;
  /// Top, Perspective: only cells with centres within these heights [m]. Default: no limit.
  std::optional<double> zMin_m;
  std::optional<double> zMax_m;
  /// Size of the picture [pixels]. Height 0: chosen by the map's shape.
  int width = 1600;
  int height = 0;
  /// Perspective: direction of the camera as seen from the map: counter-clockwise from +x, and above the
  /// ground [deg].
  std::optional<double> azimuth_deg;
  std::optional<double> elevation_deg;
  /// 1 shows the occupied cells (without a few distant ones), 2 the middle half of that, 0.5 twice as much.
  double zoom = 1;
  /// Perspective: free space as a faint surface.
  bool showFree = false;
  /// The part of the map that is shown [m]: cells outside are omitted, and colours span its heights. Default:
  /// around the occupied cells, without a few distant ones (which the 3D view shows).
  std::optional<mrpt::math::TBoundingBox> box_map{};
};

/** Checks a picture's path and options before a map is read for it.
 * @throws UsageError naming the option that is out of range or contradicts the view, or a path that does not
 * end in .png. */
void requireDrawable(const std::string& path, const RenderOptions& options);

/** Draws a map with axes in metres and a legend. Needs no display; Perspective draws through EGL, with or
 * without a GPU (Mesa's software driver). The same map and options give the same picture.
 * @throws std::runtime_error if there is nothing to draw (names the heights), the map has no variance for
 * colouring by it, or there is no EGL (names the packages); UsageError for an option out of range. */
[[nodiscard]] mrpt::img::CImage drawMap(const CellMap& map, const RenderOptions& options);

/// drawMap into a PNG file. @throws also if the path does not end in .png or cannot be written.
void renderMap(const CellMap& map, const std::string& path, const RenderOptions& options = {});

/// A size in pixels from "WIDTHxHEIGHT" into the options. @throws UsageError naming the text.
void parseSize(const std::string& text, RenderOptions& options);

}  // namespace lamap::tools
