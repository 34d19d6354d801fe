#include <lamap_core/training/scan_labels.h>
#include <lamap_mrpt/files/atomic_file.h>
#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <lamap_mrpt/options/option_group.h>
#include <lamap_tools/commands/tune.h>
#include <lamap_tools/files/usage_error.h>
#include <lamap_tools/inputs/scan_inserter.h>
#include <lamap_tools/scores/score_report.h>
#include <mrpt/config/CConfigFile.h>
#include <mrpt/core/format.h>
#include <strings.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <mutex>
#include <ostream>
#include <set>
#include <stdexcept>

#include <lamap_tools/commands/held_out_cells.h>

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
  for (size_t begin = 0; begin <= setting.text.size();)
  {
    const size_t end = std::min(setting.text.find(',', begin), setting.text.size());
    if (end == begin) throw UsageError("-s " + text + ": a value between commas is empty");
    settings.push_back(setting.section + "." + setting.key + "=" + setting.text.substr(begin, end - begin));
    begin = end + 1;
  }
  if (setting.text.back() == ',') throw UsageError("-s " + text + ": a value between commas is empty");
  return settings;
}

std::string lowerCase(std::string text)
{
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
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
    if (!keys.insert(lowerCase(setting.section + "." + setting.key)).second)
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
class Candidate
{
 public:
  Candidate(const MapRequest& request, double maxRange_m)
  {
    const MapDefinition definition = readMapDefinition(request);
    name_ = definition.name;
    map_ = createMap(definition);
    // The candidates are what is shared out among the threads.
    if (auto* learned = dynamic_cast<CLearnedMap*>(map_.get())) learned->setThreadCount(1);
    cells_ = cellsOf(map_);
    if (!cells_)
      throw UsageError("-m " + name_ + ": a " + map_->GetRuntimeClass()->className +
                       " has no cells to score");
    rules_ = labelRulesFor(*map_, *cells_, maxRange_m);
    inserter_ = std::make_unique<ScanInserter>(*map_);
  }

  void insert(const ScanItem& item) { inserter_->insert(item); }
  void askAbout(const ScanLabels& labels)
  {
    askAboutLabels(*cells_, labels, tally_);
    if (tally_.size() > joinAt_)
    {
      tally_.join();
      joinAt_ = std::max(kJoinAt, 2 * tally_.size());
    }
  }
  void askAbout(const HeldOutCells& shown) { shown.ask(*cells_, tally_); }

  [[nodiscard]] MapScores score()
  {
    MapScores scores;
    scores.name = name_;
    scores.className = cells_->className();
    scores.resolution_m = cells_->resolution();
    tally_.scoreInto(scores, {0.7});
    return scores;
  }

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const LabelRules& rules() const { return rules_; }
  [[nodiscard]] const InsertionTally& inserted() const { return inserter_->tally(); }

 private:
  std::string name_;
  mrpt::maps::CMetricMap::Ptr map_;
  std::unique_ptr<CellMap> cells_;
  std::unique_ptr<ScanInserter> inserter_;
  LabelRules rules_;
  PredictionTally tally_;
  static constexpr size_t kJoinAt = 1U << 21U;
  size_t joinAt_ = kJoinAt;
};

void requireSameCells(const Candidate& first, const Candidate& other)
{
  if (first.rules().resolution_m != other.rules().resolution_m || first.rules().layer != other.rules().layer)
    throw UsageError(
        "resolution and layer cannot be searched: scores over different cells cannot be compared");
  if (first.rules().maxRange_m != other.rules().maxRange_m)
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
      candidates.push_back(std::make_unique<Candidate>(request, options.maxRange_m));
    }
    catch (const UsageError& error)
    {
      std::string searched;
      for (const std::string& setting : combination) searched += (searched.empty() ? "" : ", ") + setting;
      throw UsageError(error.what() + (" (the combination " + searched + ")"));
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
        shown_(candidates_.front()->rules().resolution_m)
  {
  }

  void take(const ScanItem& item)
  {
    const auto scan = scanOf(item);
    if (scan && options_.prequential)
    {
      const bool first = scored_ + unscored_ == 0;  // no map knows anything yet
      ++(first ? unscored_ : scored_);
      const ScanLabels labels = first ? ScanLabels() : labelCells(*scan, rules());
      return forEach([&](Candidate& candidate) { candidate.askAbout(labels); }, &item);
    }
    if (scan && choice_.isHeldOut(item))
    {
      ++scored_;
      return shown_.add(labelCells(*scan, rules()));
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
  const LabelRules& rules() const { return candidates_.front()->rules(); }

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
      candidate.insert(copy);
    };
    arena_.execute(
        [&]
        {
          tbb::parallel_for(tbb::blocked_range<size_t>(0, candidates_.size(), 1),
                            [&](const tbb::blocked_range<size_t>& range)
                            {
                              for (size_t i = range.begin(); i < range.end(); ++i) one(*candidates_[i]);
                            });
        });
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
  if (options.every < 2)
    throw UsageError("--held-out " + std::to_string(options.every) + ": must be a whole number >= 2");
  if (!(options.maxRange_m >= 0) || !std::isfinite(options.maxRange_m))
    throw UsageError("--max-range: must be a length > 0, in m");
  if (options.outPath.empty()) return;
  if (std::filesystem::path(options.outPath).extension() != ".ini")
    throw UsageError("-o " + options.outPath + ": the settings are saved as .ini");
  const AtomicFile placeIsWritable(options.outPath);
}

/// Sections of an .ini file in the order in which they were first named, names compared as MRPT does.
class IniSections
{
 public:
  void set(const std::string& section, const std::string& key, const std::string& text)
  {
    auto& keys = keysOf(section);
    const auto same = [&](const auto& entry) { return strcasecmp(entry.first.c_str(), key.c_str()) == 0; };
    const auto found = std::find_if(keys.begin(), keys.end(), same);
    if (found == keys.end())
      keys.emplace_back(key, text);
    else
      found->second = text;
  }

  [[nodiscard]] std::string text() const
  {
    std::string text;
    for (const auto& [section, keys] : sections_)
    {
      text += "\n[" + section + "]\n";
      for (const auto& [key, value] : keys) text += key + " = " + value + "\n";
    }
    return text;
  }

 private:
  using Keys = std::vector<std::pair<std::string, std::string>>;

  Keys& keysOf(const std::string& section)
  {
    for (auto& [name, keys] : sections_)
      if (strcasecmp(name.c_str(), section.c_str()) == 0) return keys;
    return sections_.emplace_back(section, Keys()).second;
  }

  std::vector<std::pair<std::string, Keys>> sections_;
};

/// What the configuration file says of the map, with the fixed and the best settings over it.
std::string bestConfig(const TuneOptions& options, const SearchSpace& space, const TuneReport& report)
{
  const std::string prefix = "map_" + report.mapName + "_00_";
  IniSections ini;
  ini.set("map", report.mapName + "_count", "1");
  if (!options.map.configPath.empty())
  {
    const mrpt::config::CConfigFile config(options.map.configPath);
    std::vector<std::string> sections;
    config.getAllSections(sections);
    for (const std::string& section : sections)
    {
      if (strncasecmp(section.c_str(), prefix.c_str(), prefix.size()) != 0) continue;
      std::vector<std::string> keys;
      config.getAllKeys(section, keys);
      for (const std::string& key : keys)
        ini.set(section, key, withoutComment(config.read_string(section, key, "")));
    }
  }
  const TunedMap& best = report.maps.front();
  for (const auto* settings : {&space.fixed, &best.settings})
    for (const std::string& text : *settings)
    {
      const Setting setting = parseSetting(text);
      ini.set(prefix + setting.section, setting.key, setting.text);
    }
  return mrpt::format("# The best of %zu settings by %s log loss: %.4f over %llu cells of %zu scans.\n",
                      report.maps.size(), options.prequential ? "prequential" : "held-out",
                      *best.scores.all.logLoss, static_cast<unsigned long long>(best.scores.all.cells()),
                      report.scored) +
         "#   lamap build -i LOG -c THIS -o MAP.lamap.gz\n" + ini.text();
}
}  // namespace

TuneReport tuneMap(const TuneOptions& options, const ProgressSink& progress)
{
  requireLegalOptions(options);
  const SearchSpace space = searchSpaceOf(options.map.settings);
  Search search(options, candidatesOf(options, space));
  const auto sources = openInputs(options.inputs);

  TuneReport report;
  report.mapName = search.candidates().front()->name();
  report.stopped = !visitScans(sources, options.inputs.shouldStop, progress,
                               [&](const ScanItem& item) { search.take(item); });
  report.scored = search.scored();
  report.inputs = reportsOf(sources);
  if (report.stopped) return report;

  const InsertionTally& inserted = search.candidates().front()->inserted();
  if (report.scored == 0)
    throw std::runtime_error(
        "too few scans: " + std::to_string(search.mostScans()) + " usable ones of a sensor, " +
        (options.prequential ? "2 are needed"
                             : std::to_string(options.every) + " are needed to hold one out") +
        reasonsOf(inserted));
  search.finish();
  for (size_t i = 0; i < space.combinations.size(); ++i)
    report.maps.push_back({space.combinations[i], search.candidates()[i]->score()});
  if (report.maps.front().scores.all.cells() == 0)
    throw std::runtime_error("the scans that are scored show neither hits nor free space");
  if (inserted.usedCount() == 0)
    throw std::runtime_error("not one scan that the map takes" + reasonsOf(inserted));
  report.scans = inserted;
  std::stable_sort(report.maps.begin(), report.maps.end(),
                   [](const TunedMap& a, const TunedMap& b)
                   { return *a.scores.all.logLoss < *b.scores.all.logLoss; });
  if (!options.outPath.empty())
  {
    writeFileAtomically(options.outPath, bestConfig(options, space, report));
    report.outPath = options.outPath;
  }
  return report;
}

void printTuning(const TuneReport& report, std::ostream& out)
{
  out << mrpt::format("%zu settings of %s, scored by %zu scans; best first\n", report.maps.size(),
                      report.mapName.c_str(), report.scored);
  out << "  log loss     AUC   Brier  calibration error  observed  settings\n";
  for (const TunedMap& map : report.maps)
  {
    const Scores& scores = map.scores.all;
    out << mrpt::format("  %8.4f  %6s  %.4f  %17.4f  %6.1f %%  ", *scores.logLoss,
                        scores.areaUnderRoc ? mrpt::format("%.4f", *scores.areaUnderRoc).c_str() : "-",
                        *scores.brier, *scores.calibrationError, 100 * map.scores.observedShare());
    for (size_t i = 0; i < map.settings.size(); ++i) out << (i > 0 ? " " : "") << map.settings[i];
    out << "\n";
  }
  for (const auto& [what, count] : report.scans.leftOut)
    out << "  left out: " << count << " " << what.first << ": " << what.second << "\n";
  if (!report.outPath.empty()) out << "the best settings are saved to " << report.outPath << "\n";
}

nlohmann::ordered_json tuningJson(const TuneReport& report)
{
  nlohmann::ordered_json json;
  json["map"] = report.mapName;
  json["scoredScans"] = report.scored;
  json["output"] = report.outPath;
  json["scoring"] = scoringJson();
  json["candidates"] = nlohmann::ordered_json::array();
  for (const TunedMap& map : report.maps)
    json["candidates"].push_back({{"settings", map.settings}, {"scores", scoresJson(map.scores)}});
  return json;
}

}  // namespace lamap::tools
