#include <lamap_core/training/scan_labels.h>
#include <lamap_mrpt/files/atomic_file.h>
#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <lamap_tools/commands/compare.h>
#include <lamap_tools/files/file_output.h>
#include <lamap_tools/files/usage_error.h>
#include <lamap_tools/scores/score_report.h>
#include <lamap_tools/scores/truth.h>
#include <mrpt/core/format.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/maps/COctoMap.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <ostream>
#include <sstream>
#include <stdexcept>

#include <lamap_tools/commands/comparison_page.h>
#include <lamap_tools/commands/held_out_cells.h>

namespace lamap::tools
{
namespace
{
/// "label: bgkMap a.b=c d.e=f" taken apart.
struct NamedRequest
{
  std::string name;
  MapRequest request;
  bool hasOwnSettings = false;
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
  NamedRequest named{
      labelled ? text.substr(0, colon) : text, {"", options.configPath, options.settings}, false};
  std::istringstream words(labelled ? text.substr(colon + 2) : text);
  words >> named.request.mapName;
  if (labelled && named.name.empty()) throw UsageError("-m '" + text + "': the label is empty");
  if (named.request.mapName.empty()) throw UsageError("-m '" + text + "': expected the name of a map");
  if (hasLoneColon(named.request.mapName))
    throw UsageError("-m '" + text + "': expected 'LABEL: MAP', with a space after the colon");
  for (std::string word; words >> word;)
  {
    named.request.settings.push_back(word);
    named.hasOwnSettings = true;
  }
  return named;
}

std::vector<std::string> namesOfMaps(const CompareOptions& options)
{
  if (!options.maps.empty()) return options.maps;
  if (options.configPath.empty()) return {"bgkMap", "overlappingHilbertMap", "hilbertMap", "octoMap"};
  const std::vector<std::string> counted = mapsCountedIn(options.configPath);
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
    const bool shared = named.request.settings.size() > 0 && !named.hasOwnSettings;
    throw UsageError(
        "-m '" + named.name + "': " + error.what() +
        (shared ? "; a setting of one map only stands after its name: -m 'MAP section.key=value'" : ""));
  }
}

/// A map that is being built. Belongs to one thread.
class Builder
{
 public:
  Builder(const NamedRequest& named, const CompareOptions& options)
  {
    built_.name = named.name;
    built_.map = createMap(definitionOf(named));
    if (auto* learned = dynamic_cast<CLearnedMap*>(built_.map.get()))
      learned->setThreadCount(options.threads);
    built_.cells = cellsOf(built_.map);
    if (!built_.cells)
      throw UsageError("-m " + built_.name + ": a " + built_.map->GetRuntimeClass()->className +
                       " has no cells to compare");
    inserter_ = std::make_unique<ScanInserter>(*built_.map);
    rules_ = labelRulesFor(*built_.map, *built_.cells, options.maxRange_m);
  }

  void insert(const ScanItem& item)
  {
    const ScanItem own = ownCopyOf(item);
    if (const auto* observed = std::get_if<ObservedScan>(&own)) observed->observation->load();
    takeTime([&] { inserter_->insert(own); });
  }

  [[nodiscard]] LabelRules& rules() { return rules_; }
  [[nodiscard]] const InsertionTally& tally() const { return inserter_->tally(); }
  [[nodiscard]] const ComparedMap& built() const { return built_; }

  [[nodiscard]] ComparedMap finish()
  {
    takeTime([&] { (void)built_.cells->estimateAt({0, 0, 0}); });
    built_.scans = inserter_->tally();
    built_.memoryBytes = memoryOf(*built_.map);
    return built_;
  }

 private:
  template <class Act>
  void takeTime(const Act& act)
  {
    const auto begin = std::chrono::steady_clock::now();
    act();
    built_.insertion_s += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }

