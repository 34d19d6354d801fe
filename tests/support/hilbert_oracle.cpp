#include <support/hilbert_oracle.h>

#include <lamap_core/training/sampler.h>

#include <Eigen/Cholesky>

#include <cmath>

namespace lamap::test
{
double oracleCompactKernel(const Eigen::Vector3d& d, double gamma, double cutoff)
{
  return std::max(0.0, std::exp(-gamma * d.squaredNorm()) - cutoff);
}

HilbertTrainingSet trainingSetOf(const Scan& scan, const RangeOptions& limits, const SamplingRules& rules,
                                 const HilbertFrame& frame, RayCounts* counts)
{
  Sampler sampler;
  const TrainingSet& taught = sampler.sample(selectRays(scan, limits), rules, frame.cells, {}, 1);
  if (counts != nullptr) *counts = taught.counts;
  HilbertTrainingSet set;
  set.append(taught, frame);
  return set;
}

HilbertFrame frameAround(const Scan& scan, double resolution_m)
{
  return *HilbertFrame::inMap(scan.inMap(scan.fans.at(0).centre), resolution_m, 0.25, {});
}

HilbertTrainingSet randomTrainingSet(Random& random, size_t points, double halfEdge_m)
{
  HilbertTrainingSet set;
  const Eigen::Vector3d normal = random.inCube(1.0);
  for (size_t i = 0; i < points; ++i)
  {
    const Eigen::Vector3d point = random.inCube(halfEdge_m);
    const bool occupied = (normal.dot(point) > 0) != random.chance(0.1);
    set.add(point, occupied, occupied ? 2.0 : 1.0);
  }
  return set;
}

Eigen::MatrixXd denseCompactFeatures(const std::vector<Eigen::Vector3d>& points,
                                     const std::vector<Eigen::Vector3d>& centres, double gamma, double cutoff)
{
  Eigen::MatrixXd features(points.size(), centres.size());
  for (size_t i = 0; i < points.size(); ++i)
    for (size_t j = 0; j < centres.size(); ++j)
      features(static_cast<long>(i), static_cast<long>(j)) =
          oracleCompactKernel(points[i] - centres[j], gamma, cutoff);
  return features;
}

double denseObjective(const Eigen::MatrixXd& features, const HilbertTrainingSet& set,
                      const DensePosterior& prior, const Eigen::VectorXd& u)
{
  const Eigen::VectorXd f = features * u;
  double sum = 0.5 * (prior.precision.array() * (u - prior.mean).array().square()).sum();
  for (long i = 0; i < f.size(); ++i)
  {
    const auto at = static_cast<size_t>(i);
    const double signedF = set.labels[at] > 0.5f ? f[i] : -f[i];
    const double loss =
        signedF > 0 ? std::log1p(std::exp(-signedF)) : -signedF + std::log1p(std::exp(signedF));
    sum += static_cast<double>(set.weights[at]) * loss;
  }
  return sum;
}

DensePosterior denseLaplace(const Eigen::MatrixXd& features, const HilbertTrainingSet& set,
                            const DensePosterior& prior)
{
  Eigen::VectorXd u = prior.mean;
  Eigen::VectorXd curvature(features.rows());
  double objective = denseObjective(features, set, prior, u);
  for (int iteration = 0; iteration < 200; ++iteration)
  {
    const Eigen::VectorXd f = features * u;
    Eigen::VectorXd residual(f.size());
    for (long i = 0; i < f.size(); ++i)
    {
      const auto at = static_cast<size_t>(i);
      const double p = 1 / (1 + std::exp(-f[i]));
      residual[i] = static_cast<double>(set.weights[at]) * (p - static_cast<double>(set.labels[at]));
      curvature[i] = static_cast<double>(set.weights[at]) * p * (1 - p);
    }
    const Eigen::VectorXd gradient =
        features.transpose() * residual + (prior.precision.array() * (u - prior.mean).array()).matrix();
    Eigen::MatrixXd hessian = features.transpose() * curvature.asDiagonal() * features;
    hessian.diagonal() += prior.precision;
    const Eigen::VectorXd step = hessian.ldlt().solve(gradient);
    double length = 1;
    while (length > 1e-10 && denseObjective(features, set, prior, u - length * step) > objective) length /= 2;
    u -= length * step;
    objective = denseObjective(features, set, prior, u);
    if (step.norm() < 1e-12 * (1 + u.norm())) break;
  }
  const Eigen::VectorXd added = (features.array().square().matrix().transpose() * curvature);
  return {u, prior.precision + added};
}

}  // namespace lamap::test
