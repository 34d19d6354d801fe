#pragma once

#include <lamap_core/features/rows.h>

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
  const std::vector<float>& labels;     ///< y of each point, 0 or 1
  const std::vector<float>& weights;    ///< w of each point, > 0
  const std::vector<float>& mean;       ///< μ of each weight; 0 where rows have no feature
  const std::vector<float>& precision;  ///< Λ of each weight, ≥ 0
};

}  // namespace lamap