  ComparedMap built_;
  std::unique_ptr<ScanInserter> inserter_;
  LabelRules rules_;
};

/// Scores by scans that were kept from the maps. Each map is asked about its own kind of cells.
class HeldOutScores
{
 public:
  HeldOutScores(const CompareOptions& options, std::vector<Builder>& builders) : choice_(options.heldOutEvery)
  {
    double farthest_m = options.maxRange_m;
    if (!(farthest_m > 0))
      for (Builder& builder : builders) farthest_m = std::max(farthest_m, builder.rules().maxRange_m);
    for (Builder& builder : builders)
    {
      builder.rules().maxRange_m = farthest_m;
      rules_.push_back(builder.rules());
      shown_.emplace_back(rules_.back().resolution_m);
    }
  }

  /// @return whether the scan is one to be kept from the maps
  bool take(const ScanItem& item)
  {
    const auto scan = scanOf(item);
    if (!scan || !choice_.isHeldOut(item)) return false;
    for (size_t i = 0; i < rules_.size(); ++i) shown_[i].add(labelCells(*scan, rules_[i]));
    return true;
  }

  void scoreInto(ComparedMap& map, size_t number, const std::vector<double>& thresholds) const
  {
    if (shown_[number].empty())
      throw std::runtime_error("the scans that were held out show neither hits nor free space");
    MapScores scores;
    scores.name = map.name;
    scores.className = map.cells->className();
    scores.resolution_m = map.cells->resolution();
    PredictionTally tally;
    shown_[number].ask(*map.cells, tally);
    tally.scoreInto(scores, thresholds);
    map.scores = std::move(scores);
  }

  [[nodiscard]] const HeldOutChoice& choice() const { return choice_; }
  [[nodiscard]] bool sameCells() const
  {
    return std::all_of(
        rules_.begin(), rules_.end(),
        [&](const LabelRules& rules)
        { return rules.resolution_m == rules_.front().resolution_m && rules.layer == rules_.front().layer; });
  }

