#pragma once

#include <lamap_mrpt/options/option_group.h>
#include <lamap_tools/cells/cell_map.h>
#include <lamap_tools/cells/cell_table.h>
#include <lamap_tools/report/json.h>

#include <array>
#include <cstdint>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

namespace lamap::tools
{
/// Result of one walk over a map's cells.
struct CellSummary
{
  double resolution_m = 0;
  std::optional<CellExtent> extent;  ///< nothing for an empty map
  uint64_t free = 0;
  uint64_t occupied = 0;
  uint64_t unknown = 0;  ///< observed, but neither free nor occupied
  std::vector<std::string> evidenceNames;
  /// Sums over all cells, in the order of evidenceNames (BGK: each cell's prior included).
  std::array<double, 2> evidenceSums{};

  [[nodiscard]] uint64_t observed() const { return free + occupied + unknown; }
};

[[nodiscard]] CellSummary summarizeCells(const CellMap& map);

/// Everything that `lamap info` reports of a map file.
struct MapInfo
{
  std::string path;
  uint64_t fileBytes = 0;
  std::string className;
  std::string alias;                 ///< of our own maps, else empty
  std::optional<int> formatVersion;  ///< of the class in MRPT's archive; nothing for OctoMap's files
  std::string description;           ///< MRPT's own maps: their asString(), may be empty
  std::optional<CellSummary> cells;
  /// What the map reports of itself: blocks, memory, …
  std::vector<CLearnedMap::Fact> facts;
  /// Of our own maps: every option.
  std::vector<OptionValue> options;
};

/// @throws std::runtime_error as openMap.
[[nodiscard]] MapInfo readMapInfo(const std::string& path);

/// For people: one fact per line, with units.
void printMapInfo(const MapInfo& info, std::ostream& out);

/// For scripts: the same facts, numbers as numbers, lengths in metres. A fact's unit stands in "units" under
/// its name.
[[nodiscard]] Json mapInfoJson(const MapInfo& info);

}  // namespace lamap::tools
