#pragma once

#include <lamap_core/features/logodds.h>
#include <lamap_core/features/nystroem_rows.h>
#include <lamap_core/features/rows.h>
#include <lamap_core/training/hilbert_training.h>

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace lamap
{
/** Nyström features of the radial basis function kernel (thesis 2.4.2): φ(x) = L⁻¹ (k(x, x̂₁), …, k(x, x̂ₘ))
 * with L·Lᵀ = K + jitter·I and K the kernel matrix of the inducing points x̂. L⁻¹ is D^(−1/2)Vᵀ of eq. 2.33
 * but for a rotation, so φ(x)ᵀφ(x') is the same; the jitter stands for eigenvalues that are zero but for
 * rounding. With all points inducing, this is the full kernel.
 *
 * All arithmetic is in a fixed order: the same on every processor.
 * Immutable once fitted: may be shared between threads. */
class NystroemFeatures
{
 public:
  static constexpr double kJitter = 1e-3;

  NystroemFeatures() = default;

  /** @param points [m], at least one; @param components m ≥ 1; @param gamma [m⁻²] finite, > 0
   *  @param seed of the random subset; where m is not below the number of points, all are inducing
   *  @throws std::invalid_argument naming the parameter, its value and the legal range */
  NystroemFeatures(const std::vector<Eigen::Vector3d>& points, size_t components, double gamma,
                   uint64_t seed);

  /// With these inducing points [m], e.g. from a file.
  NystroemFeatures(std::vector<Eigen::Vector3d> inducing, double gamma);

  [[nodiscard]] size_t memoryBytes() const
  {
    return components() * sizeof(Eigen::Vector3d) + inverse_.size() * sizeof(double) +
           (rows_ ? rows_->memoryBytes() : 0);
  }
  [[nodiscard]] size_t components() const { return inducing_.size(); }
  [[nodiscard]] double gamma() const { return gamma_; }
  [[nodiscard]] const std::vector<Eigen::Vector3d>& inducing() const { return inducing_; }

  /** Features of the training points, one run per point, followed by the bias.
   * Weight j is that of component j; the bias comes after them, followed only by padding. */
  void rowsOf(const HilbertTrainingSet& set, FeatureRows& rows, const Workers& workers) const;
  /// How many weights rowsOf() has, padding included; the bias is number components().
  [[nodiscard]] size_t weightCount() const { return (components() + 4) / 4 * 4; }

  /// A classifier as a sum of kernels: f(x) = Σ folded[k]·k(x, x̂ₖ) + bias.
  struct Folded
  {
    std::vector<float> kernelWeights;  ///< L⁻ᵀ·u
    float bias = 0;
  };
  [[nodiscard]] Folded fold(const std::vector<float>& u) const;

  /// Log-odds at a point [m].
  [[nodiscard]] double logoddsAt(const Folded& classifier, const Eigen::Vector3d& point) const;
  /// Expected log-odds at an uncertain point.
  [[nodiscard]] double logoddsAt(const Folded& classifier, const Eigen::Vector3d& point,
                                 const Eigen::Matrix3d& covariance) const;
  /// Log-odds at regular points, x fastest, then y, then z.
  void logoddsAt(const Folded& classifier, const RegularPoints& points, std::vector<float>& logodds,
                 const Workers& workers) const;

 private:
  void factorize();
  void kernelsOf(const HilbertTrainingSet& set, size_t point, bool wide, float* kernels) const;

  double gamma_ = 1;
  std::vector<Eigen::Vector3d> inducing_;
  std::vector<double> inverse_;       ///< L⁻¹, lower triangle by rows, each of components() numbers
  std::optional<NystroemRows> rows_;  ///< of positions less the first inducing point's
};

}  // namespace lamap
