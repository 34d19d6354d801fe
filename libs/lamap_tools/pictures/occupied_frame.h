#pragma once

#include <lamap_tools/cells/cell_table.h>
#include <lamap_tools/pictures/render_map.h>

#include <functional>
#include <optional>
#include <string>

namespace lamap::tools
{
/** The box of cells that a picture shows: around the occupied cells, without a few distant ones.
 *
 * Stray returns and rays into the open reach far beyond the mapped place; in a picture of all cells the map
 * would be a dot. The box spans the middle 98 % of the occupied cells along each axis and an eighth more or,
 * if that saves less than a quarter, all of them.
 * @param shown  which cells count
 * @return empty if none of them is occupied */
[[nodiscard]] std::optional<CellExtent> occupiedFrame(const CellMap& map,
                                                      const std::function<bool(const CellIndex&)>& shown);

/** Ends a picture of a map that has none of the cells it would show.
 * @param missing  what it would show: "occupied cell in the box asked for"
 * @throws std::runtime_error naming them, or saying that the map is empty */
[[noreturn]] void failNothingToDraw(const CellMap& map, const std::string& missing);

/// The cells of the box in the options, at least one along each axis; empty if the options have no box.
[[nodiscard]] std::optional<CellExtent> cellsOfBox(const RenderOptions& options, double resolution_m);

[[nodiscard]] inline bool inside(const CellIndex& cell, const CellExtent& extent)
{
  const auto& [a, b] = extent;
  return cell.x >= a.x && cell.x <= b.x && cell.y >= a.y && cell.y <= b.y && cell.z >= a.z && cell.z <= b.z;
}

}  // namespace lamap::tools
