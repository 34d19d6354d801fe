#pragma once

#include <lamap_core/scan/lattice_frame.h>
#include <lamap_core/training/hilbert_sampling.h>
#include <lamap_core/training/training_set.h>

#include <Eigen/Core>
#include <vector>

namespace lamap
{
/// Weighted points with label 1 (occupied) or 0 (free).
struct HilbertTrainingSet
{
  std::vector<Eigen::Vector3d> points;  ///< [m] in a HilbertFrame
  std::vector<float> labels;            ///< 0 or 1
  std::vector<float> weights;           ///< > 0
  /// [m²] of each point; empty where all points are certain.
  std::vector<Eigen::Matrix3d> covariances;
  /// [m²] of what blur() added to each point, mean over the axes; empty where it added nothing.
  std::vector<float> variances;

  [[nodiscard]] size_t size() const { return points.size(); }
  void clear();
  void add(const Eigen::Vector3d& point, bool occupied, double weight);
  /// @param point in the frame's cells; one with a width is equally uncertain along all axes
  void add(const TrainingPoint& point, const HilbertFrame& frame);
  /// Adds the points of a scan. @param set in the frame's cells
  void append(const TrainingSet& set, const HilbertFrame& frame);
  /** Adds covariance to the points from `first` on, which then weigh less: the factor |I + 4γΣ|^(−1/2) is the
   * mean of the squared kernel over where a point may be.
   * @param gamma of the kernel [m⁻²]; @param uncertainty in the frame of the points [m]; @param sensor [m]
   * likewise, where the rays came from
   * @param planar points move in the plane only */
  void blur(size_t first, const HilbertUncertainty& uncertainty, const Eigen::Vector3d& sensor, double gamma,
            bool planar);
};

}  // namespace lamap
