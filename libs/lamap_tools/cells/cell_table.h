#pragma once

#include <lamap_core/grid/cell.h>
#include <lamap_tools/cells/cell_map.h>

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace lamap::tools
{
struct CellRow
{
  CellIndex index;
  CellEstimate estimate;
};

/// Sorted by z, then y, then x.
[[nodiscard]] bool inTableOrder(const CellIndex& a, const CellIndex& b);

/// The smallest box of cells around all cells of a map, both ends inside.
struct CellExtent
{
  CellIndex first;
  CellIndex last;

  void include(const CellIndex& cell);
};

/// Nothing for a map without cells.
[[nodiscard]] std::optional<CellExtent> cellExtent(const CellMap& map);

/** All finest cells of a map in memory, sorted by z, y, x: for lookups and for whoever needs them in order.
 * Plain data; const methods may be called from several threads. */
struct CellTable
{
  std::string className;                   ///< of the map it was read from
  double resolution_m = 0;                 ///< edge of a cell [m]
  std::vector<std::string> evidenceNames;  ///< of CellEstimate::evidence
  std::vector<CellRow> rows;               ///< in table order, each cell once

  /// The row of a cell; nullptr where the map has no evidence.
  [[nodiscard]] const CellRow* find(const CellIndex& cell) const;
};

[[nodiscard]] CellTable readCellTable(const CellMap& map);
/// @throws as openCellMap.
[[nodiscard]] CellTable readCellTable(const std::string& path);

/** Calls the visitor for every cell in table order, holding about maxRowsInMemory rows at a time: the map is
 * walked once to count cells a layer, then once for each group of layers that fits (a single layer is never
 * divided). */
void visitCellsSorted(const CellMap& map, const std::function<void(const CellRow&)>& visitor,
                      size_t maxRowsInMemory = 8'000'000);

}  // namespace lamap::tools
