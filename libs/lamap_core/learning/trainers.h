#pragma once

#include <lamap_core/features/rows.h>
#include <lamap_core/math/workers.h>

#include <cstdint>
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
  /// Diagonal of the Hessian, Λⱼ + Σᵢ wᵢ·pᵢ(1 − pᵢ)·F_ij²: the precision of Laplace's approximation.
  void curvature(const std::vector<float>& u, std::vector<float>& diagonal, const Workers& workers) const;
};

struct LbfgsOptions
{
  int iterations = 25;  ///< at most
  int memory = 6;       ///< pairs of steps and changes of the gradient that are kept, ≥ 1
};

/** Minimizes φ from u by the limited-memory BFGS method, preconditioned with the diagonal of the Hessian at
 * the start. Steps along a direction are found by Newton's method on the log-odds, which costs no feature.
 * Ends early where φ cannot be made smaller in single precision. Working memory is kept from call to call.
 * The number of threads changes no bit. */
class Lbfgs
{
 public:
  /// @return iterations done
  int minimize(const LogisticProblem& problem, const LbfgsOptions& options, std::vector<float>& u,
               const Workers& workers);

  /// Of the last minimize(): the diagonal of the Hessian at its end, see LogisticProblem::curvature().
  void finalCurvature(const LogisticProblem& problem, std::vector<float>& diagonal, const Workers& workers);

 private:
  struct Pair
  {
    std::vector<float> step;
    std::vector<float> change;
    double inverseProduct = 0;
  };
  struct Slope
  {
    double first = 0;   ///< derivative along the direction
    double second = 0;  ///< and its derivative
  };

  void residualsOf(const LogisticProblem& problem);
  void chooseDirection(size_t pairs, size_t newest);
  void probabilitiesAt(float step, const Workers& workers);
  Slope slopeNow(const LogisticProblem& problem, const Slope& prior, const Workers& workers);
  bool searchLine(const LogisticProblem& problem, const std::vector<float>& u, const Workers& workers,
                  float& step);

  std::vector<float> logodds_, logoddsStep_, prob_, residual_;                // a point
  std::vector<float> gradient_, lastGradient_, inverseDiagonal_, direction_;  // a weight
  std::vector<Pair> pairs_;
  std::vector<Slope> slopes_;
};

/// What SGD keeps small beside the loss.
enum class SgdPenalty
{
  L1,  ///< α·Σ|u|, thesis eq. 2.34, as cumulative penalties (Tsuruoka, Tsujii and Ananiadou 2009)
  L2   ///< α·½Σu²
};

struct SgdOptions
{
  SgdPenalty penalty = SgdPenalty::L1;
  double alpha = 1e-5;  ///< α, > 0
  int epochs = 5;       ///< passes over all points, ≥ 1
  uint64_t seed = 1;    ///< of the order of points in each pass
};

/** Minimizes (1/n)·Σᵢ wᵢ·Lᵢ + α·penalty (thesis eq. 2.34) from u, point by point in random order. The step is
 * 1/(α(t₀ + t)) in step t, Bottou's choice and scikit-learn's. The bias, where there is one, is not
 * penalized.
 * @param stepsBefore t at the start, for a classifier that learns on; @return t at the end
 * @throws std::invalid_argument naming an illegal option. */
uint64_t trainSgd(const FeatureRows& rows, const std::vector<float>& labels,
                  const std::vector<float>& weights, const SgdOptions& options, uint64_t stepsBefore,
                  std::vector<float>& u);

}  // namespace lamap
