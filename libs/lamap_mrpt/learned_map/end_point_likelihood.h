#pragma once

#include <lamap_core/scan/ray_selection.h>
#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <lamap_mrpt/learned_map/cell_hash.h>
#include <lamap_mrpt/observations/observation_fingerprint.h>
#include <mrpt/poses/CPose3D.h>

#include <tsl/robin_map.h>

#include <Eigen/Core>
#include <mutex>
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
 *   independence · Σ log((1 − ε)·P + ε/2),   ε = outlierProb
 *
 * P is P(occupied) as an end point sees it whose place is uncertain by σ = endPointStd: the largest
 * P(cell) · exp(−d²/2σ²) over the cells around, d from centre to centre (without σ: of the end point's cell
 * alone). Where the map has no evidence, unobservedProb counts for the end point's own cell.
 *
 * ε/2 is the floor: one return that hits free space (a person, a moved chair) costs at most log(ε/2).
 * independence < 1 flattens the result, because neighbouring rays err together: without it a few hundred rays
 * single out one particle. Unnormalized: to compare poses only.
 *
 * Each cell is looked at when the first end point falls into it, and kept: a particle filter comes back to it
 * many times. May be used from several threads. */
class EndPointLikelihood
{
 public:
  /// @param map is to live, unchanged, as long as this.
  EndPointLikelihood(const CLearnedMap& map, const CLearnedMap::TLikelihoodOptions& options);

  [[nodiscard]] const CLearnedMap::TLikelihoodOptions& options() const { return options_; }

  [[nodiscard]] double logOf(const EndPoints& endPoints, const mrpt::poses::CPose3D& robotPose) const;

 private:
  struct Neighbour
  {
    CellIndex offset;
    double weight;
  };
  /// log((1 − ε)·P + ε/2); whoever asks holds the lock.
  [[nodiscard]] double termAt(const Eigen::Vector3d& point_map) const;
  [[nodiscard]] double probAround(const CellIndex& cell) const;
  [[nodiscard]] double termOf(double prob) const;

  const CLearnedMap& map_;
  CLearnedMap::TLikelihoodOptions options_;
  double resolution_;
  std::optional<int32_t> layer_;
  std::vector<Neighbour> neighbours_;  ///< the cell itself, then the others, heaviest first
  mutable std::mutex mutex_;
  mutable tsl::robin_map<CellIndex, float, CellIndexHash> terms_;
};

}  // namespace lamap
