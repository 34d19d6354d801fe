#pragma once

#include <lamap_mrpt/files/payload.h>
#include <mrpt/maps/CMetricMap.h>
#include <mrpt/serialization/CSerializable.h>

#include <cstdint>
#include <optional>
#include <string>

namespace lamap
{
/** Saves a map as one object in MRPT's archive format, compressed by gzip; by convention `name.lamap.gz`.
 *
 * Any program that has the map's library loaded reads it by
 * `mrpt::serialization::archiveFrom(mrpt::io::CFileGZInputStream(path)) >> CSerializable::Ptr`.
 *
 * The file appears at its place only when it is whole (AtomicFile): on any error what stood there before
 * stays. The same map gives the same bytes; no time and no name is stored.
 *
 * @param map any metric map whose class is registered with MRPT, this library's or another's.
 * @throws std::runtime_error naming the file and the reason: no such folder, not writable, disk full …
 */
void saveMapFile(const mrpt::maps::CMetricMap& map, const std::string& path);

/** Saves any object in the same way, e.g. a scene. @param path of a file whose place AtomicFile minds
 * @throws std::runtime_error with the reason alone */
void writeCompressed(const mrpt::serialization::CSerializable& object, const std::string& path);

/** The largest content of a map file of this size that is inflated [bytes]: 48 MiB and 40 times its size, for
 * no map compresses as well; never more than memoryForContent(). The environment variable
 * LAMAP_MAX_CONTENT_MIB replaces the former. @throws as limitFromEnvironment() */
[[nodiscard]] uint64_t mostContentOf(uint64_t fileBytes);

/// What a map file holds.
struct MapFile
{
  mrpt::maps::CMetricMap::Ptr map;  ///< never null
  uint8_t version = 0;              ///< of the format that its class gave it
};

/** Loads what saveMapFile() wrote, inflating the file once.
 *
 * Damaged content never reaches a parser: this library's maps are checked by their own CRC-32 as they are
 * read; a map of another class, whose parser may trust what it reads, is inflated whole and checked by gzip's
 * CRC-32 first. A file that uncompresses to more than the limit is refused; one that says so itself, before
 * anything is inflated.
 *
 * @param limit_bytes largest content, uncompressed; nothing: mostContentOf() the file's size.
 * @throws std::runtime_error naming the file, what is wrong and what would be right: missing, a folder,
 * empty, not gzip, truncated, damaged, followed by other bytes, not an MRPT object, an object of a class that
 * is not loaded or that is no map, of a newer version, or with content that its class refuses.
 */
[[nodiscard]] MapFile readMapFile(const std::string& path,
                                  std::optional<uint64_t> limit_bytes = std::nullopt);

/// Only the map of it. @throws as readMapFile()
[[nodiscard]] mrpt::maps::CMetricMap::Ptr loadMapFile(const std::string& path,
                                                      std::optional<uint64_t> limit_bytes = std::nullopt);

}  // namespace lamap