 private:
  HeldOutChoice choice_;
  std::vector<LabelRules> rules_;
  std::vector<HeldOutCells> shown_;
};

/// @throws UsageError unless the path is empty or ends so; std::runtime_error if nothing can be written there
void requireOutput(const std::string& path, const std::vector<std::string>& extensions,
                   const std::string& why)
{
  if (path.empty()) return;
  if (std::find(extensions.begin(), extensions.end(), std::filesystem::path(path).extension()) ==
      extensions.end())
    throw UsageError(path + ": " + why);
  const AtomicFile placeIsWritable(path);
}

void requireLegalOptions(const CompareOptions& options)
{
  if (!options.truthPath.empty() && options.heldOutEvery > 0)
    throw UsageError("--truth and --held-out: maps are scored by one of them");
  if (options.heldOutEvery == 1)
    throw UsageError("--held-out 1: must be a whole number >= 2; with 10 every tenth scan is scored");
  if (!(options.maxRange_m >= 0) || !std::isfinite(options.maxRange_m))
    throw UsageError("--max-range: must be a length > 0, in m");
  if (options.maxRange_m > 0 && options.heldOutEvery == 0)
    throw UsageError("--max-range: is for --held-out only; how far maps insert is their own option");
  requireOutput(options.pagePath, {".html"}, "the page is written as .html");
  requireOutput(options.tablePath, {".csv", ".md"}, "the table is written as .csv or .md");
}

std::vector<Builder> buildersFor(const CompareOptions& options)
{
  std::vector<Builder> builders;
  std::vector<std::string> names;
  for (const std::string& text : namesOfMaps(options))
  {
    const NamedRequest named = requestOf(text, options);
    if (std::find(names.begin(), names.end(), named.name) != names.end())
      throw UsageError("-m " + text + ": twice the same map, or the same label");
    names.push_back(named.name);
    builders.emplace_back(named, options);
  }
  return builders;
}

/// @throws std::runtime_error if one of the maps has nothing to be compared by
void requireScans(const std::vector<Builder>& builders, const HeldOutScores* heldOut)
{
  for (const Builder& builder : builders)
    if (builder.tally().usedCount() == 0)
      throw std::runtime_error(builder.built().name + ": not one scan that the map takes" +
                               reasonsOf(builder.tally()));
  if (heldOut != nullptr && heldOut->choice().heldOut() == 0)
    throw std::runtime_error("only " + std::to_string(heldOut->choice().mostScans()) +
                             " usable scans of a sensor: none would be held out");
}

void scoreAll(Comparison& comparison, const CompareOptions& options, const Truth* truth,
              const HeldOutScores* heldOut)
{
  if (truth != nullptr)
  {
    comparison.scoredBy = mrpt::format("%zu cells of %s", truth->cells.size(), truth->name.c_str());
    for (ComparedMap& map : comparison.maps)
    {
      const OpenedMap opened{map.map, cellsOf(map.map)};
      map.scores = scoreMap(opened, map.name, *truth, options.thresholds);
    }
  }
  if (heldOut == nullptr) return;
  comparison.scoredBy = mrpt::format("the cells that %zu scans held out show", heldOut->choice().heldOut());
  for (size_t i = 0; i < comparison.maps.size(); ++i)
    heldOut->scoreInto(comparison.maps[i], i, options.thresholds);
  if (!heldOut->sameCells())
    comparison.notes.emplace_back(
        "the maps have cells of different sizes or layers: each is scored over its own");
}

/// For programs: a number a field, with all its digits; nothing where there is none.
std::string fieldOf(const std::optional<double>& number)
{
  return number ? shortest(*number) : "";
}

std::string comparisonCsv(const Comparison& comparison)
{
  const bool scored = !comparison.scoredBy.empty();
  TextTable table;
  std::vector<std::string> head{"map"};
  if (scored)
  {
    head.insert(head.end(), {"auc", "average_precision", "log_loss", "brier", "observed_calibration_error",
                             "observed_share"});
    for (const ThresholdScore& score : comparison.maps.front().scores->all.thresholds)
      for (const char* what : {"precision", "recall"})
        head.push_back(mrpt::format("%s_at_%g", what, score.threshold));
  }
  head.insert(head.end(), {"scans", "ms_per_scan", "memory_bytes"});
  table.add(head);
  for (const ComparedMap& map : comparison.maps)
  {
    std::vector<std::string> row{map.name};
    if (scored)
    {
      const Scores& all = map.scores->all;
      for (const std::optional<double>& number :
           {all.areaUnderRoc, all.averagePrecision, all.logLoss, all.brier,
            map.scores->observed.calibrationError, std::optional(map.scores->observedShare())})
        row.push_back(fieldOf(number));
      for (const ThresholdScore& score : all.thresholds)
        row.insert(row.end(), {fieldOf(score.atLeast.precision), fieldOf(score.atLeast.recall)});
    }
    row.insert(row.end(), {std::to_string(map.scans.usedCount()), shortest(1e3 * map.insertionOfOne_s()),
                           map.memoryBytes ? std::to_string(*map.memoryBytes) : ""});
    table.add(row);
  }
  return csvOf(table);
}

std::string memoryText(const std::optional<uint64_t>& bytes)
{
  return bytes ? mrpt::format("%.3f", static_cast<double>(*bytes) / (1024.0 * 1024.0)) : "-";
}
}  // namespace

