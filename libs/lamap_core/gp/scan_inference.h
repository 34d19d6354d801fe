#pragma once

#include <lamap_core/gp/options.h>
#include <lamap_core/grid/block_grid.h>
#include <lamap_core/grid/octant_rule.h>
#include <lamap_core/scan/ray_selection.h>
#include <lamap_core/scan/scan.h>

#include <cstdint>
#include <memory>

namespace lamap
{
/** Adds what the Gaussian processes of one scan say to the cells of a grid; keeps its working memory between
 * scans.
 *
 * With GpFusion::Bcm a cell's sums (see signed_evidence.h) are Σ(1/σ² − 1/σ_f²) and Σ μ/σ², over the GPs that
 * speak of it (eq. 2.28, 2.29, with one 1/σ_f² kept apart as the prior); with GpFusion::Bayes the first is
 * missing and the second is the log-odds of the scan's squashed prediction. A GP speaks of the cells whose
 * centre is nearer than the support to some of its training points. A scan's sums are formed in a fixed order
 * of blocks, rounded once and added. */
class GpScanInference
{
 public:
  GpScanInference();
  ~GpScanInference();

  /** @param scan its rays are counted in the result
   *  @param inference resolved and valid
   *  @param layer of a planar map
   *  @param threads as for Workers; never changes the result
   *  @throws std::overflow_error if a sum would pass 2^41; std::length_error, with nothing changed, if the
   * scan's rays are too long for cells of this size */
  RayCounts addScan(const Scan& scan, const GpInference& inference, const GpStructure& structure,
                    int32_t layer, unsigned threads, const RuleForBlock& ruleFor, BlockGrid& grid);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace lamap
