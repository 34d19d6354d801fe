#include "commands.h"

#include <lamap_tools/commands/held_out.h>
#include <lamap_tools/commands/progress_bar.h>
#include <lamap_tools/files/file_output.h>
#include <lamap_tools/files/output_paths.h>
#include <lamap_tools/files/usage_error.h>
#include <lamap_tools/scores/score_report.h>

#include <iostream>
#include <memory>

#include "legal_values.h"
#include "log_arguments.h"

namespace lamap::app
{
namespace
{
struct EvalArguments
{
  std::vector<std::string> maps;
  std::string truth;
  tools::HeldOutOptions heldOut;
  LogArguments log;
  std::string roc;
  std::string calibration;
  std::vector<double> thresholds{0.7};
  bool json = false;
};

void writeCurves(const EvalArguments& arguments, const std::vector<tools::MapScores>& maps)
{
  if (!arguments.roc.empty()) tools::writeRocCurves(maps, arguments.roc);
  if (!arguments.calibration.empty()) tools::writeCalibration(maps, arguments.calibration);
}

nlohmann::ordered_json jsonOfMaps(const std::vector<tools::MapScores>& maps)
{
  auto list = nlohmann::ordered_json::array();
  for (const tools::MapScores& map : maps) list.push_back(tools::scoresJson(map));
  return list;
}

int againstTruth(const EvalArguments& arguments)
{
  const tools::Truth truth = tools::readTruth(arguments.truth);
  std::vector<tools::MapScores> maps;
  {
    tools::ProgressBar bar(std::cerr, isTerminal(), "cells");
    const size_t expected = truth.cells.size() * arguments.maps.size();
    for (const std::string& path : arguments.maps)
    {
      const size_t before = truth.cells.size() * maps.size();
      maps.push_back(tools::scoreMap(tools::openMap(path), path, truth, arguments.thresholds,
                                     [&](size_t done, size_t) {
                                       bar.show({before + done, expected, path});
                                     }));
    }
  }
  writeCurves(arguments, maps);
  const size_t occupied = truth.occupiedCount();
  if (arguments.json)
  {
    nlohmann::ordered_json json;
    json["truth"] = {{"path", truth.name},
                     {"cells", truth.cells.size()},
                     {"occupied", occupied},
                     {"free", truth.cells.size() - occupied}};
    if (truth.spacing_m) json["truth"]["resolution"] = *truth.spacing_m;
    json["scoring"] = tools::scoringJson();
    json["maps"] = jsonOfMaps(maps);
    std::cout << json.dump(2) << "\n";
    return 0;
  }
  std::cout << truth.name << ": " << truth.cells.size() << " cells, " << occupied << " of them occupied\n";
  tools::printScores(maps, "cells of the truth", std::cout);
  return 0;
}

void printHeldOut(const tools::HeldOutReport& report)
{
  std::cout << report.heldOut << " scans held out, " << report.scans.usedCount() << " in the map; rays up to "
            << (report.maxRange_m > 0 ? tools::shortest(report.maxRange_m) + " m"
                                      : std::string("the range that the scans state"))
            << " are scored\n";
  for (const auto& [what, count] : report.scans.leftOut)
    std::cout << "  left out: " << count << " " << what.first << ": " << what.second << "\n";
  tools::printScores({report.scores}, "cells shown by the scans held out", std::cout);
}

nlohmann::ordered_json jsonOf(const tools::HeldOutReport& report)
{
  nlohmann::ordered_json json;
  json["heldOut"] = {
      {"scans", report.heldOut}, {"scansInMap", report.scans.usedCount()}, {"maxRange", report.maxRange_m}};
  json["scoring"] = tools::scoringJson();
  json["maps"] = jsonOfMaps({report.scores});
  return json;
}

int againstHeldOut(EvalArguments arguments)
{
  arguments.heldOut.thresholds = arguments.thresholds;
  prepareInputs(arguments.log, arguments.heldOut.inputs);
  tools::HeldOutReport report;
  {
    tools::ProgressBar bar(std::cerr, isTerminal());
    report = tools::scoreHeldOut(arguments.heldOut,
                                 [&](const tools::BuildProgress& progress) { bar.show(progress); });
  }
  if (report.stopped)
  {
    std::cerr << "lamap: stopped by the user; nothing is scored\n";
    return kStopped;
  }
  writeCurves(arguments, {report.scores});
  if (arguments.json)
    std::cout << jsonOf(report).dump(2) << "\n";
  else
    printHeldOut(report);
  return tellDamages(arguments.log, report.inputs);
}

int evaluate(const EvalArguments& arguments)
{
  std::vector<std::string> read = arguments.maps;
  read.insert(read.end(), {arguments.truth, arguments.heldOut.map.configPath});
  tools::requireOwnPlaces({arguments.roc, arguments.calibration}, pathsRead(arguments.heldOut.inputs, read));
  for (const std::string& path : {arguments.roc, arguments.calibration})
    if (!path.empty()) tools::requireCurveFile(path);
  return arguments.truth.empty() ? againstHeldOut(arguments) : againstTruth(arguments);
}

void describeHeldOut(CLI::App& command, EvalArguments& arguments)
{
  tools::HeldOutOptions& options = arguments.heldOut;
  auto* every =
      command.add_option("--held-out", options.every,
                         "No truth: build from all scans but every so many-th, and score what those show");
  every->check(wholeNumber(2, 1000000000));
  const auto onlyHeldOut = [&](CLI::Option* option) { option->needs(every)->group("With --held-out"); };
  auto* input = command.add_option("-i,--input", options.inputs.paths, "Logs, as of `lamap build`");
  every->needs(input);
  onlyHeldOut(input);
  onlyHeldOut(command.add_option("-m,--map", options.map.mapName, "Kind of map, as of `lamap build`"));
  onlyHeldOut(command.add_option("-c,--config", options.map.configPath, ".ini file, as of `lamap build`"));
  onlyHeldOut(
      command.add_option("-s,--set", options.map.settings, "section.key=value over what the file says"));
  onlyHeldOut(
      command
          .add_option("--max-range", options.maxRange_m,
                      "Rays of the scans held out count up to here [m]; default: as the map inserts them")
          ->check(CLI::PositiveNumber));
  for (CLI::Option* option : addLogOptions(command, arguments.log, options.inputs, options.threads))
    onlyHeldOut(option);
}
}  // namespace

void addEval(CLI::App& app, Action& action)
{
  auto arguments = std::make_shared<EvalArguments>();
  CLI::App* command =
      app.add_subcommand("eval", "Score maps against the truth, or a map against scans kept from it");
  auto* maps = command->add_option("maps", arguments->maps,
                                   "Saved maps (.lamap.gz), or OctoMap's .ot or .bt: one table for all");
  auto* truth =
      command->add_option("--truth", arguments->truth,
                          "CSV with x,y,z,label (cell centres; 1 occupied, 0 free), a .bt, or any other map");
  truth->needs(maps);
  maps->needs(truth);
  describeHeldOut(*command, *arguments);
  truth->excludes("--held-out");
  command->add_option("--roc", arguments->roc, "Write the ROC curves: .csv or .png");
  command->add_option("--calibration", arguments->calibration,
                      "Write how often cells of each probability are occupied: .csv or .png");
  command
      ->add_option("--thresholds", arguments->thresholds,
                   "Probabilities at which precision and recall are given, e.g. 0.5,0.7")
      ->delimiter(',')
      ->check(probability())
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "The scores as JSON");
  command->callback(
      [&action, arguments, command]
      {
        if (arguments->truth.empty() && command->count("--held-out") == 0)
          throw CLI::ValidationError("eval",
                                     "give maps and --truth FILE, or --held-out N, -i INPUT and -m MAP");
        action = [arguments] { return evaluate(*arguments); };
      });
}

}  // namespace lamap::app
