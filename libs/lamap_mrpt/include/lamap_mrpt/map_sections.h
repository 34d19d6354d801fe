#pragma once

#include <lamap_mrpt/CLearnedMap.h>
#include <mrpt/config/CConfigFileBase.h>
#include <mrpt/maps/metric_map_types.h>

#include <string>

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

/// Keys in creationOpts that MRPT reads for every map, all of them yes or no.
[[nodiscard]] std::vector<std::string> genericMapKeys();

/// MRPT's options of every map, for the content of files.
void writeGenericParams(const mrpt::maps::TMapGenericParams& params, ByteWriter& out);
void readGenericParams(mrpt::maps::TMapGenericParams& params, ByteReader& in);

/// "format version 3; this program reads version 1 …", for a version that is not read here.
[[noreturn]] void refuseVersion(const char* className, uint8_t version, uint8_t newestKnown);

}  // namespace lamap
