#include "commands.h"

#include <lamap_tools/commands/compare.h>
#include <lamap_tools/commands/progress_bar.h>
#include <lamap_tools/files/output_paths.h>
#include <lamap_tools/scores/score_report.h>

#include <iostream>
#include <memory>

#include "legal_values.h"
#include "log_arguments.h"

namespace lamap::app
{
namespace
{
struct CompareArguments
{
  tools::CompareOptions compare;
  LogArguments log;
  std::string roc;
  std::string calibration;
  bool json = false;
};

void writeCurves(const CompareArguments& arguments, const tools::Comparison& comparison)
{
  std::vector<tools::MapScores> scores;
  for (const tools::ComparedMap& map : comparison.maps)
    if (map.scores) scores.push_back(*map.scores);
  if (!arguments.roc.empty()) tools::writeRocCurves(scores, arguments.roc);
  if (!arguments.calibration.empty()) tools::writeCalibration(scores, arguments.calibration);
}

int compare(CompareArguments arguments)
{
  const tools::CompareOptions& options = arguments.compare;
  tools::requireOwnPlaces({options.pagePath, options.tablePath, arguments.roc, arguments.calibration},
                          pathsRead(options.inputs, {options.truthPath, options.configPath}));
  for (const std::string& path : {arguments.roc, arguments.calibration})
    if (!path.empty()) tools::requireCurveFile(path);
  prepareInputs(arguments.log, arguments.compare.inputs);
  tools::Comparison comparison;
  {
    tools::ProgressBar bar(std::cerr, isTerminal());
    comparison = tools::compareMaps(arguments.compare,
                                    [&](const tools::BuildProgress& progress) { bar.show(progress); });
  }
  if (comparison.stopped)
  {
    std::cerr << "lamap: stopped by the user; nothing is scored or written\n";
    return kStopped;
  }
  writeCurves(arguments, comparison);
  if (arguments.json)
    std::cout << tools::comparisonJson(comparison).dump(2) << "\n";
  else
    tools::printComparison(comparison, std::cout);
  return tellDamages(arguments.log, comparison.inputs);
}

void describeScores(CLI::App& command, CompareArguments& arguments)
{
  tools::CompareOptions& options = arguments.compare;
  auto* truth =
      command.add_option("--truth", options.truthPath, "Score against this truth, as of `lamap eval`");
  auto* every =
      command
          .add_option("--held-out", options.heldOutEvery,
                      "No truth: keep every so many-th scan from the maps, and score what those show")
          ->check(wholeNumber(2, 1000000000))
          ->excludes(truth);
  command
      .add_option("--max-range", options.maxRange_m,
                  "Rays of the scans held out count up to here [m]; default: as far as any map inserts them")
      ->check(CLI::PositiveNumber)
      ->needs(every);
  command
      .add_option("--thresholds", options.thresholds,
                  "Probabilities at which precision and recall are given, e.g. 0.5,0.7")
      ->delimiter(',')
      ->check(probability())
      ->capture_default_str();
  command.add_option("--roc", arguments.roc, "Write the ROC curves: .csv or .png");
  command.add_option("--calibration", arguments.calibration,
                     "Write how often cells of each probability are occupied: .csv or .png");
}
}  // namespace

void addCompare(CLI::App& app, Action& action)
{
  auto arguments = std::make_shared<CompareArguments>();
  tools::CompareOptions& options = arguments->compare;
  CLI::App* command = app.add_subcommand(
      "compare", "Build several maps of one log: their quality, time and memory in one table, and pictures");
  command->add_option("-i,--input", options.inputs.paths, "Logs, as of `lamap build`")->required();
  command->add_option(
      "-m,--map", options.maps,
      "Kind of map, with settings of its own and a label: -m bgkMap -m 'the thesis: bgkMap "
      "creationOpts.preset=thesis'; "
      "default: those that -c counts, else bgkMap, overlappingHilbertMap, hilbertMap, octoMap");
  command->add_option("-c,--config", options.configPath, ".ini file for all maps, as of `lamap build`");
  command->add_option("-s,--set", options.settings, "section.key=value for all maps");
  command->add_option("-o,--output", options.pagePath, "A page with pictures side by side, .html");
  command->add_option("--table", options.tablePath, "The table in a file: .csv or .md");
  describeScores(*command, *arguments);
  addLogOptions(*command, arguments->log, options.inputs, options.threads);
  command->add_flag("--json", arguments->json, "The table as JSON");
  command->callback(
      [&action, arguments, command]
      {
        const bool scored = !arguments->compare.truthPath.empty() || arguments->compare.heldOutEvery > 0;
        if (!scored && !(arguments->roc.empty() && arguments->calibration.empty()))
          throw CLI::ValidationError("compare", "--roc and --calibration need --truth FILE or --held-out N");
        if (!scored && command->count("--thresholds") > 0)
          throw CLI::ValidationError("compare", "--thresholds needs --truth FILE or --held-out N");
        action = [arguments] { return compare(*arguments); };
      });
}

}  // namespace lamap::app
