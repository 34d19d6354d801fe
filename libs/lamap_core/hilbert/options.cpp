#include <lamap_core/hilbert/options.h>

#include <stdexcept>
#include <string>

namespace lamap
{
void HilbertStructure::validate() const
{
  CellOptions::validate();
  FeatureOptions::validate();
  validateLattice(resolution);
  if (training == HilbertTraining::Incremental && features == HilbertFeatures::Nystroem)
    throw std::invalid_argument(
        "features = nystroem: training = incremental needs compact features; batch and sgd take both");
}

bool operator==(const HilbertStructure& a, const HilbertStructure& b)
{
  return static_cast<const CellOptions&>(a) == static_cast<const CellOptions&>(b) &&
         static_cast<const FeatureOptions&>(a) == static_cast<const FeatureOptions&>(b) &&
         a.training == b.training;
}

HilbertSolver HilbertInference::solverFor(HilbertTraining training) const
{
  return solver.value_or(training == HilbertTraining::Sgd ? HilbertSolver::SgdL1 : HilbertSolver::Lbfgs);
}

uint32_t HilbertInference::iterationsFor(HilbertTraining training) const
{
  return iterations.value_or(training == HilbertTraining::Incremental ? 10U : 25U);
}

void HilbertInference::validate(const HilbertStructure& structure) const
{
  rangeLimits().validate();
  HilbertSampling::validate();
  const HilbertSolver chosen = solverFor(structure.training);
  if (structure.training == HilbertTraining::Incremental && chosen != HilbertSolver::Lbfgs)
    throw std::invalid_argument(std::string("solver = ") +
                                (chosen == HilbertSolver::SgdL1 ? "sgdL1" : "sgdL2") +
                                ": training = incremental needs lbfgs, which gives a posterior");
  if (structure.training == HilbertTraining::Sgd && chosen == HilbertSolver::Lbfgs)
    throw std::invalid_argument("solver = lbfgs: training = sgd needs sgdL1 or sgdL2");
  requireIterations(iterationsFor(structure.training));
  DescentOptions::validate();
  thresholds.validate();
}

}  // namespace lamap
