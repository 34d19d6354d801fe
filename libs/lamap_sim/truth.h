#pragma once

#include <lamap_core/grid/cell.h>
#include <lamap_sim/world.h>

#include <functional>
#include <vector>

namespace lamap::sim
{
/// A cell whose truth is known.
struct TrueCell
{
  CellIndex index;
  bool occupied = false;
};

struct TruthOptions
{
  double resolution_m = 0.1;  ///< edge of a cell, finite, > 0
  /// Solid cells count up to this depth behind open space, in cells along each axis (including diagonals).
  int depthCells = 1;
};

/** The cells of a world that are wholly solid or wholly open, sorted by z, y, x.
 *
 * Free: cells in the world's interior that meet no solid. Occupied: cells wholly in solids, but only those
 * within depthCells of a cell of the interior that is not wholly solid, because no sensor can know what lies
 * deeper in a wall. Cells that contain a surface are in neither group. Of a flat world, only the layer at z
 * index 0 is returned.
 *
 * @param shouldStop  called from time to time; once it returns true, the result is empty
 * @throws std::invalid_argument for illegal options, and if there would be more than 10⁹ cells to examine */
[[nodiscard]] std::vector<TrueCell> truthOf(const World& world, const TruthOptions& options,
                                            const std::function<bool()>& shouldStop = nullptr);

}  // namespace lamap::sim
