#pragma once

#include <lamap_core/overlapping/model_scan.h>
#include <lamap_core/overlapping/options.h>

#include <vector>

namespace lamap
{
/// Scans that wait for others, to be trained together.
struct PendingScans
{
  ModelPose pose;  ///< of the first of them, the frame of all
  std::vector<ModelScan> scans;
};

/** Whether a model can certainly be trained on waiting scans, and fused, within the limits of Sampler,
 * CompactRows and ModelFusion: so few are the blocks of cells around their rays. Costs no more than to look
 * at each ray.
 * @return false where it would have to be tried */
[[nodiscard]] bool isSurelyTrainable(const PendingScans& pending, const OverlappingStructure& structure,
                                     const OverlappingInference& inference);

}  // namespace lamap
