#pragma once

#include <lamap_core/scan/lattice_frame.h>
#include <lamap_core/training/hilbert_training.h>
#include <support/seeded_scans.h>

#include <Eigen/Core>

#include <vector>

namespace lamap::test
{
/// k(d) = max(0, exp(−γ d²) − cutoff) by the C library.
double oracleCompactKernel(const Eigen::Vector3d& d, double gamma, double cutoff);

/// The training set of a scan, as Hilbert maps make it.
HilbertTrainingSet trainingSetOf(const Scan& scan, const RangeOptions& limits, const SamplingRules& rules,
                                 const HilbertFrame& frame, RayCounts* counts = nullptr);
/// The lattice's frame around the first fan of a scan, for sites of 0.25 m.
HilbertFrame frameAround(const Scan& scan, double resolution_m);

/// A seeded training set in a cube; labels follow a plane, some are wrong.
HilbertTrainingSet randomTrainingSet(Random& random, size_t points, double halfEdge_m);

/// Dense F: one row per point, one column per centre.
Eigen::MatrixXd denseCompactFeatures(const std::vector<Eigen::Vector3d>& points,
                                     const std::vector<Eigen::Vector3d>& centres, double gamma,
                                     double cutoff);

/// A Gaussian posterior of logistic regression after Laplace's approximation with a diagonal precision.
struct DensePosterior
{
  Eigen::VectorXd mean;
  Eigen::VectorXd precision;
};

/// Newton's method in double to convergence.
DensePosterior denseLaplace(const Eigen::MatrixXd& features, const HilbertTrainingSet& set,
                            const DensePosterior& prior);

/// Σ w·logloss + ½ Σ Λ (u − μ)².
double denseObjective(const Eigen::MatrixXd& features, const HilbertTrainingSet& set,
                      const DensePosterior& prior, const Eigen::VectorXd& u);

}  // namespace lamap::test
