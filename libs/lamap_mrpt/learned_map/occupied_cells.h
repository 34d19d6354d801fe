#pragma once

#include <lamap_core/grid/cell.h>
#include <lamap_core/grid/evidence_block.h>
#include <lamap_core/grid/state_thresholds.h>
#include <lamap_mrpt/learned_map/lazy.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <tsl/robin_set.h>

#include <array>
#include <memory>
#include <vector>

namespace lamap
{
class CLearnedMap;

/// In the order of z, y, x.
[[nodiscard]] std::vector<CellIndex> sortedOccupiedCells(const CLearnedMap& map);

/** Centres of a map's occupied cells in the order of z, y, x.
 *
 * MRPT's points maps search with nanoflann, but a points map can hold a tree either for the plane or for
 * space, not both (2.5.8 then reports that there are no points). So there is a copy for each, made on first
 * use. All methods may be called from several threads. */
class OccupiedCells
{
 public:
  explicit OccupiedCells(const CLearnedMap& map);

  /// The thresholds by which they are occupied.
  [[nodiscard]] const StateThresholds& thresholds() const { return thresholds_; }
  [[nodiscard]] const mrpt::maps::CSimplePointsMap& points() const { return points_; }
  /** The cells of a cube of 2^n cells around a cell, aligned to its size, are not occupied, nor are those of
   * the cubes beside it. @return the largest n that is known, or 0 */
  [[nodiscard]] int emptyAround(const CellIndex& cell) const;
  /// The same points, for searches in the plane only or in space only.
  [[nodiscard]] std::shared_ptr<const mrpt::maps::CSimplePointsMap> searchable(bool plane) const;

 private:
  /// Cubes that hold occupied cells, by levels of their size.
  static constexpr std::array<int, 4> kCubeLevels{5, 11, 17, 23};
  using Cubes = tsl::robin_set<BlockIndex, BlockIndexHash>;

  StateThresholds thresholds_;
  std::array<Cubes, kCubeLevels.size()> cubes_;
  mrpt::maps::CSimplePointsMap points_;
  std::array<Lazy<mrpt::maps::CSimplePointsMap>, 2> searchable_;  ///< in the plane, in space
};

/// The bounding box of all cells with evidence.
struct ObservedBox
{
  explicit ObservedBox(const CLearnedMap& map);

  bool any = false;
  CellIndex low;   ///< smallest indices
  CellIndex high;  ///< largest indices, inclusive
};

}  // namespace lamap
