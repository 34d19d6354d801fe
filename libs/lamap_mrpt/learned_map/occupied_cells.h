#pragma once

#include <lamap_core/bgk/options.h>
#include <lamap_core/grid/cell.h>
#include <lamap_mrpt/learned_map/lazy.h>
#include <mrpt/maps/CSimplePointsMap.h>

namespace lamap
{
class CLearnedMap;

/** Centres of a map's occupied cells in the order of z, y, x.
 *
 * MRPT's points maps search with nanoflann, but one map can hold a tree for the plane or one for space, and
 * not both (2.5.8 then says that there are no points). So there is one for each, made when it is asked for.
 * All methods may be called from several threads. */
class OccupiedCells
{
 public:
  explicit OccupiedCells(const CLearnedMap& map);

  /// That made them occupied.
  [[nodiscard]] const StateThresholds& thresholds() const { return thresholds_; }
  [[nodiscard]] const mrpt::maps::CSimplePointsMap& points() const { return points_; }
  /// The same points, for searches in the plane only.
  [[nodiscard]] std::shared_ptr<const mrpt::maps::CSimplePointsMap> forPlane() const;
  /// The same points, for searches in space only.
  [[nodiscard]] std::shared_ptr<const mrpt::maps::CSimplePointsMap> forSpace() const;

 private:
  StateThresholds thresholds_;
  mrpt::maps::CSimplePointsMap points_;
  Lazy<mrpt::maps::CSimplePointsMap> forPlane_;
  Lazy<mrpt::maps::CSimplePointsMap> forSpace_;
};

/// Everything that has evidence, in cells.
struct ObservedBox
{
  explicit ObservedBox(const CLearnedMap& map);

  bool any = false;
  CellIndex low;   ///< smallest indices
  CellIndex high;  ///< largest indices, included
};

}  // namespace lamap
