#include <lamap_mrpt/files/atomic_file.h>
#include <lamap_mrpt/files/map_file.h>
#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <lamap_tools/cells/cell_map.h>
#include <lamap_tools/cells/octomap_file.h>
#include <lamap_tools/commands/build_notes.h>
#include <lamap_tools/commands/map_build.h>
#include <lamap_tools/files/file_names.h>
#include <lamap_tools/files/usage_error.h>
#include <lamap_tools/report/counted.h>
#include <mrpt/core/format.h>
#include <mrpt/maps/COctoMap.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>

namespace lamap::tools
{
using mrpt::maps::CMetricMap;

namespace
{
bool isOctree(const std::string& path)
{
  return endsWith(path, ".ot");
}

void requireOutputName(const std::string& path)
{
  if (endsWith(path, ".lamap.gz") || isOctree(path)) return;
  throw UsageError("-o " + path + ": the name must end in .lamap.gz, or with -m octoMap in .ot");
}

std::string valueOf(const CLearnedMap& map, const Setting& setting)
{
  for (const OptionValue& option : map.optionValues())
    if (option.section == setting.section && option.key == setting.key) return option.text;
  return "something else";
}

/// @throws UsageError or std::runtime_error (for the file) if a setting is not what the saved map has.
void requireSameOptions(const CLearnedMap& map, const BuildOptions& options, const std::string& nameInFile)
{
  const auto conflict = [&](const Setting& setting) -> std::string
  {
    const std::string name = setting.section + "." + setting.key;
    if (map.optionIs(setting.section, setting.key, setting.text)) return "";
    return name + "=" + setting.text + ", but " + options.ontoPath + " was made with " + name + "=" +
           valueOf(map, setting) + ": a saved map is continued with its own options";
  };
  if (!options.map.configPath.empty())
    for (const Setting& setting : settingsIn(options.map.configPath, nameInFile))
      if (const std::string text = conflict(setting); !text.empty())
        throw std::runtime_error(options.map.configPath + ": " + text);
  requireDifferentKeys(options.map.settings);
  for (const std::string& text : options.map.settings)
    if (const std::string what = conflict(parseSetting(text)); !what.empty()) throw UsageError("-s " + what);
}

constexpr const char* kOlderRaysNote =
    "this map was begun by a version in which rays without a return were free up to insertOpts.maxRange, "
    "whatever "
    "the sensor's own range; from here on they end at the sensor's range and at the returns beside them";

CMetricMap::Ptr savedMap(const BuildOptions& options, std::vector<std::string>& notes)
{
  const MapFile file = readMapFile(options.ontoPath);
  const CMetricMap::Ptr& map = file.map;
  const auto learned = std::dynamic_pointer_cast<CLearnedMap>(map);
  if (!learned)
    throw std::runtime_error(options.ontoPath + ": its map is a " + map->GetRuntimeClass()->className +
                             "; only maps of this library keep all that is needed to continue them");
  std::string nameInFile = learned->alias();
  if (!options.map.mapName.empty() || !options.map.configPath.empty())
  {
    MapRequest request = options.map;
    request.settings.clear();  // judged by the saved map itself
    const MapDefinition wanted = readMapDefinition(request);
    const std::vector<std::string> names = namesOfSameMap(wanted.name);
    if (std::find(names.begin(), names.end(), learned->alias()) == names.end())
      throw UsageError(options.ontoPath + ": its map is of the kind " + learned->alias() + ", not " +
                       wanted.name);
    nameInFile = wanted.name;
  }
  requireSameOptions(*learned, options, nameInFile);
  constexpr uint8_t kFirstWithBoundedRays = 2;
  if (file.version < kFirstWithBoundedRays) notes.push_back(options.ontoPath + ": " + kOlderRaysNote);
  return map;
}

CMetricMap::Ptr startingMap(const BuildOptions& options, std::vector<std::string>& notes)
{
  CMetricMap::Ptr map =
      options.ontoPath.empty() ? createMap(readMapDefinition(options.map)) : savedMap(options, notes);
  if (const auto learned = std::dynamic_pointer_cast<CLearnedMap>(map))
    learned->setThreadCount(options.threads);
  if (isOctree(options.outPath) && !std::dynamic_pointer_cast<mrpt::maps::COctoMap>(map))
    throw UsageError("-o " + options.outPath + ": .ot is for octoMap; a " +
                     map->GetRuntimeClass()->className +
                     " is saved as .lamap.gz, and `lamap export` makes an .ot of it");
  return map;
}

void save(const CMetricMap::Ptr& map, const std::string& path)
{
  if (isOctree(path))
    writeOctomapFile(*cellsOf(map), path);
  else
    saveMapFile(*map, path);
}

/// Some maps train their model on all scans when they are first asked.
/// @param consequence  of a failure, for its message
void train(const CMetricMap& map, size_t scans, const std::string& consequence)
{
  const auto* learned = dynamic_cast<const CLearnedMap*>(&map);
  if (learned == nullptr) return;
  try
  {
    (void)learned->estimateAt({0, 0, 0});
  }
  catch (const std::length_error& error)
  {
    throw std::runtime_error("the model of " + counted(scans, "scan") +
                             " cannot be trained: " + error.what() + consequence +
                             ". Fewer of them: insertOpts.rayDecimation, freeResolution, "
                             "or trainingPoints = cells");
  }
}

/// @throws std::runtime_error naming what could not be read of an input
void requireUndamaged(const ScanSource& source, const std::string& consequence)
{
  if (!source.damages().empty())
    throw std::runtime_error(source.path() + ": " + source.damages().front() + consequence);
}

std::string reasonsOf(const BuildReport& report)
{
  std::string reasons = reasonsOf(report.scans);
  for (const InputReport& input : report.inputs)
  {
    for (const std::string& damage : input.damages) reasons += "\n  " + input.path + ": " + damage;
    if (input.damages.empty() && report.scans.leftOut.empty())
      reasons += "\n  " + input.path + ": holds no observations";
  }
  return reasons;
}
using MapSink = std::function<void(CMetricMap&)>;

/// @param consequence  of a failure, for its message
BuiltMap build(const BuildOptions& options, const ProgressSink& progress, const MapSink& prepare,
               const std::string& consequence)
{
  BuiltMap built;
  BuildReport& report = built.report;
  built.map = startingMap(options, report.notes);
  CMetricMap& map = *built.map;
  if (prepare) prepare(map);
  const auto sources = openInputs(options.inputs);

  report.mapClass = map.GetRuntimeClass()->className;
  report.outPath = options.outPath;
  const auto begin = std::chrono::steady_clock::now();
  ScanInserter inserter(map, options.strict);
  BuildNotes notes(map);
  const std::string strictly = consequence.empty() ? "" : consequence + " (--strict)";
  report.stopped = !visitScans(sources, options.inputs.shouldStop, progress,
                               [&](const ScanItem& item, const ScanSource& source)
                               {
                                 notes.look(item, source);
                                 if (options.strict) requireUndamaged(source, strictly);
                                 inserter.insert(item);
                                 notes.inserted();
                               });
  if (options.strict)
    for (const auto& source : sources) requireUndamaged(*source, strictly);
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  report.scans = inserter.tally();
  if (const auto* learned = dynamic_cast<const CLearnedMap*>(&map)) report.rays = learned->rayCounts();
  report.inputs = reportsOf(sources);

  if (report.scans.usedCount() == 0)
  {
    if (report.stopped) return built;
    throw std::runtime_error("not one usable scan" + consequence + reasonsOf(report));
  }
  for (const auto& found : {jointNotesOf(sources), notes.notes()})
    report.notes.insert(report.notes.end(), found.begin(), found.end());
  train(map, report.scans.usedCount(), consequence);
  report.stopped = report.stopped || options.inputs.shouldStop();
  return built;
}
}  // namespace

BuiltMap buildInMemory(const BuildOptions& options, const ProgressSink& progress, const MapSink& prepare)
{
  BuildOptions unsaved = options;
  unsaved.outPath.clear();
  return build(unsaved, progress, prepare, "");
}

BuildReport buildMap(const BuildOptions& options, const ProgressSink& progress)
{
  requireOutputName(options.outPath);
  {
    const AtomicFile placeIsWritable(options.outPath);
  }
  auto [map, report] = build(options, progress, nullptr, "; nothing is written");
  if (report.scans.usedCount() == 0) return report;
  save(map, options.outPath);
  report.saved = true;
  if (!isOctree(options.outPath) && std::dynamic_pointer_cast<mrpt::maps::COctoMap>(map))
    report.notes.emplace_back(
        "MRPT saves its octoMap's cells as free or occupied only; an .ot keeps their probabilities");
  return report;
}

/// What became of the rays, by what their ends mean.
void printRays(const RayCounts& rays, std::ostream& out)
{
  if (rays.used() == 0) return;
  out << "  rays: " << rays.hits << " with a hit";
  if (const size_t cut = rays.freeOnly - std::min(rays.freeOnly, rays.noReturn); cut > 0)
    out << ", " << cut << " cut at the maximum range";
  out << "\n";
  if (rays.noReturn > 0)
    out << mrpt::format(
        "  rays without a return: %zu used as free space, for %.2f m on average, %.2f m at most\n",
        rays.noReturn, rays.noReturnLength_m / static_cast<double>(rays.noReturn), rays.noReturnLongest_m);
  if (rays.narrowed > 0)
    out << "  rays taken as narrow: " << rays.narrowed
        << " of beams too far apart for beamWidth = spacing; set maxRange\n";
  const auto printUnused = [&](size_t count, const char* why)
  {
    if (count > 0) out << "  rays not used: " << count << " " << why << "\n";
  };
  printUnused(rays.unbounded, "without a return (not wanted, or without a range to end at)");
  printUnused(rays.dropped, "dropped or called invalid by the sensor");
  printUnused(rays.tooNear, "nearer than the minimum range, or on the sensor itself");
  printUnused(rays.notFinite, "not finite");
  if (rays.tooLong > 0)
    out << "  rays not used: " << rays.tooLong
        << mrpt::format(" longer than %.0f cells, up to %.1f m; set maxRange, or a larger resolution\n",
                        kLongestRay_cells, rays.tooLongLongest_m);
  printUnused(rays.outside, "beyond what cells can address, or too far from the scan's first sensor");
}

void printReport(const BuildReport& report, std::ostream& out)
{
  const size_t used = report.scans.usedCount();
  out << counted(used, "scan") << mrpt::format(" in %.1f s", report.seconds);
  if (report.seconds > 0)
    out << mrpt::format(" (%.1f per second)", static_cast<double>(used) / report.seconds);
  out << "\n";
  for (const auto& [kind, count] : report.scans.used) out << "  used: " << count << " " << kind << "\n";
  printRays(report.rays, out);
  printLeftOut(report.scans, out);
  for (const InputReport& input : report.inputs)
  {
    for (const std::string& note : input.notes) out << "  " << input.path << ": " << note << "\n";
    for (const std::string& damage : input.damages)
      out << "  " << input.path << ": cut short or damaged: " << damage << "\n";
  }
  for (const std::string& note : report.notes) out << "  " << note << "\n";
  if (report.saved)
    out << report.mapClass << " saved to " << report.outPath << "\n";
  else
    out << "nothing is saved\n";
}

Json reportJson(const BuildReport& report)
{
  Json json;
  json["map"] = report.mapClass;
  json["output"] = report.outPath;
  json["saved"] = report.saved;
  json["stopped"] = report.stopped;
  json["scans"] = report.scans.usedCount();
  json["seconds"] = report.seconds;
  json["used"] = report.scans.used;
  json["rays"] = {{"hits", report.rays.hits},
                  {"free_only", report.rays.freeOnly},
                  {"no_return", report.rays.noReturn},
                  {"no_return_length_m", report.rays.noReturnLength_m},
                  {"no_return_longest_m", report.rays.noReturnLongest_m},
                  {"narrowed", report.rays.narrowed},
                  {"unbounded", report.rays.unbounded},
                  {"dropped", report.rays.dropped},
                  {"too_near", report.rays.tooNear},
                  {"not_finite", report.rays.notFinite},
                  {"too_long", report.rays.tooLong},
                  {"too_long_longest_m", report.rays.tooLongLongest_m},
                  {"outside", report.rays.outside}};
  json["notes"] = report.notes;
  json["failed"] = report.scans.failed;
  json["left_out"] = leftOutJson(report.scans);
  json["inputs"] = Json::array();
  for (const InputReport& input : report.inputs)
    json["inputs"].push_back({{"path", input.path}, {"notes", input.notes}, {"damages", input.damages}});
  return json;
}

}  // namespace lamap::tools
