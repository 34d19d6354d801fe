#pragma once

#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <mrpt/maps/CMetricMap.h>
#include <mrpt/maps/TMetricMapInitializer.h>

#include <string>
#include <vector>

namespace lamap::tools
{
/** Which map to make, and its options. */
struct MapRequest
{
  /// Alias or class name, with or without its namespace; empty: the one that the file counts.
  std::string mapName;
  /** An .ini file with `[map]`, `<alias>_count=1` and `[map_<alias>_00_creationOpts]` and so on, as
   * RawLogViewer takes it; empty: none. */
  std::string configPath;
  /// "section.key=value", e.g. "insertOpts.maxRange=30"; over what the file says. No key twice.
  std::vector<std::string> settings;
  /// The same over the settings, which hold for other maps, too.
  std::vector<std::string> ownSettings{};
};

/// A setting taken apart. @throws UsageError unless it is "section.key=value" with none of the three empty.
struct Setting
{
  std::string section;
  std::string key;
  std::string text;
};
[[nodiscard]] Setting parseSetting(const std::string& setting);

/// @throws UsageError naming the second setting of a key, whose case does not count
void requireDifferentKeys(const std::vector<std::string>& settings);

/// The settings of an .ini file for its first map of a name, in the file's order.
[[nodiscard]] std::vector<Setting> settingsIn(const std::string& configPath, const std::string& mapName);

/// Every name under which MRPT knows a map class: aliases, class names with and without namespace.
[[nodiscard]] std::vector<std::string> registeredMapNames();
/// The names of one class.
[[nodiscard]] std::vector<std::string> namesOfSameMap(const std::string& registeredName);
/// Whether a registered name is that of one of this library's maps.
[[nodiscard]] bool isLearnedMap(const std::string& registeredName);

/// A request with its name and options resolved.
struct MapDefinition
{
  std::string name;  ///< the registered name by which the map was chosen
  mrpt::maps::TMetricMapInitializer::Ptr definition;
};

/** The maps that an .ini file counts, by their registered names.
 * @throws std::runtime_error naming the file if it cannot be read, or what it counts is no map */
[[nodiscard]] std::vector<std::string> mapsCountedIn(const std::string& configPath);

/** Resolves a request.
 *
 * Stricter than MRPT, whose loaders skip what they do not know: a section, key or map name that nothing reads
 * and a value that is not of the kind its reader takes it for are errors that name the nearest right one.
 * @throws UsageError for the name and the settings, std::runtime_error for the file */
[[nodiscard]] MapDefinition readMapDefinition(const MapRequest& request);

/// @throws std::runtime_error naming the map if it cannot be made so.
[[nodiscard]] mrpt::maps::CMetricMap::Ptr createMap(const MapDefinition& definition);

}  // namespace lamap::tools
