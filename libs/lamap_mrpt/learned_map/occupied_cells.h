#pragma once

#include <lamap_core/grid/cell.h>
#include <lamap_core/grid/state_thresholds.h>
#include <lamap_mrpt/learned_map/lazy.h>
#include <mrpt/maps/CSimplePointsMap.h>

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
  /// The same points, for searches in the plane only or in space only.
  [[nodiscard]] std::shared_ptr<const mrpt::maps::CSimplePointsMap> searchable(bool plane) const;

 private:
  StateThresholds thresholds_;
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
