#include <lamap_tools/commands/map_build.h>
#include <lamap_tools/files/output_paths.h>

#include "command_line.h"

namespace lamap::app
{
namespace
{
struct BuildArguments
{
  tools::BuildOptions build;
  LogArguments log;
  bool json = false;
};

void describe(CLI::App& command, BuildArguments& arguments)
{
  tools::BuildOptions& options = arguments.build;
  command
      .add_option("-i,--input", options.inputs.paths,
                  "Logs: .rawlog, .simplemap[.gz], .pcd or a folder of them, .graph; an input named twice is "
                  "used twice")
      ->required();
  command.add_option(
      "-m,--map", options.map.mapName,
      "Kind of map: bgkMap, hilbertMap, overlappingHilbertMap, gpMap, or one of MRPT's own, e.g. octoMap");
  command.add_option("-c,--config", options.map.configPath,
                     ".ini file with [map] and [map_<kind>_00_...]; without -m, it selects the map");
  command.add_option("-o,--output", options.outPath, "Where to save: .lamap.gz; with -m octoMap also .ot")
      ->required();
  command.add_option("-s,--set", options.map.settings,
                     "section.key=value, overrides the file, e.g. insertOpts.maxRange=30");
  command.add_option("--onto", options.ontoPath, "Continue this saved map, with its own options");
  command.add_flag(
      "--strict", options.strict,
      "Stop at the first scan that cannot be read or learned, and save nothing; otherwise it is left out "
      "and named");
  addLogOptions(command, arguments.log, options.inputs, options.threads);
  command.add_flag("--json", arguments.json, "Print the final report as JSON");
}

int build(BuildArguments& arguments)
{
  // The saved map may replace the one that is continued.
  tools::requireOwnPlaces({arguments.build.outPath},
                          pathsRead(arguments.build.inputs, {arguments.build.map.configPath}));
  prepareInputs(arguments.log, arguments.build.inputs);
  const tools::BuildReport report =
      withProgressBar([&](const auto& progress) { return tools::buildMap(arguments.build, progress); });
  if (arguments.json)
    print(tools::reportJson(report));
  else
    tools::printReport(report, results());
  if (report.stopped)
    return stoppedByUser(report.saved ? "; the map so far is saved to " + report.outPath : "");
  const int code = tellDamages(arguments.log.allowTruncated, report.inputs);
  if (tools::damaged(report.inputs))
    std::cerr << "lamap: what could be read is saved to " << report.outPath << "\n";
  return code;
}
}  // namespace

void addBuild(CLI::App& app, Action& action)
{
  addCommand<BuildArguments, build>(app, action, "build", "Build a map from logs, or continue a saved one",
                                    describe);
}

}  // namespace lamap::app
