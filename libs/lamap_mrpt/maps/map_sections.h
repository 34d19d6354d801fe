#pragma once

#include <lamap_mrpt/learned_map/CLearnedMap.h>
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

/** Refuses sections that begin like a map's but that nothing reads.
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

/** What a source sets, other than the preset does, though it has no effect beside the map's other options.
 * @return a message each, naming the option, its text, and on what its effect depends */
[[nodiscard]] std::vector<std::string> settingsWithoutEffect(const mrpt::config::CConfigFileBase& source,
                                                             const std::vector<LoadedGroup>& groups);

/// Tells people, on the standard error output; what was told before in this process is not told again.
void warnOnce(const std::string& message);

/// Keys in creationOpts that MRPT reads for every map, all of them yes or no.
[[nodiscard]] std::vector<std::string> genericMapKeys();

/// The options of a map that do not depend on its learner.
struct StoredOptions
{
  CLearnedMap::TLikelihoodOptions likelihood;
  CLearnedMap::TRenderingOptions rendering;
  mrpt::maps::TMapGenericParams generic;

  void handTo(CLearnedMap& map) const;
};

/// What follows a map's cells in its files: its insertion options, and those that do not depend on the
/// learner.
void writeOptions(const TOptionGroup& insertion, const CLearnedMap& map, ByteWriter& out);
/// @throws std::runtime_error as TOptionGroup::read().
[[nodiscard]] StoredOptions readOptions(TOptionGroup& insertion, ByteReader& in);

/// As CLearnedMap::visitOptionGroups() is to: the four groups, each with a new one of its class.
template <typename Creation, typename Insertion>
void visitGroups(const Creation& creation, const Insertion& insertion, const CLearnedMap& map,
                 const CLearnedMap::VisitGroup& visit)
{
  Creation newCreation;
  visit(creation, newCreation);
  Insertion newInsertion;
  visit(insertion, newInsertion);
  CLearnedMap::TLikelihoodOptions newLikelihood;
  visit(map.likelihoodOptions, newLikelihood);
  CLearnedMap::TRenderingOptions newRendering;
  visit(map.renderingOptions, newRendering);
}

/// "format version 3; this program reads version 1 …", for a version that is not read here.
[[noreturn]] void refuseVersion(const char* className, uint8_t version, uint8_t newestKnown);

}  // namespace lamap
