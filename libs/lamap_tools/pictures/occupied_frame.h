#pragma once

#include <lamap_tools/cells/cell_table.h>
#include <lamap_tools/pictures/render_map.h>

#include <functional>
#include <optional>

namespace lamap::tools
{
/** The box of cells that a picture is about: around the occupied cells, few far ones left out.
 *
 * A sensor's stray returns and its rays into the open reach far beyond what was mapped; shown whole, the map
 * would be a dot. The box spans the middle 98 % of the occupied cells along each axis and an eighth more;
 * where that saves less than a quarter, all of them.
 * @param shown  which cells count
 * @return nothing if none of them is occupied */
[[nodiscard]] std::optional<CellExtent> occupiedFrame(const CellMap& map,
                                                      const std::function<bool(const CellIndex&)>& shown);

/// The cells of the box that the options give, at least one along each axis; nothing if they give none.
[[nodiscard]] std::optional<CellExtent> cellsOfBox(const RenderOptions& options, double resolution_m);

[[nodiscard]] inline bool inside(const CellIndex& cell, const CellExtent& extent)
{
  const auto& [a, b] = extent;
  return cell.x >= a.x && cell.x <= b.x && cell.y >= a.y && cell.y <= b.y && cell.z >= a.z && cell.z <= b.z;
}

}  // namespace lamap::tools
