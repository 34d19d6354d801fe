#pragma once

// Single numbers of OverlappingReading, for sources of the library that ask for many: they are part of what
// calls them.

#include <lamap_core/math/portable_math.h>
#include <lamap_core/overlapping/reading.h>

#include <algorithm>
#include <cmath>

namespace lamap
{
/// P(occupied) of OverlappingReading::read(), to the last bit.
[[nodiscard]] inline double probOf(const OverlappingReading& reading, const CellIndex& /*cell*/,
                                   const CellSums& sums)
{
  const OverlappingStructure& structure = reading.structure();
  const double logodds = logoddsOf(sums, structure.outOfFieldLimit);
  const bool limited = sums.first != 0 && structure.fieldLimit > 0;
  return logistic(limited ? saturated(logodds, structure.fieldLimit) : logodds);
}

/// Its state. @param prob of the cell
[[nodiscard]] inline CellState stateOf(const OverlappingReading& /*reading*/, const CellIndex& /*cell*/,
                                       const CellSums& /*sums*/, double prob,
                                       const StateThresholds& thresholds)
{
  return stateOf(prob, thresholds);
}

}  // namespace lamap
