#pragma once

#include <lamap_core/scan/ray_selection.h>
#include <lamap_core/scan/scan_frame.h>
#include <lamap_core/training/sampling_rules.h>
#include <lamap_core/training/training_set.h>

#include <memory>

namespace lamap
{
/** Makes training sets of rays, for all learners; keeps its working memory from scan to scan.
 *
 * Definitions. A fan's hits are grouped (`Cells`: by their cell; `Centroids`: by their voxel of
 * hitDownsampling, or not at all) and each group is one ray to its mean; rays that end without a hit are
 * grouped likewise by their end. Such a ray is free from sensorMargin to its length less freeMargin, or to
 * its end where there is no hit. Its samples stand every freeResolution, from the sensor on or from the end
 * back. */
class Sampler
{
 public:
  Sampler();
  ~Sampler();

  /** @param rules valid
   *  @param offset of the scan blocks
   *  @param threads ≥ 1; never changes the result but for the order of blocks
   *  @return the training set, valid until the next call; counted as left out are also rays that end too far
   *  from the anchor, or that a planar map sees as points
   *  @throws std::length_error if the scan touches too many blocks of cells, see ScanBlocks, or has too many
   * points. */
  const TrainingSet& sample(const SelectedRays& rays, const SamplingRules& rules, const ScanFrame& frame,
                            const BlockOffset& offset, unsigned threads);

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace lamap
