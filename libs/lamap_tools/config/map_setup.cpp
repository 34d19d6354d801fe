#include <lamap_core/options/nearest_name.h>
#include <lamap_mrpt/compat/mrpt_compat.h>
#include <lamap_mrpt/options/option_group.h>
#include <lamap_tools/config/ini_lines.h>
#include <lamap_tools/config/map_setup.h>
#include <lamap_tools/config/recorded_config.h>
#include <lamap_tools/files/text_fields.h>
#include <lamap_tools/files/usage_error.h>
#include <mrpt/config/CConfigFile.h>
#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/maps/TMetricMapTypesRegistry.h>
#include <mrpt/maps/registerAllClasses.h>
#include <mrpt/system/string_utils.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>

namespace lamap::tools
{
using mrpt::config::CConfigFileBase;
using mrpt::maps::TMetricMapInitializer;

namespace
{
constexpr const char* kSection = "map";

TMetricMapInitializer::Ptr emptyDefinition(const std::string& registeredName)
{
  return TMetricMapInitializer::Ptr(TMetricMapInitializer::factory(registeredName));
}

/// Map names that a file counts, with their counts.
using MapCounts = std::map<std::string, long>;

/// @throws std::runtime_error for a key of [map] that is not `<name>_count`, or whose value is not a whole
/// number ≥ 0.
MapCounts countsIn(const CConfigFileBase& config)
{
  MapCounts counts;
  const std::vector<std::string> names = registeredMapNames();
  std::vector<std::string> countKeys;
  countKeys.reserve(names.size());
  for (const std::string& name : names) countKeys.push_back(name + "_count");
  std::vector<std::string> keys;
  config.getAllKeys(kSection, keys);
  for (const std::string& key : keys)
  {
    const auto known =
        std::find_if(countKeys.begin(), countKeys.end(),
                     [&](const std::string& other) { return mrpt::system::strCmpI(key, other); });
    if (known == countKeys.end())
      throw std::runtime_error("[map] " + key + ": no map of this name; " + suggestionFor(key, countKeys));
    const std::string text = withoutComment(config.read_string(kSection, key, ""));
    const auto count = numberIn<long>(text);
    if (!count || *count < 0)
      throw std::runtime_error("[map] " + key + " = " + text + ": must be a whole number, 0 or 1");
    if (*count > 0) counts[names[static_cast<size_t>(known - countKeys.begin())]] = *count;
  }
  return counts;
}

std::string listOf(const MapCounts& counts)
{
  std::vector<std::string> names;
  for (const auto& entry : counts) names.push_back(entry.first);
  return joined(names);
}

/// The name of the map to build, as the file spells it. @param wanted  a registered name, or empty
std::string chooseMap(const MapCounts& counts, const std::string& wanted)
{
  if (counts.empty())
  {
    if (!wanted.empty()) return wanted;
    throw std::runtime_error(
        "asks for no map; expected <map>_count = 1 in section [map], e.g. bgkMap_count = 1");
  }
  const std::vector<std::string> names = wanted.empty() ? std::vector<std::string>() : namesOfSameMap(wanted);
  MapCounts fitting;
  for (const auto& [name, count] : counts)
    if (wanted.empty() || std::find(names.begin(), names.end(), name) != names.end()) fitting[name] = count;
  if (fitting.empty()) throw std::runtime_error("[map] asks for " + listOf(counts) + ", not for " + wanted);
  if (fitting.size() > 1)
    throw std::runtime_error("[map] asks for several maps (" + listOf(fitting) + "): choose one with -m");
  const auto& [name, count] = *fitting.begin();
  if (count != 1)
    throw std::runtime_error("[map] " + name + "_count = " + std::to_string(count) +
                             ": one map is built, it must be 1");
  return name;
}

/// @throws std::runtime_error for a section that neither the map nor another one that the file counts would
/// read.
void requireKnownSections(const CConfigFileBase& config, const MapCounts& counts, const std::string& name,
                          const std::vector<std::string>& askedSections)
{
  std::vector<std::string> expected = askedSections;
  expected.emplace_back(kSection);
  std::vector<std::string> sections;
  config.getAllSections(sections);
  for (const std::string& section : sections)
  {
    if (section.empty() || mrpt::system::strCmpI(section, kSection)) continue;
    const auto belongsTo = [&](const std::string& map)
    {
      const std::string prefix = std::string(kSection) + "_" + map + "_";
      return mrpt::system::strStartsI(section, prefix);
    };
    // Sections of the chosen map are checked key by key elsewhere; here only their number can be wrong.
    const auto isOther = [&](const auto& entry) { return entry.first != name && belongsTo(entry.first); };
    const std::string chosen = std::string(kSection) + "_" + name + "_00_";
    if (mrpt::system::strStartsI(section, chosen)) continue;
    if (std::any_of(counts.begin(), counts.end(), isOther)) continue;
    throw std::runtime_error("section [" + section + "] is not read; " +
                             suggestionFor(section, expected, "[", "]"));
  }
}

/// MRPT's own maps accept any resolution and fail later.
void requireResolution(const RecordedConfig& config, const std::string& prefix)
{
  const std::string section = prefix + "_creationOpts";
  if (!config.keyExists(section, "resolution")) return;
  const std::string text = withoutComment(config.read_string(section, "resolution", ""));
  if (!(std::strtod(text.c_str(), nullptr) > 0))
    throw std::runtime_error("creationOpts.resolution = " + text + ": must be > 0, in m");
}

TMetricMapInitializer::Ptr load(const RecordedConfig& config, const std::string& name, bool fromSettings)
{
  const std::string prefix = std::string(kSection) + "_" + name + "_00";
  auto definition = emptyDefinition(name);
  definition->loadFromConfigFile(config, prefix);
  config.requireAllRead(prefix, fromSettings);
  requireResolution(config, prefix);
  return definition;
}

/// @throws std::runtime_error without the file's name
std::unique_ptr<CConfigFileBase> openConfig(const std::string& path)
{
  if (!std::ifstream(path) || std::filesystem::is_directory(path)) throw std::runtime_error("cannot be read");
  requireAssignments(path, [](const std::string&) { return true; });
  return std::make_unique<mrpt::config::CConfigFile>(path);
}
}  // namespace

Setting parseSetting(const std::string& setting)
{
  const size_t equals = setting.find('=');
  const size_t dot = setting.find('.');
  const bool wellFormed = equals != std::string::npos && dot != std::string::npos && dot > 0 &&
                          dot + 1 < equals && equals + 1 < setting.size();
  if (!wellFormed)
    throw UsageError("-s " + setting + ": expected section.key=value, e.g. insertOpts.maxRange=30");
  return {setting.substr(0, dot), setting.substr(dot + 1, equals - dot - 1), setting.substr(equals + 1)};
}

void requireDifferentKeys(const std::vector<std::string>& settings)
{
  std::set<std::string> keys;
  for (const std::string& text : settings)
  {
    const Setting setting = parseSetting(text);
    const std::string key = setting.section + "." + setting.key;
    if (!keys.insert(mrpt::system::lowerCase(key)).second)
      throw UsageError("-s " + text + ": " + key + " is given twice");
  }
}

std::vector<Setting> settingsIn(const std::string& configPath, const std::string& mapName)
{
  const mrpt::config::CConfigFile config(configPath);
  const std::string prefix = std::string(kSection) + "_" + mapName + "_00_";
  std::vector<Setting> settings;
  std::vector<std::string> sections;
  config.getAllSections(sections);
  for (const std::string& section : sections)
  {
    if (!mrpt::system::strStartsI(section, prefix)) continue;
    std::vector<std::string> keys;
    config.getAllKeys(section, keys);
    for (const std::string& key : keys)
      settings.push_back(
          {section.substr(prefix.size()), key, withoutComment(config.read_string(section, key, ""))});
  }
  return settings;
}

std::vector<std::string> registeredMapNames()
{
  mrpt::maps::registerAllClasses_mrpt_maps();
  std::vector<std::string> names;
  for (const auto& entry : mrpt::maps::internal::TMetricMapTypesRegistry::Instance().getAllRegistered())
    names.push_back(entry.first);
  return names;
}

std::vector<std::string> namesOfSameMap(const std::string& registeredName)
{
  const auto type = emptyDefinition(registeredName)->getMetricMapClassType();
  std::vector<std::string> names;
  for (const std::string& name : registeredMapNames())
    if (emptyDefinition(name)->getMetricMapClassType() == type) names.push_back(name);
  return names;
}

bool isLearnedMap(const std::string& registeredName)
{
  const auto type = emptyDefinition(registeredName)->getMetricMapClassType();
  const auto object = type->createObject();
  return dynamic_cast<const CLearnedMap*>(object.get()) != nullptr;
}

namespace
{
/// A registered name: the name itself, or the class name completed by its namespace.
/// @throws UsageError naming the nearest known name
std::string resolveMapName(const std::string& name)
{
  const std::vector<std::string> names = registeredMapNames();
  if (std::find(names.begin(), names.end(), name) != names.end()) return name;
  for (const std::string& known : names)
  {
    const size_t colon = known.rfind(':');
    if (colon != std::string::npos && known.substr(colon + 1) == name) return known;
  }
  throw UsageError("-m " + name + ": no map of this name; " + suggestionFor(name, names));
}

/// Without names of sections and files, which a user who gives settings has not written.
std::string asSettingsSay(std::string message, const std::string& map)
{
  for (const std::string& part :
       {std::string(kSection) + "_" + map + "_00_", std::string(" of the configuration")})
    for (size_t at = message.find(part); at != std::string::npos; at = message.find(part))
      message.erase(at, part.size());
  return message;
}
}  // namespace

std::vector<std::string> mapsCountedIn(const std::string& configPath)
{
  std::vector<std::string> names;
  try
  {
    for (const auto& entry : countsIn(*openConfig(configPath))) names.push_back(entry.first);
  }
  catch (const std::exception& error)
  {
    throw std::runtime_error(configPath + ": " + compat::messageOf(error));
  }
  return names;
}

MapDefinition readMapDefinition(const MapRequest& request)
{
  if (request.mapName.empty() && request.configPath.empty())
    throw UsageError("which map? Give -m MAP (e.g. -m bgkMap) or -c FILE.ini");
  const std::string wanted = request.mapName.empty() ? "" : resolveMapName(request.mapName);

  MapDefinition result{wanted, nullptr};
  std::unique_ptr<CConfigFileBase> file = std::make_unique<mrpt::config::CConfigFileMemory>();
  if (!request.configPath.empty())
  {
    try
    {
      file = openConfig(request.configPath);
      const MapCounts counts = countsIn(*file);
      // Before the map is chosen: a mistyped [map] is the reason why there is none.
      if (counts.empty()) requireKnownSections(*file, counts, wanted, {});
      result.name = chooseMap(counts, wanted);
      const RecordedConfig config(*file);
      result.definition = load(config, result.name, false);
      requireKnownSections(*file, counts, result.name, config.askedSections());
    }
    catch (const std::exception& error)
    {
      throw std::runtime_error(request.configPath + ": " + compat::messageOf(error));
    }
  }

  RecordedConfig config(*file);
  for (const auto* settings : {&request.settings, &request.ownSettings})
  {
    requireDifferentKeys(*settings);
    for (const std::string& text : *settings)
    {
      const Setting setting = parseSetting(text);
      config.setValue(std::string(kSection) + "_" + result.name + "_00_" + setting.section, setting.key,
                      setting.text);
    }
  }
  try
  {
    result.definition = load(config, result.name, true);
  }
  catch (const std::exception& error)
  {
    throw UsageError("-s " + asSettingsSay(compat::messageOf(error), result.name));
  }
  return result;
}

mrpt::maps::CMetricMap::Ptr createMap(const MapDefinition& definition)
{
  try
  {
    const auto& registry = mrpt::maps::internal::TMetricMapTypesRegistry::Instance();
    return mrpt::maps::CMetricMap::Ptr(registry.factoryMapObjectFromDefinition(*definition.definition));
  }
  catch (const std::exception& error)
  {
    throw std::runtime_error(definition.name + ": " + compat::messageOf(error));
  }
}

}  // namespace lamap::tools
