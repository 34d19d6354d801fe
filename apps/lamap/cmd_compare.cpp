#include <lamap_tools/commands/compare.h>
#include <lamap_tools/files/output_paths.h>

#include "command_line.h"

namespace lamap::app
{
namespace
{
struct CompareArguments
{
  tools::CompareOptions compare;
  LogArguments log;
  ScoreArguments scores;
  bool json = false;
};

void describe(CLI::App& command, CompareArguments& arguments)
{
  tools::CompareOptions& options = arguments.compare;
  command.add_option("-i,--input", options.inputs.paths, "Logs, as of `lamap build`")->required();
  command.add_option(
      "-m,--map", options.maps,
      "Kind of map, with settings of its own and a label: -m bgkMap -m 'the thesis: bgkMap "
      "creationOpts.preset=thesis'; "
      "default: those that -c counts, else bgkMap, overlappingHilbertMap, hilbertMap, octoMap");
  command.add_option("-c,--config", options.configPath, ".ini file for all maps, as of `lamap build`");
  command.add_option("-s,--set", options.settings, "section.key=value for all maps");
  command.add_option("-o,--output", options.pagePath, "A page with pictures side by side, .html");
  command.add_option("--table", options.tablePath, "The table in a file: .csv or .md");
  auto* truth =
      command.add_option("--truth", options.truthPath, "Score against this truth, as of `lamap eval`");
  command
      .add_option("--surface", options.surfacePath,
                  "Points on surfaces, to which distances are measured, as of `lamap eval`")
      ->needs(truth);
  auto* every = command
                    .add_option("--held-out", options.heldOutEvery,
                                "No truth: keep every Nth scan from the maps, and score what those show")
                    ->check(wholeNumber(2, kMostEvery))
                    ->excludes(truth);
  command
      .add_option("--max-range", options.maxRange_m,
                  "Rays of the scans held out count up to here [m]; default: as far as any map inserts them")
      ->check(lengthAboveZero())
      ->needs(every);
  addScoreOptions(command, arguments.scores);
  addLogOptions(command, arguments.log, options.inputs, options.threads);
  command.add_flag("--json", arguments.json, "The table as JSON");
}

void check(const CLI::App& command, const CompareArguments& arguments)
{
  if (!arguments.compare.truthPath.empty() || arguments.compare.heldOutEvery > 0) return;
  if (!arguments.scores.roc.empty() || !arguments.scores.calibration.empty())
    throw CLI::ValidationError("compare", "--roc and --calibration need --truth FILE or --held-out N");
  if (command.count("--thresholds") > 0)
    throw CLI::ValidationError("compare", "--thresholds needs --truth FILE or --held-out N");
}

int compare(CompareArguments& arguments)
{
  tools::CompareOptions& options = arguments.compare;
  tools::requireOwnPlaces(
      {options.pagePath, options.tablePath, arguments.scores.roc, arguments.scores.calibration},
      pathsRead(options.inputs, {options.truthPath, options.surfacePath, options.configPath}));
  requireCurveFiles(arguments.scores);
  options.thresholds = arguments.scores.thresholds;
  prepareInputs(arguments.log, options.inputs);
  const tools::Comparison comparison =
      withProgressBar([&](const auto& progress) { return tools::compareMaps(options, progress); });
  if (comparison.stopped) return stoppedByUser("; nothing is scored or written");
  std::vector<tools::MapScores> scores;
  for (const tools::ComparedMap& map : comparison.maps)
    if (map.scores) scores.push_back(*map.scores);
  writeCurves(arguments.scores, scores);
  if (arguments.json)
    print(tools::comparisonJson(comparison));
  else
    tools::printComparison(comparison, results());
  return tellDamages(arguments.log.allowTruncated, comparison.inputs);
}
}  // namespace

void addCompare(CLI::App& app, Action& action)
{
  addCommand<CompareArguments, compare>(
      app, action, "compare",
      "Build several maps of one log: their quality, time and memory in one table, and pictures", describe,
      check);
}

}  // namespace lamap::app
