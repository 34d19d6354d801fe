#pragma once

#include <lamap_core/training/sampling_rules.h>

#include <Eigen/Core>

namespace lamap
{
/// What the training points of a scan are.
enum class HilbertPoints
{
  Cells,  ///< each hit cell and each free cell of the scan once, at its centre; no free one that has a hit
  Points  ///< each hit and each free sample by itself, where it is (thesis)
};

/// How a scan's rays become training points: backwards from their ends.
struct HilbertSampling
{
  HilbertPoints trainingPoints = HilbertPoints::Cells;
  double freeMargin = 0.15;     ///< [m] ≥ 0: distance of the last free sample from its hit
  double freeResolution = 0.3;  ///< [m] ≥ 0.001: distance between free samples, from there back to the sensor
  double hitWeight = 2.0;       ///< weight of a hit [-], > 0
  double freeWeight = 1.0;      ///< weight of a free point [-], ≥ 0; 0: no free points

  [[nodiscard]] SamplingRules rules(const BeamOptions& beams = {}) const;
};

/// What makes a scan's points uncertain, as options (thesis 3.2.4; Ramos and Ott 2015).
struct UncertainInputs : public BeamOptions
{
  /// Heavier echoes raise the recall of a Hilbert map less than they cost in log loss.
  UncertainInputs() { echoWeight = 1; }

  bool usePoseCovariance = false;  ///< of the pose that an observation is inserted at, where it has one
  double rangeStd = 0.0;           ///< [m] along each ray
  double pointStd = 0.0;           ///< [m] of each point, along each axis
};

/// How sure it is where a scan's points are, for Gaussian errors.
struct HilbertUncertainty
{
  /// Of the sensor's pose in the map: translation [m], then rotation vector [rad], both along the axes of the
  /// frame that points are given in, the rotation about `centre`.
  Eigen::Matrix<double, 6, 6> pose = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< [m]
  double rangeStd_m = 0;                             ///< along each ray
  Eigen::Matrix3d point = Eigen::Matrix3d::Zero();   ///< [m²] of each point by itself

  [[nodiscard]] bool any() const;
  /// @throws std::invalid_argument unless all is finite, variances are ≥ 0 and matrices symmetric.
  void validate() const;

  /** Covariance of a point [m²].
   * @param place [m], in the frame of `centre`; @param sensor [m] likewise, where its ray came from */
  [[nodiscard]] Eigen::Matrix3d of(const Eigen::Vector3d& place, const Eigen::Vector3d& sensor) const;

  friend bool operator==(const HilbertUncertainty& a, const HilbertUncertainty& b)
  {
    return a.pose == b.pose && a.centre == b.centre && a.rangeStd_m == b.rangeStd_m && a.point == b.point;
  }
};

/// A covariance without its height, for planar maps.
[[nodiscard]] Eigen::Matrix3d inPlane(const Eigen::Matrix3d& covariance);

/** Is it certain enough where a point is for a ray to count in the cell where it ended or passed?
 * It is if the point's standard deviation, over all axes, is at most 2.5 cells, which was chosen by log
 * loss and AUC. @param covariance [m²] */
[[nodiscard]] bool countsInItsCell(const Eigen::Matrix3d& covariance, double resolution_m, bool planar);

}  // namespace lamap
