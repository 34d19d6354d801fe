#pragma once

#include <lamap_core/grid/reading.h>
#include <lamap_core/overlapping/options.h>

namespace lamap
{
/** How an overlapping Hilbert map reads the two sums of a cell: log-odds of the models that have it in their
 * field, and of those that speak of it from outside. In the probability, log-odds in the field tend to
 * fieldLimit; `evidence` tells all of them. A Reading as EvidenceMap wants it. */
class OverlappingReading : public ReadingOf<OverlappingStructure, SumKind::Signed>
{
 public:
  using ReadingOf::ReadingOf;

  /// The limit of log-odds in the field and pruning may differ.
  void requireAddable(const OverlappingReading& other) const;

  [[nodiscard]] CellEstimate read(const CellIndex& cell, const CellSums& sums,
                                  const StateThresholds& thresholds) const;
  /// False where only some of the cells were in a field.
  [[nodiscard]] bool mean(const CellSums* cells, uint32_t count, CellSums& mean) const;
};

/// Log-odds of a cell: the sum of what was seen in the field, else what was said from outside, held to a
/// limit.
[[nodiscard]] double logoddsOf(const CellSums& sums, double outOfFieldLimit);

/// L / (1 + (L/limit)⁴)^¼: tends to ±limit > 0, in the order of L, and is nearly L well below the limit.
[[nodiscard]] double saturated(double logodds, double limit);

}  // namespace lamap
