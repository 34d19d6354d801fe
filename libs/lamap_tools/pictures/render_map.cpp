#include <lamap_tools/pictures/render_map.h>

#include <lamap_mrpt/files/atomic_file.h>
#include <lamap_tools/files/file_names.h>
#include <lamap_tools/files/file_output.h>
#include <lamap_tools/files/usage_error.h>
#include <lamap_tools/pictures/flat_view.h>
#include <lamap_tools/pictures/perspective_view.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <system_error>

namespace lamap::tools
{
namespace
{
constexpr int kMinPixels = 320;
constexpr int kMaxPixels = 8192;

/// The picture's writer does not report why it failed.
[[noreturn]] void failWriting(const std::string& path, const std::string& temporaryPath)
{
  constexpr std::uintmax_t kFull = 16 * 1024;  // [bytes]
  std::error_code error;
  const auto space = std::filesystem::space(temporaryPath, error);
  throw std::runtime_error(path + ": cannot be written" +
                           (!error && space.available < kFull ? ": No space left on device" : ""));
}

void requireLegalBox(const mrpt::math::TBoundingBox& box)
{
  constexpr double kFarthest_m = 1e7;
  for (int axis = 0; axis < 3; ++axis)
  {
    const double low = box.min[axis];
    const double high = box.max[axis];
    if (!(std::abs(low) <= kFarthest_m && std::abs(high) <= kFarthest_m && low < high))
      throw UsageError("a box from " + shortest(low) + " to " + shortest(high) + " m along " +
                       std::string(1, "xyz"[axis]) +
                       "; expected its lowest corner and then its highest, within 1e7 m");
  }
}

void requireLegal(const RenderOptions& options)
{
  const auto refuse = [](const std::string& what) { throw UsageError(what); };
  const auto legalSize = [](int pixels) { return pixels >= kMinPixels && pixels <= kMaxPixels; };
  if (!legalSize(options.width) || (options.height != 0 && !legalSize(options.height)))
    refuse("a size of " + std::to_string(options.width) + "x" + std::to_string(options.height) +
           " pixels; expected " + std::to_string(kMinPixels) + " to " + std::to_string(kMaxPixels) + " each");
  if (!(options.zoom >= 1e-3 && options.zoom <= 1e3))
    refuse("a zoom of " + shortest(options.zoom) + "; expected 0.001 to 1000");
  for (const auto& height_m : {options.z_m, options.zMin_m, options.zMax_m})
    if (height_m && !std::isfinite(*height_m)) refuse("a height is not a finite number [m]");
  if (options.azimuth_deg && !std::isfinite(*options.azimuth_deg))
    refuse("the azimuth is not a finite number [deg]");
  if (options.elevation_deg && !(std::abs(*options.elevation_deg) <= 90))
    refuse("an elevation of " + shortest(*options.elevation_deg) + " deg; expected -90 to 90");
  if ((options.azimuth_deg || options.elevation_deg) && options.view != View::Perspective)
    refuse("azimuth and elevation are of the 3d view's camera");
  if (options.box_map) requireLegalBox(*options.box_map);
  if (options.zMin_m && options.zMax_m && !(*options.zMin_m <= *options.zMax_m))
    refuse("a z-min of " + shortest(*options.zMin_m) + " m above the z-max of " + shortest(*options.zMax_m) +
           " m");
  if (options.z_m && options.view != View::Slice) refuse("a height z is for the slice view only");
  if ((options.zMin_m || options.zMax_m) && options.view == View::Slice)
    refuse("z-min and z-max are for the top and 3d views; a slice takes one z");
  if (options.colorBy == ColorBy::Height && options.view == View::Slice)
    refuse("a slice has one height; colour it by prob or variance");
  if (options.showFree && options.view != View::Perspective)
    refuse("show-free is for the 3d view; the others show free space always");
}
}  // namespace

void requireDrawable(const std::string& path, const RenderOptions& options)
{
  requireLegal(options);
  if (extensionOf(path) != ".png") throw UsageError(path + ": pictures are written as .png");
}

mrpt::img::CImage drawMap(const CellMap& map, const RenderOptions& options)
{
  requireLegal(options);
  return options.view == View::Perspective ? drawPerspective(map, options) : drawFlat(map, options);
}

void renderMap(const CellMap& map, const std::string& path, const RenderOptions& options)
{
  requireDrawable(path, options);
  AtomicFile file(path);
  const mrpt::img::CImage picture = drawMap(map, options);
  if (!picture.saveToFile(file.temporaryPath())) failWriting(path, file.temporaryPath());
  file.commit();
}

void parseSize(const std::string& text, RenderOptions& options)
{
  const char* end = text.data() + text.size();
  const auto width = std::from_chars(text.data(), end, options.width);
  const bool cross = width.ec == std::errc() && width.ptr != end && (*width.ptr == 'x' || *width.ptr == 'X');
  const auto height = cross ? std::from_chars(width.ptr + 1, end, options.height) : width;
  if (!cross || height.ec != std::errc() || height.ptr != end)
    throw UsageError("size '" + text + "'; expected WIDTHxHEIGHT in pixels, e.g. 1600x1000");
}

}  // namespace lamap::tools
