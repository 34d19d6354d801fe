#pragma once

#include <lamap_tools/cells/cell_map.h>

#include <memory>
#include <string>

namespace lamap::tools
{
/// Whether the name ends in .ot or .bt (in any case).
[[nodiscard]] bool isOctomapFile(const std::string& path);

/** Reads OctoMap's files: `.ot` (OcTree or ColorOcTree, probabilities) or `.bt` (occupied or free only).
 * States are OctoMap's: occupied where P ≥ 0.5, else free.
 * @throws std::runtime_error naming the file and what is wrong: missing, not OctoMap's, cut short, another
 * tree. */
[[nodiscard]] std::unique_ptr<CellMap> readOctomapFile(const std::string& path);

/** Writes `.ot`: every cell's P(occupied) as log-odds (float, as OctoMap holds it; nothing is clamped), or
 * `.bt`: occupied and free cells, unknown ones left out. Same resolution, same cells; equal siblings are
 * joined, as OctoMap does without loss.
 * @throws std::runtime_error if a cell lies beyond OctoMap's ±32,768 cells (names the extent), if there is no
 * cell to write, or if the file cannot be written. */
void writeOctomapFile(const CellMap& map, const std::string& path);

}  // namespace lamap::tools
