#pragma once

#include <lamap_core/grid/cell.h>
#include <lamap_core/scan/scan.h>

#include <cstdint>
#include <optional>
#include <vector>

namespace lamap
{
/// How a scan labels cells.
struct LabelRules
{
  /// Edge of a cell [m], > 0.
  double resolution_m = 0.1;
  /// Returns farther than this [m] are free space up to it; 0: what the observation states.
  double maxRange_m = 0;
  /// Distance from the last free cell of a ray to its return [m]; empty: two cells.
  std::optional<double> freeMargin_m;
  /// Whether rays without a return show free space, up to the maximum range.
  bool noReturnIsFree = true;
  /// The layer of a map for 2D sensors: rays and cells are moved into it.
  std::optional<int32_t> layer;
};

/// What one scan by itself shows of cells. Each cell stands once, and in one of the lists only.
struct ScanLabels
{
  std::vector<CellIndex> occupied;
  std::vector<CellIndex> free;
};

/** Labels cells by a scan that a map was not given, to score the map with.
 *
 * Occupied are the cells in which a ray of the scan returned. Free are the cells met by points along its
 * rays, one cell apart, backwards from the free margin before the return, or from the maximum range of a ray
 * without one (unless those are left out), to half a cell from the sensor; a cell with a return of the same
 * scan is never free. One ray is followed for each cell in which rays end, to the mean of their ends. Nothing
 * depends on how many rays meet a cell. The lists are sorted by z, y, x.
 * @throws std::invalid_argument if a rule is not legal; std::length_error as Sampler::sample(). */
[[nodiscard]] ScanLabels labelCells(const Scan& scan, const LabelRules& rules);

}  // namespace lamap
