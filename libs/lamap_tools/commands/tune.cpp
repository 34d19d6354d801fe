#include <lamap_tools/commands/tune.h>

#include <lamap_core/training/scan_labels.h>
#include <lamap_mrpt/files/atomic_file.h>
#include <lamap_tools/commands/scored_map.h>
#include <lamap_tools/files/file_names.h>
#include <lamap_tools/files/text_fields.h>
#include <lamap_tools/files/usage_error.h>
#include <lamap_tools/inputs/scan_inserter.h>
#include <lamap_tools/report/counted.h>
#include <lamap_tools/report/text_table.h>
#include <lamap_tools/scores/held_out_cells.h>
#include <lamap_tools/scores/score_report.h>
#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/core/format.h>
#include <mrpt/system/string_utils.h>
#include <tbb/parallel_for_each.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <mutex>
#include <ostream>
#include <set>
#include <stdexcept>

namespace lamap::tools
{
namespace
{
constexpr size_t kMostCombinations = 1000;

/// "section.key=a,b" as "section.key=a" and "section.key=b".
std::vector<std::string> valuesOf(const std::string& text)
{
  const Setting setting = parseSetting(text);
  std::vector<std::string> settings;
  for (const std::string_view value : fieldsBetween(setting.text, ","))
  {
    if (value.empty()) throw UsageError("-s " + text + ": a value between commas is empty");
    settings.push_back(setting.section + "." + setting.key + "=" + std::string(value));
  }
  return settings;
}

/// What is fixed, and all combinations of what is searched.
struct SearchSpace
{
  std::vector<std::string> fixed;
  std::vector<std::vector<std::string>> combinations{{}};
};

SearchSpace searchSpaceOf(const std::vector<std::string>& settings)
{
  SearchSpace space;
  std::set<std::string> keys;
  for (const std::string& text : settings)
  {
    const std::vector<std::string> values = valuesOf(text);
    const Setting setting = parseSetting(text);
    if (!keys.insert(mrpt::system::lowerCase(setting.section + "." + setting.key)).second)
      throw UsageError("-s " + text + ": " + setting.section + "." + setting.key +
                       " is given twice; give all its values by commas");
    if (const std::set<std::string> different(values.begin(), values.end()); different.size() < values.size())
      throw UsageError("-s " + text + ": one of the values is given twice");
    if (values.size() == 1)
    {
      space.fixed.push_back(text);
      continue;
    }
    std::vector<std::vector<std::string>> longer;
    for (const auto& combination : space.combinations)
      for (const std::string& value : values)
      {
        longer.push_back(combination);
        longer.back().push_back(value);
      }
    if (longer.size() > kMostCombinations)
      throw UsageError(mrpt::format("more than %zu combinations to search", kMostCombinations));
    space.combinations = std::move(longer);
  }
  if (space.combinations.size() < 2)
    throw UsageError(
        "nothing to search: give values by commas, e.g. -s insertOpts.kernelSupport=0.15,0.2,0.3");
  return space;
}

/// One map of the search. Used by one thread at a time.
class Candidate : public ScoredMap
{
 public:
  Candidate(const MapDefinition& definition, double maxRange_m)
      // The candidates are what is shared out among the threads.
      : ScoredMap(definition.name, definition, 1, maxRange_m, "score")
  {
  }

  /// @param labels  by all rays  @param returned  by those that returned
  void askAbout(const ScanLabels& labels, const ScanLabels& returned)
  {
    ask(labels, tally, joinAt_);
    ask(returned, tallyOfReturned_, joinReturnedAt_);
  }

  void askAbout(const HeldOutCells& shown)
  {
    shown.ask(ScoredRays::All, *cells, tally);
    shown.ask(ScoredRays::Returned, *cells, tallyOfReturned_);
  }

  /// Leaves the tallies empty.
  [[nodiscard]] TunedMap tuned(const std::vector<std::string>& settings)
  {
    const std::vector<double> thresholds{0.7};
    return {settings, scores(thresholds), tallyOfReturned_.scores(name, *cells, thresholds)};
  }

 private:
  static constexpr size_t kJoinAt = 1U << 21U;

  void ask(const ScanLabels& labels, PredictionTally& answers, size_t& joinAt) const
  {
    askAboutLabels(*cells, labels, answers);
    if (answers.size() <= joinAt) return;
    answers.join();
    joinAt = std::max(kJoinAt, 2 * answers.size());
  }

