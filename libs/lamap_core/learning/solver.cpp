#include <lamap_core/learning/solver.h>

#include <lamap_core/learning/sgd.h>

namespace lamap
{
uint64_t Solver::solve(const LogisticProblem& problem, const SolverSettings& settings, uint64_t stepsBefore,
                       std::vector<float>& u, const Workers& workers)
{
  if (settings.solver == HilbertSolver::Lbfgs)
  {
    lbfgs_.minimize(problem, settings.iterations, u, workers);
    return stepsBefore;
  }
  const SgdPenalty penalty = settings.solver == HilbertSolver::SgdL1 ? SgdPenalty::L1 : SgdPenalty::L2;
  return trainSgd(problem.rows, problem.labels, problem.weights, {settings.descent, penalty, settings.seed},
                  stepsBefore, u);
}

}  // namespace lamap
