#pragma once

#include <lamap_core/scan/ray_selection.h>
#include <lamap_core/training/sampling_rules.h>

#include <cstdint>
#include <optional>

namespace lamap
{
/// How the rays of a scan become training points, as options. Lengths in metres.
struct SamplingOptions : public RangeOptions, public BeamOptions
{
  TrainingPoints trainingPoints = TrainingPoints::Cells;
  std::optional<double>
      freeResolution;  ///< distance between free points on a ray; empty: one cell (BGK), two (GP)
  std::optional<double>
      freeMargin;  ///< no free point nearer to its ray's hit; empty: half a cell (BGK), one (GP)
  double freeDownsampling = 0.0;  ///< `Centroids`: voxel edge in which free points are averaged; 0: none
  /// `Centroids`: voxel edge in which hits are averaged; empty: one cell; 0: none
  std::optional<double> hitDownsampling;
  bool usePoseCovariance = false;  ///< points are as uncertain as the scan's pose, where it has a covariance
  uint32_t protectHits =
      2;  ///< a cell with this many raw hits in a scan takes no free point; 0: none is protected

  /// What chapter 4 of the thesis and its library LA3DM have in common.
  void setAsInThesis();

 protected:
  /// Only of options whose lengths are filled in. @param widthUnit [m] as of SamplingRules
  [[nodiscard]] SamplingRules rulesWith(FreeSpace freeSpace, double widthUnit) const;
  /// Without free space, rays without a return say nothing.
  [[nodiscard]] RangeOptions limitsWith(FreeSpace freeSpace) const;
};

}  // namespace lamap
