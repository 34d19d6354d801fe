#pragma once

#include <lamap_core/scan/ray_selection.h>
#include <lamap_core/scan/scan_frame.h>
#include <lamap_core/training/training_rules.h>
#include <lamap_core/training/training_set.h>

#include <memory>

namespace lamap
{
/** Makes training sets; keeps its working memory from scan to scan.
 *
 * Definitions. A fan's hits are grouped (`Cells`: by their cell; `Centroids`: by their voxel of
 * hitDownsampling, or not at all) and each group is one ray to its mean; rays that end without a hit are
 * grouped likewise by their end. Free samples stand at i·freeResolution, i = 0, 1, …, from the origin, up to
 * the ray's length less freeMargin, or up to the end where there is no hit. */
class ScanTrainer
{
 public:
  ScanTrainer();
  ~ScanTrainer();

  /** @param threads ≥ 1; never changes the result
   *  @return the training set, valid until the next call. counts.outside and counts.tooNear of the selection
   * grow by rays that end too far from the origin, or that a planar map sees as points. */
  const TrainingSet& train(SelectedRays& rays, const TrainingRules& rules, const ScanFrame& frame,
                           bool planar, double resolution_m, unsigned threads);

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace lamap
