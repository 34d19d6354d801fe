#pragma once

#include <lamap_core/bgk/options.h>
#include <lamap_core/grid/evidence.h>
#include <lamap_core/math/workers.h>
#include <lamap_core/scan/ray_selection.h>
#include <lamap_core/scan/scan.h>

#include <memory>

namespace lamap
{
/** What one scan says by BGK inference: ȳ and k̄ − ȳ (thesis eq. 4.5, 4.6) of each cell; keeps its working
 * memory between scans.
 *
 * "All within the support" is the rule: faces, edges and corners of blocks are invisible. Each block sums
 * what reaches it, whole numbers all along, so that neither order nor threads can change a bit. */
class BgkScanInference
{
 public:
  BgkScanInference();
  ~BgkScanInference();

  /** A scan whose beams are so far apart, in cells, that giving them that width would take gigabytes, is
   * learned with `beamWidth` = observation, and its rays are counted as narrowed.
   *  @param inference resolved and valid
   *  @param layer of a planar map
   *  @param counts set to what became of the scan's rays
   *  @throws std::length_error if the scan's rays are too long, or its points too wide, for cells of this
   *  size */
  [[nodiscard]] Evidence infer(const Scan& scan, const BgkInference& inference, const BgkStructure& structure,
                               int32_t layer, const Workers& workers, RayCounts& counts);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace lamap
