#pragma once

#include <lamap_core/gp/options.h>
#include <lamap_core/grid/evidence.h>
#include <lamap_core/math/workers.h>
#include <lamap_core/scan/ray_selection.h>
#include <lamap_core/scan/scan.h>

#include <cstdint>
#include <memory>

namespace lamap
{
/** What the Gaussian processes of one scan say of each cell; keeps its working memory between scans.
 *
 * With GpFusion::Bcm a cell's sums (see SignedSums) are Σ(1/σ² − 1/σ_f²) and Σ μ/σ², over the GPs that
 * speak of it (eq. 2.28, 2.29, with one 1/σ_f² kept apart as the prior); with GpFusion::Bayes the first is
 * missing and the second is the log-odds of the scan's squashed prediction. A GP speaks of the cells whose
 * centre is nearer than the support to some of its training points. A scan's sums are formed in a fixed order
 * of blocks and rounded once. */
class GpScanInference
{
 public:
  GpScanInference();
  ~GpScanInference();

  /** @param inference resolved and valid
   *  @param layer of a planar map
   *  @param workers their number never changes the result
   *  @param counts set to what became of the scan's rays
   *  @throws std::length_error if the scan's rays are too long for cells of this size */
  [[nodiscard]] Evidence infer(const Scan& scan, const GpInference& inference, const GpStructure& structure,
                               int32_t layer, const Workers& workers, RayCounts& counts);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace lamap
