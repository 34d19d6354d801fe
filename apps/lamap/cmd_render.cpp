#include <lamap_tools/files/output_paths.h>
#include <lamap_tools/pictures/render_map.h>

#include "command_line.h"

namespace lamap::app
{
namespace
{
struct RenderArguments
{
  std::string map;
  std::string out;
  std::string size;
  std::vector<double> box;
  tools::RenderOptions options;
};

void describe(CLI::App& command, RenderArguments& arguments)
{
  addMapArgument(command, arguments.map);
  command.add_option("-o,--output", arguments.out, "The picture, .png")->required();
  static const std::map<std::string, tools::View> kViews = {
      {"top", tools::View::Top}, {"slice", tools::View::Slice}, {"3d", tools::View::Perspective}};
  static const std::map<std::string, tools::ColorBy> kColors = {{"height", tools::ColorBy::Height},
                                                                {"prob", tools::ColorBy::Prob},
                                                                {"variance", tools::ColorBy::Variance}};
  tools::RenderOptions& options = arguments.options;
  command.add_option("--view", options.view, "top, slice or 3d")->transform(oneOf(kViews));
  command
      .add_option("--color", options.colorBy,
                  "height, prob or variance; default: prob for slices, else height")
      ->transform(oneOf(kColors));
  command.add_option("--z", options.z_m,
                     "slice: its height [m]; default: the height with the most occupied cells");
  command.add_option("--z-min", options.zMin_m, "top, 3d: leave out cells below this height [m]");
  command.add_option("--z-max", options.zMax_m,
                     "top, 3d: leave out cells above this height [m], e.g. a ceiling");
  command.add_option(
      "--size", arguments.size,
      "WIDTHxHEIGHT in pixels, 320 to 8192 each; default: 1600 wide, with the height that fits the map");
  const auto usually = [](double degrees) { return "; default " + CLI::detail::to_string(degrees); };
  command.add_option(
      "--azimuth", options.azimuth_deg,
      "3d: where the camera stands, counter-clockwise from +x [deg]" + usually(tools::kUsualAzimuth_deg));
  command.add_option("--elevation", options.elevation_deg,
                     "3d: how high the camera stands, -90 to 90 [deg]" + usually(tools::kUsualElevation_deg));
  command.add_option("--zoom", options.zoom, "1 shows everything, 2 the middle half, ...")
      ->capture_default_str();
  command
      .add_option(
          "--box", arguments.box,
          "x0,y0,z0,x1,y1,z1 [m]: the part of the map to show, e.g. to make pictures of several maps match; "
          "default: around the occupied cells")
      ->delimiter(',')
      ->expected(6);
  command.add_flag("--show-free", options.showFree, "3d: show free space as a faint surface");
}

int render(RenderArguments& arguments)
{
  if (!arguments.size.empty()) tools::parseSize(arguments.size, arguments.options);
  if (const auto& box = arguments.box; !box.empty())
  {
    // Not by its constructor, whose message about corners in the wrong order does not help.
    arguments.options.box_map.emplace();
    arguments.options.box_map->min = {box[0], box[1], box[2]};
    arguments.options.box_map->max = {box[3], box[4], box[5]};
  }
  tools::requireOwnPlaces({arguments.out}, {arguments.map});
  tools::requireDrawable(arguments.out, arguments.options);
  tools::renderMap(*tools::openCellMap(arguments.map), arguments.out, arguments.options);
  return 0;
}
}  // namespace

void addRender(CLI::App& app, Action& action)
{
  addCommand<RenderArguments, render>(app, action, "render", "Draw a map as a PNG, without a display",
                                      describe);
}

}  // namespace lamap::app
