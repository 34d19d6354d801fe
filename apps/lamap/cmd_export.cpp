#include <lamap_tools/export/export_map.h>
#include <lamap_tools/files/output_paths.h>

#include "command_line.h"

namespace lamap::app
{
namespace
{
struct ExportArguments
{
  std::string map;
  std::string out;
  std::string states;
  std::string as;
  tools::ExportOptions options;
};

void describe(CLI::App& command, ExportArguments& arguments)
{
  addMapArgument(command, arguments.map);
  command
      .add_option("-o,--output", arguments.out,
                  ".csv, .ply, .pcd, .bt, .ot, .3Dscene, .png (from above), .yaml (ROS map_server, with its "
                  ".pgm), or "
                  "a serialized map of MRPT's own: .gridmap.gz, .pts.gz (points), .metricmap (several)")
      ->required();
  command.add_option(
      "--states", arguments.states,
      "Cells to write: occupied, free, unknown, separated by commas, or all (.csv, .ply, .pcd, .3Dscene; "
      "default all for .csv, occupied for the others)");
  command.add_option(
      "--as", arguments.as,
      "MRPT's own maps to write: grid, points, octomap, separated by commas (.metricmap; default "
      "all), or one of them (.gz)");
  command.add_option("--z", arguments.options.z_m, "Height of the slice [m] (.yaml, grids)");
  command.add_option("--z-min", arguments.options.zMin_m,
                     "Lowest height of a projection [m] (.yaml, grids, .png)");
  command.add_option("--z-max", arguments.options.zMax_m,
                     "Greatest height of a projection [m] (.yaml, grids, .png)");
}

int exportMap(ExportArguments& arguments)
{
  if (!arguments.states.empty()) arguments.options.states = tools::parseStates(arguments.states);
  if (!arguments.as.empty()) arguments.options.as = tools::parseStockMaps(arguments.as);
  tools::requireOwnPlaces({arguments.out}, {arguments.map});
  tools::requireExportable(arguments.out, arguments.options);
  const auto map = tools::openCellMap(arguments.map);
  tools::exportMap(*map, arguments.out, arguments.options);
  const std::string remark = tools::remarkOn(*map, arguments.out, arguments.options);
  if (!remark.empty()) std::cerr << "lamap: " << remark << "\n";
  return 0;
}
}  // namespace

void addExport(CLI::App& app, Action& action)
{
  addCommand<ExportArguments, exportMap>(
      app, action, "export", "Export a map for other programs; the extension selects the format", describe);
}

}  // namespace lamap::app
