#include <lamap_tools/commands/compare.h>

#include <lamap_core/training/scan_labels.h>
#include <lamap_mrpt/compat/mrpt_compat.h>
#include <lamap_mrpt/files/atomic_file.h>
#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <lamap_tools/cells/truth.h>
#include <lamap_tools/commands/comparison_page.h>
#include <lamap_tools/commands/scored_map.h>
#include <lamap_tools/files/file_names.h>
#include <lamap_tools/files/file_output.h>
#include <lamap_tools/files/usage_error.h>
#include <lamap_tools/report/counted.h>
#include <lamap_tools/scores/held_out_cells.h>
#include <lamap_tools/scores/score_report.h>
#include <mrpt/core/format.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/maps/COctoMap.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <ostream>
#include <sstream>
#include <stdexcept>

namespace lamap::tools
{
namespace
{
/// "label: bgkMap a.b=c d.e=f" taken apart.
struct NamedRequest
{
  std::string name;
  MapRequest request;
};

/// Whether there is a colon that is not one of the two between a namespace and a class.
bool hasLoneColon(const std::string& name)
{
  for (size_t at = name.find(':'); at != std::string::npos; at = name.find(':', at + 2))
    if (name.compare(at, 2, "::") != 0) return true;
  return false;
}

NamedRequest requestOf(const std::string& text, const CompareOptions& options)
{
  const size_t colon = text.find(": ");
  const bool labelled = colon != std::string::npos;
  NamedRequest named{labelled ? text.substr(0, colon) : text, {"", options.configPath, options.settings}};
  std::istringstream words(labelled ? text.substr(colon + 2) : text);
  words >> named.request.mapName;
  if (labelled && named.name.empty()) throw UsageError("-m '" + text + "': the label is empty");
  if (named.request.mapName.empty()) throw UsageError("-m '" + text + "': expected the name of a map");
  if (hasLoneColon(named.request.mapName))
    throw UsageError("-m '" + text + "': expected 'LABEL: MAP', with a space after the colon");
  for (std::string word; words >> word;) named.request.ownSettings.push_back(word);
  return named;
}

std::vector<std::string> namesOfMaps(const CompareOptions& options)
{
  if (!options.maps.empty()) return options.maps;
  if (options.configPath.empty()) return {"bgkMap", "overlappingHilbertMap", "hilbertMap", "octoMap"};
  std::vector<std::string> counted = mapsCountedIn(options.configPath);
  if (counted.empty()) throw std::runtime_error(options.configPath + ": asks for no map in section [map]");
  return counted;
}

std::optional<uint64_t> memoryOf(const mrpt::maps::CMetricMap& map)
{
  if (const auto* learned = dynamic_cast<const CLearnedMap*>(&map)) return learned->memoryBytes();
  if (const auto* octo = dynamic_cast<const mrpt::maps::COctoMap*>(&map)) return octo->memoryUsage();
  if (const auto* grid = dynamic_cast<const mrpt::maps::COccupancyGridMap2D*>(&map))
    return uint64_t{grid->getSizeX()} * grid->getSizeY() * sizeof(mrpt::maps::COccupancyGridMap2D::cellType);
  return std::nullopt;
}

/// @throws as readMapDefinition(), naming which of the maps it is
MapDefinition definitionOf(const NamedRequest& named)
{
  try
  {
    return readMapDefinition(named.request);
  }
  catch (const UsageError& error)
  {
    const bool shared = !named.request.settings.empty() && named.request.ownSettings.empty();
    throw UsageError(
        "-m '" + named.name + "': " + error.what() +
        (shared ? "; a setting of one map only stands after its name: -m 'MAP section.key=value'" : ""));
  }
}

/// A map that is being built, and what scans kept from it show of its own kind of cells. Belongs to one
/// thread.
class Builder : public ScoredMap
{
 public:
  Builder(const NamedRequest& named, const CompareOptions& options)
      : ScoredMap(named.name, definitionOf(named), options.threads, options.maxRange_m, "compare"),
        shown(rules.resolution_m)
  {
  }

