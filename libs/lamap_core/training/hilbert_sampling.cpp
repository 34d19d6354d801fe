#include <lamap_core/training/hilbert_sampling.h>

#include <lamap_core/options/legal_range.h>
#include <lamap_core/training/covariance.h>

#include <cmath>

namespace lamap
{
namespace
{
Eigen::Matrix3d crossMatrix(const Eigen::Vector3d& v)
{
  Eigen::Matrix3d matrix;
  matrix << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return matrix;
}

}  // namespace

SamplingRules HilbertSampling::rules(const BeamOptions& beams) const
{
  const bool asCells = trainingPoints == HilbertPoints::Cells;
  SamplingRules rules{beams};
  rules.samplesFrom = SamplesFrom::End;
  rules.points = asCells ? TrainingPoints::Cells : TrainingPoints::Centroids;
  rules.freeResolution = freeResolution;
  rules.freeMargin = freeMargin;
  rules.protectHits = asCells ? 1 : 0;
  rules.keepGlancingSurfaces = asCells;
  rules.hitWeight = hitWeight;
  rules.freeWeight = freeWeight;
  return rules;
}

bool HilbertUncertainty::any() const
{
  return !pose.isZero(0) || rangeStd_m > 0 || !point.isZero(0);
}

void HilbertUncertainty::validate() const
{
  requireCovariance(pose, "covariance of the pose");
  requireCovariance(point, "covariance of a point");
  // Beyond these, the covariance of a point would not be finite.
  constexpr double kMostCoordinate_m = 1e13;
  constexpr double kMostStd_m = 1e6;
  const double farthest_m = centre.allFinite() ? centre.cwiseAbs().maxCoeff() : centre.sum();
  requireLegal(farthest_m <= kMostCoordinate_m, "centre of rotation", farthest_m,
               "within 1e13 m of the origin");
  requireLegal(rangeStd_m >= 0 && rangeStd_m <= kMostStd_m, "standard deviation of ranges", rangeStd_m,
               "from 0 to 1e6 m");
}

Eigen::Matrix3d HilbertUncertainty::of(const Eigen::Vector3d& place, const Eigen::Vector3d& sensor) const
{
  Eigen::Matrix<double, 3, 6> change;  // of the place with the pose: t + ω × (place − centre)
  change.leftCols<3>().setIdentity();
  change.rightCols<3>() = -crossMatrix(place - centre);
  // Products without Eigen's kernels, which may fuse where a processor can.
  Eigen::Matrix3d sum = point;
  const Eigen::Vector3d ray = place - sensor;
  const double squaredRange = ray.squaredNorm();
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
    {
      for (int i = 0; i < 6; ++i)
        for (int j = 0; j < 6; ++j) sum(row, column) += change(row, i) * pose(i, j) * change(column, j);
      if (squaredRange > 0)
        sum(row, column) += rangeStd_m * rangeStd_m * ray[row] * ray[column] / squaredRange;
    }
  return sum;
}

Eigen::Matrix3d inPlane(const Eigen::Matrix3d& covariance)
{
  Eigen::Matrix3d flat = covariance;
  flat.row(2).setZero();
  flat.col(2).setZero();
  return flat;
}

bool countsInItsCell(const Eigen::Matrix3d& covariance, double resolution_m, bool planar)
{
  constexpr double kMost_cells = 2.5;
  const double most_m = kMost_cells * resolution_m;
  return (planar ? inPlane(covariance) : covariance).trace() <= most_m * most_m;
}

}  // namespace lamap
