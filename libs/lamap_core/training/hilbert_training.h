#pragma once

#include <lamap_core/scan/lattice_frame.h>
#include <lamap_core/scan/ray_selection.h>

#include <Eigen/Core>
#include <memory>
#include <vector>

namespace lamap
{
/// What the training points of a scan are.
enum class HilbertPoints
{
  Cells,  ///< each hit cell and each free cell of the scan once, at its centre; no free one that has a hit
  Points  ///< each hit and each free sample by itself, where it is (thesis)
};

/// How a scan's rays become training points.
struct HilbertSampling
{
  HilbertPoints trainingPoints = HilbertPoints::Cells;
  double freeMargin = 0.15;     ///< [m] ≥ 0: the free sample nearest to a hit is so far before it
  double freeResolution = 0.3;  ///< [m] ≥ 0.001: distance between free samples, from there back to the sensor
  double hitWeight = 2.0;       ///< weight of a hit [-], > 0
  double freeWeight = 1.0;      ///< weight of a free point [-], ≥ 0; 0: no free points

  /// @throws std::invalid_argument naming the first illegal option, its value and the legal range.
  void validate() const;

  friend bool operator==(const HilbertSampling& a, const HilbertSampling& b);
};

/// What makes a scan's points uncertain, as options (thesis 3.2.4; Ramos and Ott 2015).
struct UncertainInputs
{
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
};

/// Weighted points with label 1 (occupied) or 0 (free).
struct HilbertTrainingSet
{
  std::vector<Eigen::Vector3d> points;  ///< [m] in a HilbertFrame
  std::vector<float> labels;            ///< 0 or 1
  std::vector<float> weights;           ///< > 0
  /// [m²] of each point; empty where all points are certain.
  std::vector<Eigen::Matrix3d> covariances;

  [[nodiscard]] size_t size() const { return points.size(); }
  void clear();
  void add(const Eigen::Vector3d& point, bool occupied, double weight);
};

/** Makes training sets; keeps its working memory from scan to scan.
 *
 * Definitions. Rays of a fan that end in the same cell are one ray to their mean (`Cells` only). A ray with a
 * hit has free samples freeMargin before its end and then every freeResolution towards the sensor, as far as
 * the sensor itself; a ray without a hit has its first one at its end. */
class HilbertSampler
{
 public:
  HilbertSampler();
  ~HilbertSampler();

  /** @param rays in the frame that frame.cells takes [m]; counts.outside and counts.tooNear grow by rays that
   *  end too far from the anchor, or that a planar map sees as points
   *  @return the training set in the order of blocks of cells (`Cells`) or of rays; valid until the next
   *  call. Covariances are left empty.
   *  @throws std::length_error if the scan touches too many blocks of cells, see ScanBlocks, or has too many
   *  points. */
  HilbertTrainingSet& sample(SelectedRays& rays, const HilbertSampling& sampling, const HilbertFrame& frame);

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace lamap