  PredictionTally tallyOfReturned_;
  size_t joinAt_ = kJoinAt;
  size_t joinReturnedAt_ = kJoinAt;
};

void requireSameCells(const Candidate& first, const Candidate& other)
{
  if (first.rules.resolution_m != other.rules.resolution_m || first.rules.layer != other.rules.layer)
    throw UsageError(
        "resolution and layer cannot be searched: scores over different cells cannot be compared");
  if (first.rules.maxRange_m != other.rules.maxRange_m)
    throw UsageError(
        "the search changes how far rays are inserted: say by --max-range how far they are scored");
}

std::vector<std::unique_ptr<Candidate>> candidatesOf(const TuneOptions& options, const SearchSpace& space)
{
  std::vector<std::unique_ptr<Candidate>> candidates;
  for (const auto& combination : space.combinations)
  {
    MapRequest request = options.map;
    request.settings = space.fixed;
    request.settings.insert(request.settings.end(), combination.begin(), combination.end());
    try
    {
      candidates.push_back(std::make_unique<Candidate>(readMapDefinition(request), options.maxRange_m));
    }
    catch (const UsageError& error)
    {
      throw UsageError(error.what() + (" (the combination " + joined(combination) + ")"));
    }
    requireSameCells(*candidates.front(), *candidates.back());
  }
  return candidates;
}

/// More than the machine has would only make TBB complain.
int threadCount(unsigned wanted)
{
  const int most = tbb::this_task_arena::max_concurrency();
  return wanted == 0 ? most : std::min(most, static_cast<int>(wanted));
}

/// Shares the candidates out among threads.
class Search
{
 public:
  Search(const TuneOptions& options, std::vector<std::unique_ptr<Candidate>> candidates)
      : options_(options),
        candidates_(std::move(candidates)),
        arena_(threadCount(options.threads)),
        choice_(options.every),
        shown_(candidates_.front()->rules.resolution_m)
  {
  }

  void take(const ScanItem& item)
  {
    const auto scan = scanOf(item);
    if (scan && options_.prequential)
    {
      const bool first = scored_ + unscored_ == 0;  // no map knows anything yet
      ++(first ? unscored_ : scored_);
      const auto labels = [&](ScoredRays rays)
      { return first ? ScanLabels() : labelsBy(rays, *scan, rules()); };
      const ScanLabels all = labels(ScoredRays::All);
      const ScanLabels returned = labels(ScoredRays::Returned);
      return forEach([&](Candidate& candidate) { candidate.askAbout(all, returned); }, &item);
    }
    if (scan && choice_.isHeldOut(item))
    {
      ++scored_;
      return shown_.add(*scan, rules());
    }
    forEach([](Candidate&) {}, &item);
  }

  void finish()
  {
    if (!options_.prequential) forEach([&](Candidate& candidate) { candidate.askAbout(shown_); }, nullptr);
  }

  [[nodiscard]] std::vector<std::unique_ptr<Candidate>>& candidates() { return candidates_; }
  [[nodiscard]] size_t scored() const { return scored_; }
  [[nodiscard]] size_t mostScans() const { return choice_.mostScans() + scored_ * options_.prequential; }

 private:
  const LabelRules& rules() const { return candidates_.front()->rules; }

  /// Does something with every candidate and then gives it the item, if there is one.
  template <class Act>
  void forEach(const Act& act, const ScanItem* item)
  {
    std::mutex copying;
    const auto one = [&](Candidate& candidate)
    {
      act(candidate);
      if (item == nullptr) return;
      std::unique_lock<std::mutex> lock(copying);
      const ScanItem copy = ownCopyOf(*item);
      lock.unlock();
      candidate.inserter->insert(copy);
    };
    arena_.execute([&]
                   { tbb::parallel_for_each(candidates_, [&](const auto& candidate) { one(*candidate); }); });
  }

