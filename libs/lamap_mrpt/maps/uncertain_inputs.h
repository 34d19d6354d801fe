#pragma once

#include <lamap_core/training/hilbert_training.h>
#include <lamap_mrpt/learned_map/CLearnedMap.h>

#include <optional>

namespace lamap
{
/** What a learner is to know of how sure a scan's points are, in the map's frame. Warns once in a process if
 * the pose is to have a covariance and has none.
 * @return nothing if they are certain */
[[nodiscard]] std::optional<HilbertUncertainty> uncertaintyOf(const UncertainInputs& inputs,
                                                              const CLearnedMap::ScanPose& pose);

/** The covariance of a pose as HilbertUncertainty has it, with the rotation as a vector along the map's axes.
 * @param pose_map with MRPT's covariance of (x, y, z, yaw, pitch, roll) [m, rad] */
[[nodiscard]] HilbertUncertainty uncertaintyOf(const mrpt::poses::CPose3DPDFGaussian& pose_map);

}  // namespace lamap
