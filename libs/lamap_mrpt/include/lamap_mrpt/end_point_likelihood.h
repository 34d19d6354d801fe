#pragma once

#include <lamap_core/ray_selection.h>
#include <lamap_mrpt/CLearnedMap.h>
#include <lamap_mrpt/observation_fingerprint.h>
#include <mrpt/poses/CPose3D.h>

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace lamap
{
/// Where the returns of one observation end in the robot's frame, thinned as likelihoodOptions say.
struct EndPoints
{
  std::optional<ObservationFingerprint> observation;  ///< empty: not to be used again
  RangeLimits limits;
  std::vector<Eigen::Vector3d> ends_robot;
};

/** The returns of an observation that are usable within the limits.
 * @return empty for an observation that cannot be read as rays.
 * @throws as raysOf(). */
[[nodiscard]] EndPoints endPointsOf(const mrpt::obs::CObservation& observation, const RangeLimits& limits);

/** Logarithm of how well returns fit a map from a pose of the robot:
 *
 *   independence · Σ log((1 − ε)·P(occupied at the end point) + ε/2),   ε = outlierProb
 *
 * Where the map has no evidence, P is unobservedProb. ε/2 is the floor: one return that hits free space (a
 * person, a moved chair) costs at most log(ε/2). independence < 1 flattens the result, because neighbouring
 * rays err together: without it a few hundred rays single out one particle. Unnormalized: to compare poses
 * only. */
[[nodiscard]] double endPointLogLikelihood(const CLearnedMap& map, const EndPoints& endPoints,
                                           const mrpt::poses::CPose3D& robotPose,
                                           const CLearnedMap::TLikelihoodOptions& options);

}  // namespace lamap
