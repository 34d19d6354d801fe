#pragma once

#include <lamap_core/features/rows.h>
#include <lamap_core/math/workers.h>

#include <vector>

namespace lamap
{
/** Logistic regression with a Gaussian prior: what is to be minimized over the weights u is
 *
 *   φ(u) = Σᵢ wᵢ·log(1 + exp(−(2yᵢ − 1)·fᵢ)) + ½ Σⱼ Λⱼ (uⱼ − μⱼ)²,  f = F·u
 *
 * with labels y in {0, 1} and P(y = 1) = 1/(1 + e^−f). (Thesis eq. 2.30 as printed has the other sign,
 * against 2.35.) */
struct LogisticProblem
{
  FeatureRows& rows;
  const std::vector<float>& labels;     ///< y, 0 or 1, a point
  const std::vector<float>& weights;    ///< w > 0, a point
  const std::vector<float>& mean;       ///< μ, a weight; 0 where rows have no feature
  const std::vector<float>& precision;  ///< Λ ≥ 0, a weight

  /// φ(u), in double.
  [[nodiscard]] double objective(const std::vector<float>& u, const Workers& workers) const;
  /// ∂φ/∂u, 0 where rows have no feature.
  void gradient(const std::vector<float>& u, std::vector<float>& g, const Workers& workers) const;
  /// The prior's part of the gradient, Λ(u − μ), is added to g.
  void addPriorGradient(const std::vector<float>& u, std::vector<float>& g) const;
  /// Diagonal of the Hessian, Λⱼ + Σᵢ wᵢ·pᵢ(1 − pᵢ)·F_ij²: the precision of Laplace's approximation.
  void curvature(const std::vector<float>& u, std::vector<float>& diagonal, const Workers& workers) const;
};

}  // namespace lamap
