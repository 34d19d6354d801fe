#include "commands.h"

#include <lamap_tools/commands/progress_bar.h>
#include <lamap_tools/commands/tune.h>
#include <lamap_tools/files/output_paths.h>

#include <iostream>
#include <memory>

#include "legal_values.h"
#include "log_arguments.h"

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

int tune(TuneArguments arguments)
{
  tools::requireOwnPlaces({arguments.tune.outPath},
                          pathsRead(arguments.tune.inputs, {arguments.tune.map.configPath}));
  prepareInputs(arguments.log, arguments.tune.inputs);
  tools::TuneReport report;
  {
    tools::ProgressBar bar(std::cerr, isTerminal());
    report =
        tools::tuneMap(arguments.tune, [&](const tools::BuildProgress& progress) { bar.show(progress); });
  }
  if (report.stopped)
  {
    std::cerr << "lamap: stopped by the user; nothing is scored or saved\n";
    return kStopped;
  }
  if (arguments.json)
    std::cout << tools::tuningJson(report).dump(2) << "\n";
  else
    tools::printTuning(report, std::cout);
  return tellDamages(arguments.log, report.inputs);
}
}  // namespace

void addTune(CLI::App& app, Action& action)
{
  auto arguments = std::make_shared<TuneArguments>();
  tools::TuneOptions& options = arguments->tune;
  CLI::App* command =
      app.add_subcommand("tune", "Search a map's options by how well scans of a log predict each other");
  command->add_option("-i,--input", options.inputs.paths, "Logs, as of `lamap build`")->required();
  command->add_option("-m,--map", options.map.mapName, "Kind of map, as of `lamap build`");
  command->add_option("-c,--config", options.map.configPath, ".ini file to start from, as of `lamap build`");
  // Values are separated by commas, which are the search's own business.
  command
      ->add_option("-s,--set", options.map.settings,
                   "section.key=value, fixed; or section.key=a,b,c, searched: all combinations are tried")
      ->required();
  command->add_option("-o,--output", options.outPath, "Where to save the best settings, an .ini file");
  auto* every = command
                    ->add_option("--held-out", options.every,
                                 "Every so many-th scan of each sensor is kept from the maps and scored")
                    ->check(wholeNumber(2, 1000000000))
                    ->capture_default_str();
  command
      ->add_flag("--prequential", options.prequential,
                 "Instead: every scan is scored by what the map knows before it gets the scan")
      ->excludes(every);
  command
      ->add_option("--max-range", options.maxRange_m,
                   "Rays are scored up to here [m]; default: as far as the map inserts them")
      ->check(CLI::PositiveNumber);
  addLogOptions(*command, arguments->log, options.inputs, options.threads);
  command->add_flag("--json", arguments->json, "The scores as JSON");
  command->callback([&action, arguments] { action = [arguments] { return tune(*arguments); }; });
}

}  // namespace lamap::app