Comparison compareMaps(const CompareOptions& options, const ProgressSink& progress)
{
  requireLegalOptions(options);
  std::vector<Builder> builders = buildersFor(options);
  std::optional<Truth> truth;
  if (!options.truthPath.empty()) truth = readTruth(options.truthPath);
  std::optional<HeldOutScores> heldOut;
  if (options.heldOutEvery > 0) heldOut.emplace(options, builders);
  const auto sources = openInputs(options.inputs);

  Comparison comparison;
  comparison.stopped = !visitScans(sources, options.inputs.shouldStop, progress,
                                   [&](const ScanItem& item)
                                   {
                                     if (heldOut && heldOut->take(item)) return;
                                     for (Builder& builder : builders) builder.insert(item);
                                   });
  comparison.inputs = reportsOf(sources);
  if (comparison.stopped) return comparison;
  requireScans(builders, heldOut ? &*heldOut : nullptr);
  for (Builder& builder : builders) comparison.maps.push_back(builder.finish());
  scoreAll(comparison, options, truth ? &*truth : nullptr, heldOut ? &*heldOut : nullptr);
  if (!options.tablePath.empty())
  {
    const bool markdown = std::filesystem::path(options.tablePath).extension() == ".md";
    writeFileAtomically(options.tablePath,
                        markdown ? markdownOf(comparisonTable(comparison)) : comparisonCsv(comparison));
  }
  if (!options.pagePath.empty())
  {
    writeComparisonPage(comparison, truth ? &*truth : nullptr, options.pagePath);
    comparison.pagePath = options.pagePath;
  }
  return comparison;
}

TextTable comparisonTable(const Comparison& comparison)
{
  const bool scored = !comparison.scoredBy.empty();
  TextTable table;
  std::vector<std::string> head{"map"};
  if (scored)
  {
    head.insert(head.end(),
                {"AUC", "avg. precision", "log loss", "Brier", "calibration error (observed)", "observed"});
    for (const ThresholdScore& score : comparison.maps.front().scores->all.thresholds)
      head.push_back(mrpt::format("P / R, p >= %g", score.threshold));
  }
  head.insert(head.end(), {"scans", "ms per scan", "MiB"});
  table.add(head);
  for (const ComparedMap& map : comparison.maps)
  {
    std::vector<std::string> row{map.name};
    if (scored)
    {
      const Scores& all = map.scores->all;
      row.insert(row.end(),
                 {numberText(all.areaUnderRoc), numberText(all.averagePrecision), numberText(all.logLoss),
                  numberText(all.brier), numberText(map.scores->observed.calibrationError),
                  mrpt::format("%.1f %%", 100 * map.scores->observedShare())});
      for (const ThresholdScore& score : all.thresholds)
        row.push_back(numberText(score.atLeast.precision) + " / " + numberText(score.atLeast.recall));
    }
    row.insert(row.end(), {std::to_string(map.scans.usedCount()),
                           mrpt::format("%.2f", 1e3 * map.insertionOfOne_s()), memoryText(map.memoryBytes)});
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
  comparisonTable(comparison).print(out);
  for (const ComparedMap& map : comparison.maps)
  {
    for (const auto& [what, count] : map.scans.leftOut)
      out << "  " << map.name << ": left out: " << count << " " << what.first << ": " << what.second << "\n";
    if (!map.scores) continue;
    for (const std::string& note : map.scores->notes) out << "  " << map.name << ": " << note << "\n";
  }
  for (const std::string& note : comparison.notes) out << "  " << note << "\n";
  if (!comparison.pagePath.empty()) out << "pictures: " << comparison.pagePath << "\n";
}

nlohmann::ordered_json comparisonJson(const Comparison& comparison)
{
  nlohmann::ordered_json json;
  json["scoredBy"] = comparison.scoredBy;
  json["scoring"] = scoringJson();
  json["notes"] = comparison.notes;
  json["page"] = comparison.pagePath;
  json["maps"] = nlohmann::ordered_json::array();
  for (const ComparedMap& map : comparison.maps)
  {
    nlohmann::ordered_json one{{"map", map.name},
                               {"class", map.map->GetRuntimeClass()->className},
                               {"scans", map.scans.usedCount()},
                               {"insertionSeconds", map.insertion_s},
                               {"millisecondsAScan", 1e3 * map.insertionOfOne_s()}};
    one["memoryBytes"] = map.memoryBytes ? nlohmann::ordered_json(*map.memoryBytes) : nullptr;
    one["scores"] = map.scores ? scoresJson(*map.scores) : nlohmann::ordered_json(nullptr);
    json["maps"].push_back(one);
  }
  return json;
}

}  // namespace lamap::tools