  const TuneOptions& options_;
  std::vector<std::unique_ptr<Candidate>> candidates_;
  tbb::task_arena arena_;
  HeldOutChoice choice_;
  HeldOutCells shown_;
  size_t scored_ = 0;
  size_t unscored_ = 0;
};

void requireLegalOptions(const TuneOptions& options)
{
  requireLegalScoring(options.every, options.maxRange_m);
  if (options.outPath.empty()) return;
  if (extensionOf(options.outPath) != ".ini")
    throw UsageError("-o " + options.outPath + ": the settings are saved as .ini");
  const AtomicFile placeIsWritable(options.outPath);
}

/// By which maps are ranked.
const Scores& rankingScores(const TunedMap& map, bool byAllRays)
{
  return byAllRays ? map.scores.all : map.scoresOfReturned.all;
}

/// What the configuration file says of the map, with the fixed and the best settings over it.
std::string bestConfig(const TuneOptions& options, const SearchSpace& space, const TuneReport& report)
{
  const std::string prefix = "map_" + report.mapName + "_00_";
  mrpt::config::CConfigFileMemory ini;
  const auto set = [&](const Setting& setting)
  { ini.write(prefix + setting.section, setting.key, setting.text); };
  ini.write("map", report.mapName + "_count", std::string("1"));
  if (!options.map.configPath.empty())
    for (const Setting& setting : settingsIn(options.map.configPath, report.mapName)) set(setting);
  const TunedMap& best = report.maps.front();
  for (const auto* settings : {&space.fixed, &best.settings})
    for (const std::string& text : *settings) set(parseSetting(text));
  std::string sections;
  ini.getContent(sections);
  const Scores& scores = rankingScores(best, report.rankedByAllRays);
  return mrpt::format("# The best of %s by %s log loss: %.4f over %s that %s of %s show.\n",
                      counted(report.maps.size(), "setting").c_str(),
                      options.prequential ? "prequential" : "held-out", *scores.logLoss,
                      counted(scores.cells(), "cell").c_str(),
                      report.rankedByAllRays ? "all rays" : "the rays that returned",
                      counted(report.scored, "scan").c_str()) +
         "#   lamap build -i LOG -c THIS -o MAP.lamap.gz\n\n" + sections;
}
}  // namespace

TuneReport tuneMap(const TuneOptions& options, const ProgressSink& progress)
{
  requireLegalOptions(options);
  const SearchSpace space = searchSpaceOf(options.map.settings);
  Search search(options, candidatesOf(options, space));
  const auto sources = openInputs(options.inputs);

  TuneReport report;
  report.mapName = search.candidates().front()->name;
  report.stopped =
      !visitScans(sources, options.inputs.shouldStop, progress,
                  [&](const ScanItem& item, const ScanSource& /*source*/) { search.take(item); });
  report.scored = search.scored();
  report.inputs = reportsOf(sources);
  report.inputNotes = allNotesOf(sources);
  if (report.stopped) return report;

  const InsertionTally& inserted = search.candidates().front()->inserter->tally();
  if (report.scored == 0)
    throw std::runtime_error(
        "too few scans: " + std::to_string(search.mostScans()) + " usable of a sensor, " +
        (options.prequential ? "2 are needed"
                             : std::to_string(options.every) + " are needed to hold one out") +
        reasonsOf(inserted));
  search.finish();
  for (size_t i = 0; i < space.combinations.size(); ++i)
    report.maps.push_back(search.candidates()[i]->tuned(space.combinations[i]));
  report.rankedByAllRays = options.rankByAllRays;
  if (report.maps.front().scores.all.cells() == 0)
    throw std::runtime_error("the scans that are scored show neither hits nor free space");
  if (rankingScores(report.maps.front(), options.rankByAllRays).cells() == 0)
    throw std::runtime_error(
        "not one ray of the scans that are scored returned: --all-rays ranks by those that did not, too");
  if (inserted.usedCount() == 0)
    throw std::runtime_error("not one scan that the map takes" + reasonsOf(inserted));
  report.scans = inserted;
  std::stable_sort(report.maps.begin(), report.maps.end(),
                   [&](const TunedMap& a, const TunedMap& b)
                   {
                     return *rankingScores(a, options.rankByAllRays).logLoss <
                            *rankingScores(b, options.rankByAllRays).logLoss;
                   });
  if (!options.outPath.empty())
  {
    writeFileAtomically(options.outPath, bestConfig(options, space, report));
    report.outPath = options.outPath;
  }
  return report;
}

void printTuning(const TuneReport& report, std::ostream& out)
{
  const bool byAll = report.rankedByAllRays;
  out << counted(report.maps.size(), "setting") << " of " << report.mapName << ", scored by "
      << counted(report.scored, "scan") << (byAll ? " (all rays)" : " (only rays that returned)")
      << "; best first\n";
  out << "  log loss     AUC   Brier  calibration error  observed  "
      << (byAll ? "log loss, returns only" : "log loss, all rays") << "  settings\n";
  for (const TunedMap& map : report.maps)
  {
    const Scores& scores = rankingScores(map, byAll);
    const Scores& others = rankingScores(map, !byAll);
    out << mrpt::format("  %8.4f  %6s  %.4f  %17.4f  %6.1f %%  %*s  ", *scores.logLoss,
                        numberText(scores.areaUnderRoc).c_str(), *scores.brier, *scores.calibrationError,
                        100 * (byAll ? map.scores : map.scoresOfReturned).observedShare(), byAll ? 22 : 18,
                        numberText(others.logLoss).c_str());
    out << joined(map.settings, " ") << "\n";
  }
  printLeftOut(report.scans, out);
  for (const std::string& note : report.inputNotes) out << "  " << note << "\n";
  if (!report.outPath.empty()) out << "the best settings are saved to " << report.outPath << "\n";
}

Json tuningJson(const TuneReport& report)
{
  Json json;
  json["map"] = report.mapName;
  json["scoredScans"] = report.scored;
  json["inputNotes"] = report.inputNotes;
  json["rankedBy"] = report.rankedByAllRays ? "allRays" : "returned";
  json["output"] = report.outPath;
  json["scoring"] = scoringJson();
  json["candidates"] = Json::array();
  for (const TunedMap& map : report.maps)
    json["candidates"].push_back({{"settings", map.settings},
                                  {"scores", scoresJson(map.scores)},
                                  {"scoresOfReturned", scoresJson(map.scoresOfReturned)}});
  return json;
}

}  // namespace lamap::tools
