#pragma once

#include <lamap_core/scan/ray_selection.h>

#include <cstdint>

namespace lamap
{
/// Which rays of an observation a map learns from, and how far.
struct RangeOptions
{
  double minRange = 0.0;  ///< [m] returns nearer than this are left out, with their rays
  double maxRange = 0.0;  ///< [m] free space and hits end here; 0: what the observation states
  bool considerInvalidRangesAsFreeSpace = true;  ///< rays without return are free up to the maximum range
  uint32_t rayDecimation = 1;                    ///< use every Nth ray of an observation, ≥ 1

  [[nodiscard]] RangeLimits rangeLimits() const
  {
    return {minRange, maxRange, considerInvalidRangesAsFreeSpace, rayDecimation};
  }
};

}  // namespace lamap
