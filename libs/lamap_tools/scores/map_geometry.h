#pragma once

#include <lamap_tools/cells/cell_map.h>
#include <lamap_tools/cells/truth.h>

#include <cstdint>
#include <optional>

namespace lamap::tools
{
/// A cell is called free if its P(occupied) is below this: of all maps alike, because those with one
/// threshold only, such as OctoMap's, have no unknown cells and call free what they have seen once.
constexpr double kCalledFreeBelow = 0.3;

/// How often a map calls cells free or occupied whose truth is known.
struct StateCounts
{
  uint64_t occupied = 0;                ///< cells that are occupied in truth
  uint64_t occupiedCalledOccupied = 0;  ///< of those
  uint64_t occupiedCalledFree = 0;
  uint64_t free = 0;  ///< cells that are free in truth
  uint64_t freeCalledOccupied = 0;
  uint64_t freeCalledFree = 0;

  /// @param estimate  what the map says of the cells; nothing where it has observed nothing
  void add(const std::optional<CellEstimate>& estimate, uint64_t occupiedCells, uint64_t freeCells);
};

/** The shape of a map next to the surfaces of a truth: not how sure it is, but where it has its cells.
 *
 * Called occupied are the cells to which the map itself gives this state, called free those with a
 * P(occupied) below kCalledFreeBelow. Surface cells are the truth's occupied ones, so that the figures mean
 * what they say for a truth of surfaces. What is undefined is nothing. */
struct MapGeometry
{
  uint64_t occupiedCells = 0;  ///< that the map has, seen by the truth or not
  uint64_t surfaceCells = 0;   ///< of the truth
  /// Whether distances are to points on surfaces; else to the centres of surface cells.
  bool toPoints = false;
  /// From the centre of an occupied cell to the nearest surface: mean, and what 95 % do not exceed [m].
  std::optional<double> meanDistance_m;
  std::optional<double> distance95_m;
  /// Share of the surface cells that have an occupied cell as near as one with which they share a face,
  /// or nearer, centre to centre.
  std::optional<double> covered;
  /// Occupied cells for each surface cell; nothing if their sizes differ.
  std::optional<double> occupiedPerSurfaceCell;
  std::optional<double> surfaceCalledFree;  ///< share of the surface cells
  std::optional<double> freeCalledFree;     ///< share of the truth's free cells
  /// Harmonic mean of precision and recall of the state occupied.
  std::optional<double> f1;
};

/** Compares the occupied cells of a map with the surfaces of a truth.
 *
 * Of a map or a truth of one layer only that layer counts, and distances are in its plane.
 * @param layer   of a map for 2D sensors, see layerOf()
 * @param states  of the truth's cells */
[[nodiscard]] MapGeometry geometryOf(const CellMap& map, std::optional<int32_t> layer, const Truth& truth,
                                     const StateCounts& states);

}  // namespace lamap::tools
