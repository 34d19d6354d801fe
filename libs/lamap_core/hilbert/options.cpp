#include <lamap_core/hilbert/options.h>

#include <lamap_core/options/hilbert_options.h>

#include <cmath>
#include <stdexcept>
#include <string>

namespace lamap
{
const OptionTable& HilbertStructure::optionTable()
{
  using Self = HilbertStructure;
  static const OptionTable table = []
  {
    OptionTableOf<Self> all("creationOpts");
    addResolutionOption(all);
    addPlanarOptions(all).add(
        "training", &Self::training, oneOf({"incremental", "batch", "sgd"}),
        "the posterior of the scans so far is the next one's prior; all points kept and "
        "trained on together; or a few epochs of descent per scan");
    return addFeatureOptions(all).check(
        [](const Self& self)
        {
          self.validateLattice(self.resolution);
          if (self.training == HilbertTraining::Incremental && self.features == HilbertFeatures::Nystroem)
            throw std::invalid_argument(
                "features = nystroem: training = incremental needs compact features; batch and sgd take "
                "both");
        });
  }();
  return table;
}

const OptionTable& HilbertInference::optionTable()
{
  using Self = HilbertInference;
  static const OptionTable table = []
  {
    OptionTableOf<Self> all("insertOpts");
    addSamplingOptions(all);
    all.include<RangeOptions>().add(
        "solver", &Self::solver, oneOf({"lbfgs", "sgdL1", "sgdL2"}),
        "algorithm that minimizes the loss; automatic: sgdL1 where training is sgd, otherwise lbfgs");
    addSolverOptions(all);
    addUncertaintyOptions(all);
    return addThresholdOptions(all);
  }();
  return table;
}

void HilbertStructure::validate() const
{
  requireLegalOptions(*this, resolution);
}

HilbertStructure HilbertStructure::resolved() const
{
  HilbertStructure filled = *this;
  filled.gamma = resolvedGamma();
  return filled;
}

bool operator==(const HilbertStructure& a, const HilbertStructure& b)
{
  return sameOptions(a, b);
}

HilbertSolver HilbertInference::solverFor(HilbertTraining training) const
{
  return solver.value_or(training == HilbertTraining::Sgd ? HilbertSolver::SgdL1 : HilbertSolver::Lbfgs);
}

uint32_t HilbertInference::iterationsFor(HilbertTraining training) const
{
  return iterations.value_or(training == HilbertTraining::Incremental ? 10U : 25U);
}

HilbertInference HilbertInference::resolved(const HilbertStructure& structure) const
{
  HilbertInference filled = *this;
  filled.solver = solverFor(structure.training);
  filled.iterations = iterationsFor(structure.training);
  return filled;
}

void HilbertInference::validate(const HilbertStructure& structure) const
{
  requireLegalOptions(*this, structure.resolution);
  const HilbertSolver chosen = solverFor(structure.training);
  if (structure.training == HilbertTraining::Incremental && chosen != HilbertSolver::Lbfgs)
    throw std::invalid_argument(std::string("solver = ") +
                                (chosen == HilbertSolver::SgdL1 ? "sgdL1" : "sgdL2") +
                                ": training = incremental needs lbfgs, which gives a posterior");
  if (structure.training == HilbertTraining::Sgd && chosen == HilbertSolver::Lbfgs)
    throw std::invalid_argument("solver = lbfgs: training = sgd needs sgdL1 or sgdL2");
}

HilbertOptions presetOptions(HilbertPreset preset)
{
  HilbertOptions options;
  if (preset == HilbertPreset::Default) return options;
  options.structure.training = HilbertTraining::Batch;
  options.structure.features = HilbertFeatures::Nystroem;
  HilbertInference& inference = options.inference;
  inference.solver = HilbertSolver::SgdL1;
  inference.trainingPoints = HilbertPoints::Points;
  inference.freeMargin = 0.0;
  inference.freeResolution = 0.5;
  inference.hitWeight = 1.0;
  inference.thresholds.occupied = StateThresholds::kOccupiedInThesis;
  inference.considerInvalidRangesAsFreeSpace = false;
  return options;
}

}  // namespace lamap
