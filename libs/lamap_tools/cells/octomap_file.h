#pragma once

#include <lamap_tools/cells/cell_map.h>
#include <lamap_tools/cells/cell_table.h>

#include <iosfwd>
#include <memory>
#include <string>

namespace lamap::tools
{
/// Whether the name ends in .ot or .bt (in any case).
[[nodiscard]] bool isOctomapFile(const std::string& path);

/** Reads OctoMap's files: `.ot` (OcTree or ColorOcTree, probabilities) or `.bt` (occupied or free only).
 * States are OctoMap's: occupied if P ≥ 0.5, else free.
 * @throws std::runtime_error naming the file and what is wrong: missing, not OctoMap's, truncated, another
 * tree. */
[[nodiscard]] std::unique_ptr<CellMap> readOctomapFile(const std::string& path);

/** Writes `.ot`: each cell's P(occupied) as log-odds (float, as in OctoMap; not clamped), or `.bt`: occupied
 * and free cells, without unknown ones. Same resolution, same cells; equal siblings are joined, which is
 * lossless in OctoMap.
 * @throws std::runtime_error if a cell is beyond OctoMap's ±32,768 cells (names the extent), if there is no
 * cell to write, or if the file cannot be written. */
void writeOctomapFile(const CellMap& map, const std::string& path);

/// @throws std::runtime_error naming the path and the extent if a cell is beyond OctoMap's ±32,768 cells
void requireOctomapKeys(const CellExtent& extent, const std::string& path, double resolution_m);

/// The same into a stream. @param path  names the format, and the file in messages
void writeOctomap(const CellMap& map, const std::string& path, std::ostream& out);

}  // namespace lamap::tools
