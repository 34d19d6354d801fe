#pragma once

#include <lamap_core/bgk/options.h>
#include <lamap_core/bgk/reading.h>
#include <lamap_core/grid/cell_accessor.h>
#include <lamap_core/grid/evidence_map.h>
#include <lamap_core/math/workers.h>
#include <lamap_core/scan/ray_selection.h>
#include <lamap_core/scan/scan.h>

#include <memory>

namespace lamap
{
class BgkScanInference;
extern template class EvidenceMap<BgkReading>;
extern template class CellAccessor<BgkReading>;

/** BGK occupancy map: Bayesian generalized kernel inference (thesis chapter 4) on a grid of test-data
 * octrees.
 *
 * A cell holds the sums ȳ and k̄ − ȳ (eq. 4.5, 4.6) of all scans, as two integers with 20 fractional bits; the
 * prior is kept apart. A scan's sums are formed first, without rounding that depends on an order, rounded
 * once and added.
 *
 * Invariants: the evidence of a cell is positive exactly where a training point lies within the support of
 * the kernel; any order, batching and merging of the same scans gives the same map (pruning none or
 * lossless), for any number of threads; cells without evidence have the prior.
 *
 * Thread guarantee: const methods may be called from several threads as long as nobody changes the map.
 */
class BgkMap : public EvidenceMap<BgkReading>
{
 public:
  /// @throws std::invalid_argument as BgkStructure::validate().
  explicit BgkMap(const BgkStructure& structure = {}) : EvidenceMap(structure) {}

  /** Adds one scan (eq. 4.3, 4.4).
   * @param threads how many may work; 0: as many as the machine has. Never changes the result.
   * @return what became of its rays; nothing is changed if none was usable.
   * @throws std::invalid_argument as BgkInference::validate(); std::overflow_error if a count would pass
   * 2^63; std::length_error if the scan's rays are too long for cells of this size. Nothing is changed then.
   */
  RayCounts insert(const Scan& scan, const BgkInference& inference, unsigned threads = 0);

  /** Adds all evidence of another map, as if its scans had been inserted here.
   * @throws std::invalid_argument if its structure (the prior, maxEvidence and pruning apart) differs. */
  using EvidenceMap::merge;

  /** Makes another map the prior: α₀ and β₀ of a cell that has evidence there are its α and β
   * (thesis 4.2.1, 5.1).
   * @throws std::invalid_argument if its resolution or planar layer differs. */
  void setPriorMap(std::shared_ptr<const BgkMap> prior);
  [[nodiscard]] const std::shared_ptr<const BgkMap>& priorMap() const { return reading().priorMap(); }

  /** Adds pseudo-counts to one cell directly, e.g. a cell known from elsewhere. Counts are rounded to 2^-20.
   * @param alpha, beta [pseudo-counts], finite, ≥ 0
   * @throws std::invalid_argument naming the count; std::overflow_error as insert(). */
  void addEvidence(const CellIndex& index, double alpha, double beta, const StateThresholds& thresholds);

  /// α₀ and β₀ of a cell, from the prior map where it has evidence.
  [[nodiscard]] std::array<double, 2> priorOf(const CellIndex& index) const
  {
    return reading().priorOf(index);
  }

 private:
  WorkingMemory<BgkScanInference> inference_;
  KeptWorkers workers_;
};

}  // namespace lamap
