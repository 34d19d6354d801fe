#pragma once

#include <lamap_core/gp/tile.h>
#include <Eigen/Core>

#include <cstddef>
#include <vector>

namespace lamap
{
/** Matérn covariance with ν = 3/2, thesis eq. (2.24), of points whose unit is one cell:
 *   k(d) = σ_f² (1 + √3·d/l) exp(−√3·d/l).
 *
 * If all points are at cell centres, squared distances are whole numbers and k is tabulated. Uses operations
 * that give the same bits on every processor. Immutable: may be shared between threads. */
class GpCovariance
{
 public:
  /** @param lengthScale_cells l, > 0
   *  @param signalVariance σ_f², > 0
   *  @param farthest_cells largest distance along each axis between points that are all at cell centres; 0 if
   * they are not */
  GpCovariance(double lengthScale_cells, double signalVariance, int farthest_cells);

  [[nodiscard]] double signalVariance() const { return signalVariance_; }
  /// @param squared_cells distance². @return k(d), computed, not from the table.
  [[nodiscard]] double operator()(double squared_cells) const;
  /// Replaces squared distances by k.
  void replace(size_t count, GpTile* rows) const;

 private:
  double factor_;  ///< √3/l
  double signalVariance_;
  std::vector<double> table_;  ///< k of d² = 0, 1, …; empty: not tabulated
};

/// A training point [cells] and its label: 1 occupied, −1 free.
struct GpPoint
{
  Eigen::Vector3d place;
  double label;
  double noise = 0;  ///< variance of the label beyond that of all points, for an uncertain place
};

/** One exact Gaussian process, thesis eq. (2.22), (2.23), by a Cholesky factor of K(X, X) + σ_n² I, and what
 * uncertain places add to the noise of their points (input noise, McHutchon and Rasmussen 2011).
 *
 * The prediction for a cell does not depend on which cells are queried together. May be queried from several
 * threads. */
class GpExpert
{
 public:
  /// Working memory: one per thread.
  struct Scratch
  {
    std::vector<GpTile> solved;
  };
  struct Prediction
  {
    GpTile mean;      ///< of f, eq. (2.22)
    GpTile variance;  ///< of f, diagonal of eq. (2.23), > 0, at most σ_f²
    GpTile nearest;   ///< squared distance to the nearest training point [cells²]
  };

  /// @param noiseVariance σ_n², > 0. Coincident and contradictory points are legal.
  void train(const GpPoint* points, size_t count, const GpCovariance& covariance, double noiseVariance,
             Scratch& scratch);

  [[nodiscard]] size_t size() const { return x_.size(); }
  /// Corners of the training points' box [cells].
  [[nodiscard]] const Eigen::Vector3d& low() const { return low_; }
  [[nodiscard]] const Eigen::Vector3d& high() const { return high_; }

  /** @param squaredReach [cells²]: if no cell is closer than this to a training point, mean and variance are
   * not computed, only `nearest`
   *  @return whether any cell is closer */
  bool predict(const GpPlaces& places, double squaredReach, const GpCovariance& covariance, Scratch& scratch,
               Prediction& prediction) const;

 private:
  void factorize(const GpCovariance& covariance, std::vector<GpTile>& above);
  [[nodiscard]] const double* row(size_t i) const { return factor_.data() + i * (i + 1) / 2; }
  [[nodiscard]] double* row(size_t i) { return factor_.data() + i * (i + 1) / 2; }

  std::vector<double> x_, y_, z_;  ///< [cells]
  std::vector<double> noise_;      ///< σ_n² of each point
  std::vector<double> factor_;     ///< L by rows, packed
  std::vector<double> inverse_;    ///< 1/L_ii
  std::vector<double> whitened_;   ///< L⁻¹ y
  Eigen::Vector3d low_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d high_ = Eigen::Vector3d::Zero();
  double leastVariance_ = 0;
};

}  // namespace lamap
