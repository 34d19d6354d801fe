#pragma once

#include <lamap_tools/cells/cell_table.h>
#include <lamap_tools/export/export_map.h>

#include <cstddef>
#include <string>
#include <vector>

namespace lamap::tools
{
/// What a column of cells of a slice or a projection says.
struct FlatCell
{
  /// Occupied if any of its cells is, else free if any is.
  CellState state = CellState::Unknown;
  /// The largest P(occupied) among its cells of that state; 0.5 of an unknown one.
  float prob = 0.5F;
};

/// A slice or a projection, row by row from the lowest y.
struct FlatCells
{
  CellExtent extent;
  size_t width = 0;
  std::vector<FlatCell> cells;

  [[nodiscard]] size_t height() const { return cells.size() / width; }
};

/** The cells that the heights of the options select: a slice at z_m, or those from zMin_m to zMax_m.
 * @throws std::runtime_error naming the path if there are none, or more than 2^31 columns */
[[nodiscard]] FlatCells flatCellsOf(const CellMap& map, const std::string& path,
                                    const ExportOptions& options);

}  // namespace lamap::tools
