#pragma once

#include <lamap_core/scan/ray_selection.h>
#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <lamap_mrpt/learned_map/cell_hash.h>
#include <lamap_mrpt/observations/observation_fingerprint.h>
#include <mrpt/poses/CPose3D.h>

#include <tsl/robin_map.h>

#include <Eigen/Core>
#include <cstdint>
#include <mutex>
#include <optional>
#include <vector>

namespace lamap
{
/// P(occupied) of cells, one after another.
class CellProbs
{
 public:
  virtual ~CellProbs() = default;
  /// Nothing where there is no evidence.
  [[nodiscard]] virtual std::optional<double> prob(const CellIndex& cell) = 0;
};

/// The returns of one observation in the robot's frame, decimated as likelihoodOptions say.
struct EndPoints
{
  struct End
  {
    Eigen::Vector3d point_robot;
    Eigen::Vector3d backwards_robot;  ///< unit vector to where its ray came from; zero on the sensor itself
    double range_m;
  };
  std::optional<ObservationFingerprint> observation;  ///< empty: must not be reused
  RangeOptions limits;
  std::vector<End> ends;
};

/** The returns of an observation that are within the limits.
 * @return empty for an observation that cannot be read as rays.
 * @throws as raysOf(). */
[[nodiscard]] EndPoints endPointsOf(const mrpt::obs::CObservation& observation, const RangeOptions& limits);

/** Log-likelihood of returns, given the map and a pose of the robot:
 *
 *   independence · Σ log((1 − ε)·P·F + ε/2),   ε = outlierProb
 *
 * P is P(occupied) for an end point whose position is uncertain by σ = endPointStd: the largest
 * P(cell) · exp(−d²/2σ²) over the surrounding cells, with d from centre to centre (if σ is 0: P of the end
 * point's cell alone). If the map has no evidence there, the end point's own cell counts with unobservedProb.
 *
 * F is P(free) of the cell that holds the point of the ray freeBefore before its end (or two cells before it,
 * if that is farther; unobserved: 1 − unobservedProb): a ray passes through free space until it ends. Without
 * it, an end deep inside a thick wall is as likely as one on its surface, and learned walls are thick. F is 1
 * if freeBefore is 0, and for a ray that is too short.
 *
 * ε/2 is the floor: a return in free space (a person, a moved chair) costs at most log(ε/2). independence < 1
 * flattens the result, because neighbouring rays have correlated errors: otherwise a few hundred rays would
 * single out one particle. Unnormalized: only for comparing poses.
 *
 * A cell's term is computed when the first end point falls into it, and cached, because a particle filter
 * returns to it many times. Terms that are older than the map's last change are computed anew when they are
 * asked for; their places stay, so that a filter that inserts scan after scan allocates nothing. May be used
 * from several threads. */
class EndPointLikelihood
{
 public:
  /// @param map must outlive this object; a change must be told by its contentChanged().
  EndPointLikelihood(const CLearnedMap& map, const CLearnedMap::TLikelihoodOptions& options);

  /// Whether it is what would be made for the map now: another may have been put in its place.
  [[nodiscard]] bool isCurrent() const
  {
    return options_.sameOptions(map_.likelihoodOptions) && resolution_ == map_.resolution() &&
           layer_ == map_.planarLayer();
  }

  [[nodiscard]] double logOf(const EndPoints& endPoints, const mrpt::poses::CPose3D& robotPose) const;

 private:
  struct Neighbour
  {
    CellIndex offset;
    double weight;
  };
  /// A cell's probability, and at which change of the map it was computed.
  struct Prob
  {
    float prob = 0;
    uint32_t change = 0;
  };
  using Probs = tsl::robin_map<CellIndex, Prob, CellIndexHash>;
  // The caller holds the lock.
  [[nodiscard]] double sumOf(CellProbs& cells, const EndPoints& endPoints,
                             const mrpt::poses::CPose3D& robotPose) const;
  /// P for an end point.
  [[nodiscard]] double probAt(CellProbs& cells, const Eigen::Vector3d& point_map) const;
  /// P(occupied) of the cell that holds a point.
  [[nodiscard]] double ownProbAt(CellProbs& cells, const Eigen::Vector3d& point_map) const;
  template <typename Compute>
  [[nodiscard]] double kept(Probs& probs, const Eigen::Vector3d& point_map, Compute&& compute) const;
  [[nodiscard]] double probAround(CellProbs& cells, const CellIndex& cell) const;

  const CLearnedMap& map_;
  CLearnedMap::TLikelihoodOptions options_;
  double resolution_;
  double freeBefore_m_ = 0;
  std::optional<int32_t> layer_;
  std::vector<Neighbour> neighbours_;  ///< the cell itself, then the others, by decreasing weight
  mutable std::mutex mutex_;
  mutable Probs ends_;
  mutable Probs ownCells_;
};

}  // namespace lamap
