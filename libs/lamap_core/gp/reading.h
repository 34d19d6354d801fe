#pragma once

#include <lamap_core/gp/options.h>
#include <lamap_core/grid/evidence_map.h>

namespace lamap
{
/** How a GP map reads the two sums of a cell: see GpScanInference for what they are. A Reading as EvidenceMap
 * wants it. */
class GpReading : public NoPriorMap
{
 public:
  using Structure = GpStructure;
  static constexpr SumKind kKind = SumKind::Signed;

  /// @throws std::invalid_argument as GpStructure::validate().
  explicit GpReading(const GpStructure& structure);

  [[nodiscard]] const GpStructure& structure() const { return structure_; }
  [[nodiscard]] CellEstimate read(const CellIndex& cell, const CellSums& sums,
                                  const StateThresholds& thresholds) const;
  [[nodiscard]] bool mean(const CellSums* cells, uint32_t count, CellSums& mean) const;
  /// Pruning may differ.
  void requireAddable(const GpReading& other) const;

  /// The sums for what GPs said of a cell: Σ(1/σ² − 1/σ_f²) and Σ μ/σ².
  [[nodiscard]] static SignedSums sumsOf(const GpStructure& structure, double precision, double weighted);

 private:
  GpStructure structure_;
};

}  // namespace lamap
