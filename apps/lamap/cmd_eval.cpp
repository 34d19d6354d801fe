#include <lamap_tools/cells/truth.h>
#include <lamap_tools/commands/held_out.h>
#include <lamap_tools/files/file_output.h>
#include <lamap_tools/files/output_paths.h>
#include <lamap_tools/report/counted.h>
#include <lamap_tools/scores/score_report.h>

#include "command_line.h"

namespace lamap::app
{
namespace
{
using Json = nlohmann::ordered_json;

struct EvalArguments
{
  std::vector<std::string> maps;
  std::string truth;
  std::string surface;
  tools::HeldOutOptions heldOut;
  LogArguments log;
  ScoreArguments scores;
  bool json = false;
};

void describe(CLI::App& command, EvalArguments& arguments)
{
  auto* maps = command.add_option("maps", arguments.maps,
                                  "Saved maps (.lamap.gz), or OctoMap's .ot or .bt: one table for all");
  auto* truth =
      command.add_option("--truth", arguments.truth,
                         "CSV with x,y,z,label (cell centres; 1 occupied, 0 free), a .bt, or any other map");
  truth->needs(maps);
  maps->needs(truth);
  command
      .add_option(
          "--surface", arguments.surface,
          "CSV with x,y,z of points on surfaces, to which distances are measured; default: the centres "
          "of the truth's occupied cells")
      ->needs(truth);

  tools::HeldOutOptions& options = arguments.heldOut;
  auto* every = command.add_option("--held-out", options.every,
                                   "No truth: build from all scans but every Nth, and score what those show");
  every->check(wholeNumber(2, kMostEvery))->excludes(truth);
  auto* input = command.add_option("-i,--input", options.inputs.paths, "Logs, as of `lamap build`");
  every->needs(input);
  std::vector<CLI::Option*> onlyHeldOut{
      input, command.add_option("-m,--map", options.map.mapName, "Kind of map, as of `lamap build`"),
      command.add_option("-c,--config", options.map.configPath, ".ini file, as of `lamap build`"),
      command.add_option("-s,--set", options.map.settings, "section.key=value over what the file says"),
      command
          .add_option("--max-range", options.maxRange_m,
                      "Rays of the scans held out count up to here [m]; default: as the map inserts them")
          ->check(lengthAboveZero())};
  for (CLI::Option* option : addLogOptions(command, arguments.log, options.inputs, options.threads))
    onlyHeldOut.push_back(option);
  for (CLI::Option* option : onlyHeldOut) option->needs(every)->group("With --held-out");
  addScoreOptions(command, arguments.scores);
  command.add_flag("--json", arguments.json, "The scores as JSON");
}

void check(const CLI::App& command, const EvalArguments& arguments)
{
  if (arguments.truth.empty() && command.count("--held-out") == 0)
    throw CLI::ValidationError("eval", "give maps and --truth FILE, or --held-out N, -i INPUT and -m MAP");
}

/// @param what  was scored by, for JSON
void printMaps(Json what, const std::vector<tools::MapScores>& maps)
{
  what["scoring"] = tools::scoringJson();
  what["maps"] = Json::array();
  for (const tools::MapScores& map : maps) what["maps"].push_back(tools::scoresJson(map));
  print(what);
}

int againstTruth(const EvalArguments& arguments)
{
  tools::Truth truth = tools::readTruth(arguments.truth);
  if (!arguments.surface.empty()) tools::readSurface(arguments.surface, truth);
  std::vector<tools::MapScores> maps;
  {
    tools::ProgressBar bar = makeProgressBar("cell");
    for (const std::string& path : arguments.maps)
    {
      const size_t before = truth.cells.size() * maps.size();
      const auto show = [&](size_t done, size_t) {
        bar.show({before + done, truth.cells.size() * arguments.maps.size(), path});
      };
      maps.push_back(
          tools::scoreMap(tools::openMapOfCells(path), path, truth, arguments.scores.thresholds, show));
    }
  }
  writeCurves(arguments.scores, maps);
  const size_t occupied = truth.occupiedCount();
  if (arguments.json)
  {
    Json json;
    json["truth"] = {{"path", truth.name},
                     {"cells", truth.cells.size()},
                     {"occupied", occupied},
                     {"free", truth.cells.size() - occupied}};
    if (truth.spacing_m) json["truth"]["resolution"] = *truth.spacing_m;
    printMaps(json, maps);
    return 0;
  }
  results() << truth.name << ": " << tools::counted(truth.cells.size(), "cell") << ", " << occupied
            << " of them occupied\n";
  tools::printScores(maps, "cells of the truth", results());
  return 0;
}

int againstHeldOut(EvalArguments& arguments)
{
  arguments.heldOut.thresholds = arguments.scores.thresholds;
  prepareInputs(arguments.log, arguments.heldOut.inputs);
  const tools::HeldOutReport report =
      withProgressBar([&](const auto& progress) { return tools::scoreHeldOut(arguments.heldOut, progress); });
  if (report.stopped) return stoppedByUser("; nothing is scored");
  writeCurves(arguments.scores, {report.scores});
  if (arguments.json)
  {
    Json json{{"heldOut",
               {{"scans", report.heldOut},
                {"scansInMap", report.scans.usedCount()},
                {"maxRange", report.maxRange_m},
                {"inputNotes", report.inputNotes}}}};
    json["scoresOfReturned"] = tools::scoresJson(report.scoresOfReturned);
    printMaps(json, {report.scores});
  }
  else
  {
    results() << tools::counted(report.heldOut, "scan") << " held out, " << report.scans.usedCount()
              << " in the map; rays up to "
              << (report.maxRange_m > 0 ? tools::shortest(report.maxRange_m) + " m"
                                        : "the range that the scans state")
              << " are scored\n";
    tools::printLeftOut(report.scans, results());
    for (const std::string& note : report.inputNotes) results() << "  " << note << "\n";
    tools::printScores({report.scores}, "cells shown by the scans held out", results());
    results() << "\nwithout the rays that had no return:\n";
    tools::printScores({report.scoresOfReturned}, "cells shown by the rays that returned", results());
  }
  return tellDamages(arguments.log.allowTruncated, report.inputs);
}

int evaluate(EvalArguments& arguments)
{
  std::vector<std::string> read = arguments.maps;
  read.insert(read.end(), {arguments.truth, arguments.surface, arguments.heldOut.map.configPath});
  tools::requireOwnPlaces(arguments.scores.paths(), pathsRead(arguments.heldOut.inputs, read));
  requireCurveFiles(arguments.scores);
  return arguments.truth.empty() ? againstHeldOut(arguments) : againstTruth(arguments);
}
}  // namespace

void addEval(CLI::App& app, Action& action)
{
  addCommand<EvalArguments, evaluate>(app, action, "eval",
                                      "Score maps against the truth, or a map against scans left out of it",
                                      describe, check);
}

}  // namespace lamap::app
