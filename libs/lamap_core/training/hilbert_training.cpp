#include <lamap_core/training/hilbert_training.h>

#include <Eigen/LU>
#include <cmath>

namespace lamap
{
void HilbertTrainingSet::clear()
{
  points.clear();
  labels.clear();
  weights.clear();
  covariances.clear();
  variances.clear();
}

void HilbertTrainingSet::add(const Eigen::Vector3d& point, bool occupied, double weight)
{
  points.push_back(point);
  labels.push_back(occupied ? 1.0f : 0.0f);
  weights.push_back(static_cast<float>(weight));
}

void HilbertTrainingSet::add(const TrainingPoint& point, const HilbertFrame& frame)
{
  add(frame.position(point.place), point.occupied, point.weight);
  if (!(point.width > 0) && covariances.empty()) return;
  covariances.resize(size(), Eigen::Matrix3d::Zero());
  const double std_m = point.width * frame.cells.resolution_m();
  covariances.back().diagonal().setConstant(std_m * std_m);
}

void HilbertTrainingSet::append(const TrainingSet& set, const HilbertFrame& frame)
{
  set.forEachPoint([&](const TrainingPoint& point) { add(point, frame); });
}

void HilbertTrainingSet::blur(size_t first, const HilbertUncertainty& uncertainty,
                              const Eigen::Vector3d& sensor, double gamma, bool planar)
{
  covariances.resize(size(), Eigen::Matrix3d::Zero());
  variances.resize(size(), 0.0f);
  for (size_t i = first; i < size(); ++i)
  {
    const Eigen::Matrix3d added = uncertainty.of(points[i], sensor);
    const Eigen::Matrix3d covariance = planar ? inPlane(added) : added;
    covariances[i] += covariance;
    variances[i] = static_cast<float>(covariance.trace() / (planar ? 2 : 3));
    weights[i] *= static_cast<float>(
        1 / std::sqrt((Eigen::Matrix3d::Identity() + 4 * gamma * covariance).determinant()));
  }
}

}  // namespace lamap
