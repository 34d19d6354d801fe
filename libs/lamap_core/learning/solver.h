#pragma once

#include <lamap_core/learning/lbfgs.h>
#include <lamap_core/learning/solver_options.h>

#include <cstdint>
#include <vector>

namespace lamap
{
struct SolverSettings
{
  HilbertSolver solver = HilbertSolver::Lbfgs;
  int iterations = 25;     ///< of L-BFGS, at most
  DescentOptions descent;  ///< of SGD
  uint64_t seed = 1;       ///< of SGD
};

/// Finds the weights of a logistic problem by what the options choose; keeps its working memory.
class Solver
{
 public:
  /** @param stepsBefore of SGD, for weights that learn on
   *  @param u where to begin; receives the weights
   *  @return steps of SGD in all */
  uint64_t solve(const LogisticProblem& problem, const SolverSettings& settings, uint64_t stepsBefore,
                 std::vector<float>& u, const Workers& workers);

  /// As Lbfgs::finalCurvature(), after L-BFGS.
  void finalCurvature(const LogisticProblem& problem, std::vector<float>& diagonal, const Workers& workers)
  {
    lbfgs_.finalCurvature(problem, diagonal, workers);
  }

 private:
  Lbfgs lbfgs_;
};

}  // namespace lamap
