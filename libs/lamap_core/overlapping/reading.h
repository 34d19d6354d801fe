#pragma once

#include <lamap_core/grid/evidence_map.h>
#include <lamap_core/overlapping/options.h>

namespace lamap
{
/** How an overlapping Hilbert map reads the two sums of a cell: log-odds of the models that have it in their
 * field, and of those that speak of it from outside. A Reading as EvidenceMap wants it. */
class OverlappingReading : public NoPriorMap
{
 public:
  using Structure = OverlappingStructure;
  static constexpr SumKind kKind = SumKind::Signed;

  /// @throws std::invalid_argument as OverlappingStructure::validate().
  explicit OverlappingReading(const OverlappingStructure& structure);

  [[nodiscard]] const OverlappingStructure& structure() const { return structure_; }
  [[nodiscard]] CellEstimate read(const CellIndex& cell, const CellSums& sums,
                                  const StateThresholds& thresholds) const;
  /// False where only some of the cells were in a field.
  [[nodiscard]] bool mean(const CellSums* cells, uint32_t count, CellSums& mean) const;
  /// Pruning may differ.
  void requireAddable(const OverlappingReading& other) const;

 private:
  OverlappingStructure structure_;
};

/// Log-odds of a cell: the sum of what was seen in the field, else what was said from outside, held to a
/// limit.
[[nodiscard]] double logoddsOf(const CellSums& sums, double outOfFieldLimit);

}  // namespace lamap