  void insert(const ScanItem& item)
  {
    const ScanItem own = ownCopyOf(item);
    if (const auto* observed = std::get_if<ObservedScan>(&own)) observed->observation->load();
    takeTime([&] { inserter->insert(own); });
  }

  [[nodiscard]] ComparedMap finish()
  {
    takeTime([&] { (void)cells->estimateAt({0, 0, 0}); });
    return {name, map, cells, inserter->tally(), insertion_s_, memoryOf(*map), std::nullopt, std::nullopt};
  }

  void score(ComparedMap& compared, const std::vector<double>& thresholds)
  {
    if (shown.empty())
      throw std::runtime_error("the scans that were held out show neither hits nor free space");
    compared.scores = heldOutScores(ScoredRays::All, shown, thresholds);
    compared.scoresOfReturned = heldOutScores(ScoredRays::Returned, shown, thresholds);
  }

  HeldOutCells shown;

 private:
  template <class Act>
  void takeTime(const Act& act)
  {
    const auto begin = std::chrono::steady_clock::now();
    act();
    insertion_s_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }

  double insertion_s_ = 0;
};

/// Rays of the scans held out count equally far for all maps.
void scoreEquallyFar(const CompareOptions& options, std::vector<Builder>& builders)
{
  double farthest_m = options.maxRange_m;
  if (!(farthest_m > 0))
    for (const Builder& builder : builders) farthest_m = std::max(farthest_m, builder.rules.maxRange_m);
  for (Builder& builder : builders) builder.rules.maxRange_m = farthest_m;
}

bool haveSameCells(const std::vector<Builder>& builders)
{
  const LabelRules& first = builders.front().rules;
  return std::all_of(
      builders.begin(), builders.end(),
      [&](const Builder& builder)
      { return builder.rules.resolution_m == first.resolution_m && builder.rules.layer == first.layer; });
}

/// @throws UsageError unless the path is empty or ends so; std::runtime_error if nothing can be written there
void requireOutput(const std::string& path, const std::vector<std::string>& extensions,
                   const std::string& why)
{
  if (path.empty()) return;
  if (std::find(extensions.begin(), extensions.end(), extensionOf(path)) == extensions.end())
    throw UsageError(path + ": " + why);
  const AtomicFile placeIsWritable(path);
}

void requireLegalOptions(const CompareOptions& options)
{
  if (!options.truthPath.empty() && options.heldOutEvery > 0)
    throw UsageError("--truth and --held-out: maps are scored by one of them");
  requireLegalScoring(options.heldOutEvery == 0 ? 2 : options.heldOutEvery, options.maxRange_m);
  if (options.maxRange_m > 0 && options.heldOutEvery == 0)
    throw UsageError("--max-range: is for --held-out only; how far maps insert is their own option");
  requireOutput(options.pagePath, {".html"}, "the page is written as .html");
  requireOutput(options.tablePath, {".csv", ".md"}, "the table is written as .csv or .md");
}

/// Maps that are compared, and those that are not.
struct Contestants
{
  std::vector<Builder> builders;
  std::vector<RefusedMap> refused;
};

/// Why the map cannot be made so, without its name.
std::string reasonOf(const NamedRequest& named)
{
  try
  {
    (void)createMap(readMapDefinition(named.request));
    return "";
  }
  catch (const std::exception& error)
  {
    return compat::messageOf(error);
  }
}

/// Whether the map could be made, were it not for the settings of all maps.
bool isLegalAlone(NamedRequest named)
{
  named.request.settings.clear();
  return reasonOf(named).empty();
}

/// @throws UsageError if a map is asked for in vain, or no map takes the settings of all
Contestants contestantsFor(const CompareOptions& options)
{
  requireDifferentKeys(options.settings);
  Contestants all;
  std::exception_ptr first;  // of what a map refuses
  std::vector<std::string> names;
  for (const std::string& text : namesOfMaps(options))
  {
    const NamedRequest named = requestOf(text, options);
    if (std::find(names.begin(), names.end(), named.name) != names.end())
      throw UsageError("-m " + text + ": twice the same map, or the same label");
    names.push_back(named.name);
    try
    {
      all.builders.emplace_back(named, options);
    }
    catch (const std::exception&)
    {
      if (options.settings.empty() || !isLegalAlone(named)) throw;
      all.refused.push_back({named.name, reasonOf(named)});
      if (!first) first = std::current_exception();
    }
  }
  if (all.builders.empty()) std::rethrow_exception(first);
  return all;
}

/// Leaves out maps that took no scan. @throws std::runtime_error if there is no other
void leaveOutMapsWithoutScans(Contestants& all)
{
  std::vector<Builder> builders;
  for (Builder& builder : all.builders)
    if (builder.inserter->tally().usedCount() > 0)
      builders.push_back(std::move(builder));
    else
      all.refused.push_back(
          {builder.name, "not one scan that the map takes" + reasonsOf(builder.inserter->tally(), "; ")});
  all.builders = std::move(builders);
  if (all.builders.empty())
    throw std::runtime_error(all.refused.back().name + ": " + all.refused.back().reason);
}

void requireHeldOut(const HeldOutChoice& choice)
{
  if (choice.heldOut() == 0)
    throw std::runtime_error("only " + counted(choice.mostScans(), "usable scan") +
                             " of a sensor: none would be held out");
}

/// Scores each map by score(its number), and leaves out those that it throws for.
/// @throws std::runtime_error if it does for all
template <typename Score>
void scoreEach(Comparison& comparison, const Score& score)
{
  std::vector<ComparedMap> scored;
  for (size_t i = 0; i < comparison.maps.size(); ++i)
  {
    ComparedMap& map = comparison.maps[i];
    try
    {
      score(i, map);
      scored.push_back(std::move(map));
    }
    catch (const UsageError&)
    {
      throw;
    }
    catch (const std::runtime_error& error)
    {
      comparison.refused.push_back({map.name, error.what()});
    }
  }
  if (scored.empty()) throw std::runtime_error(comparison.refused.back().reason);
  comparison.maps = std::move(scored);
}

void scoreAll(Comparison& comparison, const CompareOptions& options, const std::optional<Truth>& truth,
              const std::optional<HeldOutChoice>& choice, std::vector<Builder>& builders)
{
  if (truth)
  {
    comparison.scoredBy = counted(truth->cells.size(), "cell") + " of " + truth->name;
    scoreEach(comparison,
              [&](size_t, ComparedMap& map) {
                map.scores = scoreMap({map.map, cellsOf(map.map), {}}, map.name, *truth, options.thresholds);
              });
  }
  if (!choice) return;
  comparison.scoredBy = "the cells shown by " + counted(choice->heldOut(), "scan") + " held out";
  scoreEach(comparison, [&](size_t i, ComparedMap& map) { builders[i].score(map, options.thresholds); });
  if (!haveSameCells(builders))
    comparison.notes.emplace_back(
        "the maps have cells of different sizes or layers: each is scored over its own");
}
}  // namespace

Comparison compareMaps(const CompareOptions& options, const ProgressSink& progress)
{
  requireLegalOptions(options);
  Contestants all = contestantsFor(options);
  std::optional<Truth> truth;
  if (!options.truthPath.empty()) truth = readTruth(options.truthPath);
  if (truth && !options.surfacePath.empty()) readSurface(options.surfacePath, *truth);
  std::optional<HeldOutChoice> choice;
  if (options.heldOutEvery > 0)
  {
    choice.emplace(options.heldOutEvery);
    scoreEquallyFar(options, all.builders);
  }
  const auto sources = openInputs(options.inputs);

  Comparison comparison;
  const auto take = [&](const ScanItem& item, const ScanSource& /*source*/)
  {
    const auto scan = choice ? scanOf(item) : std::nullopt;
    const bool heldOut = scan && choice->isHeldOut(item);
    for (Builder& builder : all.builders)
      if (heldOut)
        builder.shown.add(*scan, builder.rules);
      else
        builder.insert(item);
  };
  comparison.stopped = !visitScans(sources, options.inputs.shouldStop, progress, take);
  comparison.inputs = reportsOf(sources);
  comparison.inputNotes = allNotesOf(sources);
  if (comparison.stopped) return comparison;
  leaveOutMapsWithoutScans(all);
  if (choice) requireHeldOut(*choice);
  for (Builder& builder : all.builders) comparison.maps.push_back(builder.finish());
  comparison.refused = std::move(all.refused);
  scoreAll(comparison, options, truth, choice, all.builders);
  if (!options.tablePath.empty())
  {
    const bool markdown = extensionOf(options.tablePath) == ".md";
    const TextTable table = comparisonTable(comparison, markdown ? ForWhom::People : ForWhom::Programs);
    writeFileAtomically(options.tablePath, markdown ? markdownOf(table) : csvOf(table));
  }
  if (!options.pagePath.empty())
  {
    writeComparisonPage(comparison, truth ? &*truth : nullptr, options.pagePath);
    comparison.pagePath = options.pagePath;
  }
  return comparison;
}

namespace
{
/// In the order of the table's head.
template <class Number>
std::vector<std::string> geometryFields(const MapGeometry& shape, bool people, const Number& number)
{
  if (people)
    return {number(shape.f1),
            centimetreText(shape.meanDistance_m) + " / " + centimetreText(shape.distance95_m),
            percentText(shape.covered),
            number(shape.occupiedPerSurfaceCell),
            percentText(shape.surfaceCalledFree),
            percentText(shape.freeCalledFree)};
  return {number(shape.f1),
          number(shape.meanDistance_m),
          number(shape.distance95_m),
          number(shape.covered),
          number(shape.occupiedPerSurfaceCell),
          number(shape.surfaceCalledFree),
          number(shape.freeCalledFree)};
}
}  // namespace

TextTable comparisonTable(const Comparison& comparison, ForWhom forWhom)
{
  using Row = std::vector<std::string>;
  const bool people = forWhom == ForWhom::People;
  const bool scored = !comparison.scoredBy.empty();
  const bool heldOut = comparison.maps.front().scoresOfReturned.has_value();
  const auto append = [](Row& row, const Row& more) { row.insert(row.end(), more.begin(), more.end()); };
  const auto number = [&](const std::optional<double>& score) -> std::string
  {
    if (people) return numberText(score);
    return score ? shortest(*score) : "";
  };

  TextTable table;
  Row head{"map"};
  if (scored)
  {
    append(head, people ? Row{"AUC", "avg. precision", "log loss", "Brier", "calibration error (observed)",
                              "observed"}
                        : Row{"auc", "average_precision", "log_loss", "brier", "observed_calibration_error",
                              "observed_share"});
    for (const ThresholdScore& score : comparison.maps.front().scores->all.thresholds)
      append(head, people ? Row{mrpt::format("P / R, p >= %g", score.threshold)}
                          : Row{mrpt::format("precision_at_%g", score.threshold),
                                mrpt::format("recall_at_%g", score.threshold)});
    if (heldOut)
      append(head, people ? Row{"AUC, returns only", "log loss, returns only"}
                          : Row{"auc_of_returned", "log_loss_of_returned"});
    else
      append(head, people ? Row{"F1", "distance, mean / 95 % [cm]", "covered", "occupied per surface cell",
                                "surface called free", "free called free"}
                          : Row{"f1", "mean_distance_m", "distance_95_m", "surface_covered",
                                "occupied_per_surface_cell", "surface_called_free", "free_called_free"});
  }
  append(head, people ? Row{"scans", "ms per scan", "MiB"} : Row{"scans", "ms_per_scan", "memory_bytes"});
  const bool someRefused = !comparison.refused.empty();
  if (someRefused)
  {
    append(head, Row{people ? "not compared, because" : "refused"});
    table.endWithSentences();
  }
  const size_t columns = head.size();
  table.add(head);
  for (const ComparedMap& map : comparison.maps)
  {
    Row row{map.name};
    if (scored)
    {
      const Scores& all = map.scores->all;
      const double share = map.scores->observedShare();
      append(row, {number(all.areaUnderRoc), number(all.averagePrecision), number(all.logLoss),
                   number(all.brier), number(map.scores->observed.calibrationError),
                   people ? mrpt::format("%.1f %%", 100 * share) : shortest(share)});
      for (const auto& [threshold, above, atLeast] : all.thresholds)
        append(row, people ? Row{number(atLeast.precision) + " / " + number(atLeast.recall)}
                           : Row{number(atLeast.precision), number(atLeast.recall)});
      if (heldOut)
        append(row,
               {number(map.scoresOfReturned->all.areaUnderRoc), number(map.scoresOfReturned->all.logLoss)});
      else
        append(row, geometryFields(*map.scores->geometry, people, number));
    }
    const double scan_ms = 1e3 * map.insertionOfOne_s();
    const std::string none = people ? "-" : "";
    append(row,
           {std::to_string(map.scans.usedCount()), people ? mrpt::format("%.2f", scan_ms) : shortest(scan_ms),
            !map.memoryBytes ? none
            : people         ? mrpt::format("%.3f", static_cast<double>(*map.memoryBytes) / (1024.0 * 1024.0))
                             : std::to_string(*map.memoryBytes)});
    row.resize(columns);
    table.add(row);
  }
  for (const auto& [name, reason] : comparison.refused)
  {
    Row row(columns, people ? "-" : "");
    row.front() = name;
    row.back() = reason;
    table.add(row);
  }
  return table;
}

void printComparison(const Comparison& comparison, std::ostream& out)
{
  if (!comparison.scoredBy.empty())
    out << "scored by " << comparison.scoredBy
        << mrpt::format(
               " (one that a map has not observed counts as %g; the calibration error is over those "
               "it has observed)\n",
               kUnobservedProb);
  comparisonTable(comparison, ForWhom::People).print(out);
  for (const ComparedMap& map : comparison.maps)
  {
    printLeftOut(map.scans, out, map.name + ": ");
    if (!map.scores) continue;
    for (const std::string& note : map.scores->notes) out << "  " << map.name << ": " << note << "\n";
  }
  for (const auto* notes : {&comparison.inputNotes, &comparison.notes})
    for (const std::string& note : *notes) out << "  " << note << "\n";
  if (!comparison.pagePath.empty()) out << "pictures: " << comparison.pagePath << "\n";
}

Json comparisonJson(const Comparison& comparison)
{
  Json json;
  json["scoredBy"] = comparison.scoredBy;
  json["scoring"] = scoringJson();
  json["notes"] = comparison.notes;
  json["inputNotes"] = comparison.inputNotes;
  json["page"] = comparison.pagePath;
  json["maps"] = Json::array();
  for (const ComparedMap& map : comparison.maps)
  {
    Json one{{"map", map.name},
             {"class", map.map->GetRuntimeClass()->className},
             {"scans", map.scans.usedCount()},
             {"insertionSeconds", map.insertion_s},
             {"millisecondsAScan", 1e3 * map.insertionOfOne_s()}};
    one["memoryBytes"] = jsonOf(map.memoryBytes);
    one["scores"] = map.scores ? scoresJson(*map.scores) : Json();
    if (map.scoresOfReturned) one["scoresOfReturned"] = scoresJson(*map.scoresOfReturned);
    json["maps"].push_back(one);
  }
  json["refused"] = Json::array();
  for (const auto& [name, reason] : comparison.refused)
    json["refused"].push_back({{"map", name}, {"reason", reason}});
  return json;
}

}  // namespace lamap::tools
