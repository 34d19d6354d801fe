#pragma once

#include <lamap_core/learning/logistic_problem.h>
#include <lamap_core/math/workers.h>

#include <array>
#include <vector>

namespace lamap
{
/** Minimizes φ from u by the limited-memory BFGS method, preconditioned with the diagonal of the Hessian at
 * the start. Steps along a direction are found by Newton's method on the log-odds, which costs no feature.
 * Ends early where φ cannot be made smaller in single precision. Working memory is kept from call to call.
 * The number of threads changes no bit. */
class Lbfgs
{
 public:
  /// @param iterations at most
  void minimize(const LogisticProblem& problem, int iterations, std::vector<float>& u,
                const Workers& workers);

  /// Of the last minimize(): the diagonal of the Hessian at its end, Λⱼ + Σᵢ wᵢ·pᵢ(1 − pᵢ)·F_ij², which is
  /// the precision of Laplace's approximation.
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

  std::vector<float> logodds_, logoddsStep_, prob_, residual_;                // per point
  std::vector<float> gradient_, lastGradient_, inverseDiagonal_, direction_;  // per weight
  static constexpr size_t kMemory = 6;  ///< pairs of steps and changes of the gradient that are kept
  std::array<Pair, kMemory> pairs_;
  std::vector<Slope> slopes_;
};

}  // namespace lamap
