#pragma once

#include <lamap_mrpt/options/option_group.h>
#include <mrpt/config/CConfigFileBase.h>
#include <mrpt/maps/metric_map_types.h>

#include <string>
#include <vector>

namespace lamap
{
/// Ends of the sections that hold a map's options.
inline constexpr const char* kCreationSection = "_creationOpts";
inline constexpr const char* kInsertSection = "_insertOpts";
inline constexpr const char* kLikelihoodSection = "_likelihoodOpts";
inline constexpr const char* kRenderSection = "_renderOpts";

// The sections of an .ini file that describe one map.

/** Refuses sections that begin like those of a map but that nothing reads.
 * @param prefix e.g. "map_bgkMap_00"
 * @throws std::invalid_argument naming the file, the section and the nearest right one. */
void requireKnownSections(const mrpt::config::CConfigFileBase& source, const std::string& prefix);

/// A group of options as a map will have it, and as its preset leaves it.
struct LoadedGroup
{
  std::string section;
  const TOptionGroup* loaded = nullptr;
  const TOptionGroup* preset = nullptr;
};

/** Refuses an option that stands in the section of another group of its map.
 * @throws std::invalid_argument naming file, key, section and the right section */
void requireOptionsInTheirSections(const mrpt::config::CConfigFileBase& source,
                                   const std::vector<LoadedGroup>& groups);

/** Options that a source sets, differently from the preset, although they have no effect with the map's other
 * options.
 * @return one message for each, naming the option, its text, and what its effect depends on */
[[nodiscard]] std::vector<std::string> settingsWithoutEffect(const mrpt::config::CConfigFileBase& source,
                                                             const std::vector<LoadedGroup>& groups);

/// Prints a warning on the standard error output, each message once per process.
void warnOnce(const std::string& message);

/// Keys in creationOpts that MRPT reads for every map, all of them yes or no.
[[nodiscard]] std::vector<std::string> genericMapKeys();

/// Writes these keys without padding, so that this program and MRPT find them in the same configuration.
void saveGenericParams(const mrpt::maps::TMapGenericParams& params, mrpt::config::CConfigFileBase& target,
                       const std::string& section);

}  // namespace lamap
