#pragma once

#include <lamap_core/grid/cell.h>
#include <lamap_tools/cells/cell_map.h>

#include <Eigen/Geometry>
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
  /// The two corners [m].
  [[nodiscard]] Eigen::AlignedBox3d box_m(double resolution_m) const;
};

/// Of the cells that are shown; empty if there are none.
using ShownCells = std::function<bool(const CellIndex&, const CellEstimate&)>;
[[nodiscard]] std::optional<CellExtent> cellExtent(const CellMap& map, const ShownCells& shown = {});

/** Calls the visitor for every cell in table order, holding about maxRowsInMemory rows at a time: the map is
 * walked once to count cells per layer, then once for each group of layers that fits (a single layer is never
 * divided). */
void visitCellsSorted(const CellMap& map, const std::function<void(const CellRow&)>& visitor,
                      size_t maxRowsInMemory = 8'000'000);

}  // namespace lamap::tools
