#include <lamap_tools/commands/tune.h>
#include <lamap_tools/files/output_paths.h>

#include "command_line.h"

namespace lamap::app
{
namespace
{
struct TuneArguments
{
  tools::TuneOptions tune;
  LogArguments log;
  bool json = false;
};

void describe(CLI::App& command, TuneArguments& arguments)
{
  tools::TuneOptions& options = arguments.tune;
  command.add_option("-i,--input", options.inputs.paths, "Logs, as of `lamap build`")->required();
  command.add_option("-m,--map", options.map.mapName, "Kind of map, as of `lamap build`");
  command.add_option("-c,--config", options.map.configPath, ".ini file to start from, as of `lamap build`");
  // tuneMap() splits the values at their commas.
  command
      .add_option(
          "-s,--set", options.map.settings,
          "section.key=value fixes an option; section.key=a,b,c searches it: all combinations are tried")
      ->required();
  command.add_option("-o,--output", options.outPath, "Where to save the best settings, an .ini file");
  auto* every = command
                    .add_option("--held-out", options.every,
                                "Hold out every Nth scan of each sensor, and score the maps by those")
                    ->check(wholeNumber(2, kMostEvery))
                    ->capture_default_str();
  command
      .add_flag("--prequential", options.prequential,
                "Instead, score each map by every scan before that scan is inserted")
      ->excludes(every);
  command.add_flag("--all-rays", options.rankByAllRays,
                   "Rank by all rays of the scored scans; default: by those that returned");
  command
      .add_option("--max-range", options.maxRange_m,
                  "Score rays up to this range [m]; default: as far as the map inserts them")
      ->check(lengthAboveZero());
  addLogOptions(command, arguments.log, options.inputs, options.threads);
  command.add_flag("--json", arguments.json, "Print the scores as JSON");
}

int tune(TuneArguments& arguments)
{
  tools::requireOwnPlaces({arguments.tune.outPath},
                          pathsRead(arguments.tune.inputs, {arguments.tune.map.configPath}));
  prepareInputs(arguments.log, arguments.tune.inputs);
  const tools::TuneReport report =
      withProgressBar([&](const auto& progress) { return tools::tuneMap(arguments.tune, progress); });
  if (report.stopped) return stoppedByUser("; nothing is scored or saved");
  if (arguments.json)
    print(tools::tuningJson(report));
  else
    tools::printTuning(report, results());
  return tellDamages(arguments.log.allowTruncated, report.inputs);
}
}  // namespace

void addTune(CLI::App& app, Action& action)
{
  addCommand<TuneArguments, tune>(
      app, action, "tune", "Search a map's options by how well scans of a log predict each other", describe);
}

}  // namespace lamap::app
