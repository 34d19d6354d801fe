#pragma once

// Single numbers of GpReading, for sources of the library that ask for many: they are part of what calls
// them.

#include <lamap_core/gp/reading.h>
#include <lamap_core/math/portable_math.h>

#include <algorithm>

namespace lamap
{
/// A signed sum of a cell; 0 where it is missing.
[[nodiscard]] inline double evidenceSum(uint64_t code)
{
  return static_cast<double>(SignedSums::decoded(code).value_or(0)) * kEvidenceUnit;
}

/// P(occupied) of GpReading::read(), to the last bit.
[[nodiscard]] inline double probOf(const GpReading& reading, const CellIndex& /*cell*/, const CellSums& sums)
{
  const GpStructure& structure = reading.structure();
  if (structure.fusion == GpFusion::Bayes) return logistic(evidenceSum(sums.second));
  const double factor = evidenceFactor(std::max(evidenceSum(sums.first), 0.0), *structure.maxEvidence);
  // Eq. (2.25): ω is σ²_min·mean/variance
  return logistic(structure.squash() * (factor * evidenceSum(sums.second)));
}

/// Its state. @param prob of the cell
[[nodiscard]] inline CellState stateOf(const GpReading& reading, const CellIndex& cell, const CellSums& sums,
                                       double prob, const StateThresholds& thresholds)
{
  return thresholds.variance > 0 ? reading.read(cell, sums, thresholds).state : stateOf(prob, thresholds);
}

}  // namespace lamap
