#pragma once

#include <lamap_core/grid/cell.h>
#include <lamap_sim/world.h>

#include <functional>
#include <vector>

namespace lamap::sim
{
/// A cell that is wholly solid or wholly open.
struct TrueCell
{
  CellIndex index;
  bool solid = false;
};

struct TruthOptions
{
  double resolution_m = 0.1;  ///< edge of a cell, finite, > 0
  /// Solid cells count up to this depth behind open space, counted in cells along each axis (diagonals too).
  int depthCells = 1;
};

/** The cells of a world of which the truth is one thing, sorted by z, y, x.
 *
 * Free: cells that lie in the world's interior and meet no solid. Solid: cells that lie wholly in solids, but
 * only those within depthCells of a cell of the interior that is not wholly solid: what lies deeper in a
 * wall, no sensor can know. Cells that hold a surface are in neither. Of a flat world only the layer at z
 * index 0 is given.
 *
 * @param shouldStop  asked from time to time; nothing is returned after it said yes
 * @throws std::invalid_argument for illegal options, and if there would be more than 10⁹ cells to look at */
[[nodiscard]] std::vector<TrueCell> truthOf(const World& world, const TruthOptions& options,
                                            const std::function<bool()>& shouldStop = nullptr);

}  // namespace lamap::sim
