#pragma once

#include <lamap_core/gp/options.h>
#include <lamap_core/grid/reading.h>
#include <lamap_core/grid/state_thresholds.h>

namespace lamap
{
/** How a GP map reads the two sums of a cell: see GpScanInference for what they are. A Reading as EvidenceMap
 * wants it; the sums count up to maxEvidence, but `evidence` tells all of them. */
class GpReading : public ReadingOf<GpStructure, SumKind::Signed>
{
 public:
  /// @throws std::invalid_argument as GpStructure::validate().
  explicit GpReading(const GpStructure& structure);

  [[nodiscard]] CellEstimate read(const CellIndex& cell, const CellSums& sums,
                                  const StateThresholds& thresholds) const;

  /// The limit of evidence and pruning may differ.
  void requireAddable(const GpReading& other) const;

  /// The sums for what GPs said of a cell: Σ(1/σ² − 1/σ_f²) and Σ μ/σ².
  [[nodiscard]] static SignedSums sumsOf(const GpStructure& structure, double precision, double weighted);
};

}  // namespace lamap
