#pragma once

#include <lamap_core/gp/options.h>
#include <lamap_core/gp/reading.h>
#include <lamap_core/grid/cell_accessor.h>
#include <lamap_core/grid/evidence_map.h>
#include <lamap_core/math/workers.h>
#include <lamap_core/scan/ray_selection.h>
#include <lamap_core/scan/scan.h>

namespace lamap
{
class GpScanInference;
extern template class EvidenceMap<GpReading>;
extern template class CellAccessor<GpReading>;

/** Gaussian process occupancy map (thesis section 2.3) on a grid of test-data octrees: exact GPs on the
 * blocks of each scan, fused by a Bayesian committee machine. The baseline of the thesis's chapter 4.
 *
 * A cell holds the sums of 1/σ² − 1/σ_f² and of μ/σ² over the GPs that spoke of it, or its log-odds
 * (GpFusion), as whole numbers of 2^-20.
 *
 * What a cell says: `prob` is eq. (2.25). With GpFusion::Bcm `variance` is that of f, eq. (2.29), and
 * `evidence` holds its inverse and the mean of f, eq. (2.28); with GpFusion::Bayes there is no variance, and
 * `evidence` holds the log-odds.
 *
 * Invariants: cells beyond the support of all data hold nothing; any order, batching and merging of the same
 * scans gives the same map (pruning none or lossless), to the byte, for any number of threads; n equal scans
 * give n times the evidence of one, so that any mean that is not zero grows into certainty (thesis eq. 4.23).
 *
 * Thread guarantee: const methods may be called from several threads as long as nobody changes the map.
 */
class GpMap : public EvidenceMap<GpReading>
{
 public:
  /// @throws std::invalid_argument as GpStructure::validate().
  explicit GpMap(const GpStructure& structure = {}) : EvidenceMap(structure) {}

  /** Adds one scan.
   * @param threads how many may work; 0: as many as the machine has. Never changes the result.
   * @return what became of its rays; nothing is changed if none was usable.
   * @throws std::invalid_argument as GpInference::validate(); std::overflow_error if a sum would pass 2^41;
   * std::length_error if the scan's rays are too long for cells of this size. Nothing is changed then. */
  RayCounts insert(const Scan& scan, const GpInference& inference, unsigned threads = 0);

  /** Adds all evidence of another map, as if its scans had been inserted here.
   * @throws std::invalid_argument if its structure (pruning and maxEvidence apart) differs. */
  using EvidenceMap::merge;

  /** Adds to a cell what a GP with one training point, at the cell's centre, says there.
   * @throws std::overflow_error as insert(). */
  void addObservation(const CellIndex& index, bool occupied, const StateThresholds& thresholds);

 private:
  WorkingMemory<GpScanInference> inference_;
  KeptWorkers workers_;
};

}  // namespace lamap
