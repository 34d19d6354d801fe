#pragma once

#include <lamap_core/training/hilbert_training.h>
#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <lamap_mrpt/options/option_table.h>

#include <optional>

namespace lamap
{
/// How sure it is where a scan's points are, as options (thesis 3.2.4; Ramos and Ott 2015).
struct UncertainInputs
{
  bool usePoseCovariance = false;  ///< of the pose that an observation is inserted at, where it has one
  double rangeStd = 0.0;           ///< [m] along each ray
  double pointStd = 0.0;           ///< [m] of each point, along each axis

  /** What a learner is to know of a scan's points, in the map's frame. Warns once in a process if the pose is
   * to have a covariance and has none.
   * @return nothing if they are certain */
  [[nodiscard]] std::optional<HilbertUncertainty> of(const CLearnedMap::ScanPose& pose) const;
};

/** The covariance of a pose as HilbertUncertainty has it, with the rotation as a vector along the map's axes.
 * @param pose_map with MRPT's covariance of (x, y, z, yaw, pitch, roll) [m, rad] */
[[nodiscard]] HilbertUncertainty uncertaintyOf(const mrpt::poses::CPose3DPDFGaussian& pose_map);

/// usePoseCovariance, rangeStd, pointStd. @tparam Self a group that is an UncertainInputs
template <typename Self>
OptionTable& addUncertaintyOptions(OptionTable& table)
{
  return table
      .add<Self>("usePoseCovariance", &Self::usePoseCovariance, {},
                 "points are as uncertain as the pose that their observation comes with")
      .template add<Self>("rangeStd", &Self::rangeStd, {"m", {0, 100}},
                          "standard deviation of a range, for uncertain points")
      .template add<Self>("pointStd", &Self::pointStd, {"m", {0, 100}},
                          "standard deviation of a point along each axis");
}

}  // namespace lamap
