#include "commands.h"

#include <lamap_tools/map_build.h>
#include <lamap_tools/progress_bar.h>
#include <lamap_tools/query_map.h>
#include <unistd.h>

#include <iostream>
#include <memory>

#include "legal_values.h"
#include "stop_request.h"

namespace lamap::app
{
namespace
{
struct Arguments
{
  tools::BuildOptions build;
  std::string sensorOrigin;
  bool allowTruncated = false;
  bool json = false;
};

int build(Arguments arguments)
{
  if (!arguments.sensorOrigin.empty())
  {
    const auto origin = tools::parsePoint(arguments.sensorOrigin);
    arguments.build.inputs.sensorOrigin = {origin.x, origin.y, origin.z};
  }
  catchStopSignals();
  arguments.build.inputs.shouldStop = stopRequested;

  tools::BuildReport report;
  {
    tools::ProgressBar bar(std::cerr, isatty(STDERR_FILENO) != 0);
    report =
        tools::buildMap(arguments.build, [&](const tools::BuildProgress& progress) { bar.show(progress); });
  }
  if (arguments.json)
    std::cout << tools::reportJson(report).dump(2) << "\n";
  else
    tools::printReport(report, std::cout);
  if (report.stopped)
  {
    std::cerr << "lamap: stopped by the user"
              << (report.saved ? "; the map so far is saved to " + report.outPath : "") << "\n";
    return kStopped;
  }
  if (!report.damaged()) return 0;
  std::cerr << "lamap: an input was cut short or is damaged; what could be read is saved to "
            << report.outPath << "\n";
  return arguments.allowTruncated ? 0 : kFailed;
}
}  // namespace

void addBuild(CLI::App& app, Action& action)
{
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("build", "Make a map from logs, or go on with a saved one");
  tools::BuildOptions& options = arguments->build;
  command
      ->add_option(
          "-i,--input", options.inputs.paths,
          "Logs: .rawlog, .simplemap[.gz], .pcd or a folder of them, .graph; one named twice is used twice")
      ->required();
  command->add_option("-m,--map", options.map.mapName,
                      "Kind of map: bgkMap, or one of MRPT's own, e.g. octoMap");
  command->add_option("-c,--config", options.map.configPath,
                      ".ini file with [map] and [map_<kind>_00_...]; without -m, the map that it counts");
  command->add_option("-o,--output", options.outPath, "Where to save: .lamap.gz; with -m octoMap also .ot")
      ->required();
  command->add_option("-s,--set", options.map.settings,
                      "section.key=value over what the file says, e.g. insertOpts.maxRange=30");
  command->add_option("--onto", options.ontoPath, "Go on with this saved map; its options hold");
  command->add_option(
      "--poses", options.inputs.posesPath,
      "Poses in place of the log's (TUM format or MRPT's path text); for PCD files one a file");
  command->add_option("--sensor-origin", arguments->sensorOrigin,
                      "x,y,z of the sensor in the frame of a PCD file's VIEWPOINT [m]");
  command->add_flag("--static", options.inputs.standingStill,
                    "For rawlogs: the robot stood at the origin all the time");
  command->add_option("--threads", options.threads, "How many threads; 0: as many as the machine has")
      ->check(wholeNumber(0, kMostThreads));
  command->add_flag("--allow-truncated", arguments->allowTruncated, "A log that was cut short is no failure");
  command->add_flag("--json", arguments->json, "The closing report as JSON");
  command->callback([&action, arguments] { action = [arguments] { return build(*arguments); }; });
}

}  // namespace lamap::app
