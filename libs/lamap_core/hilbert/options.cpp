#include <lamap_core/hilbert/options.h>

#include <lamap_core/options/legal_range.h>

#include <cmath>
#include <stdexcept>
#include <string>

namespace lamap
{
CompactKernel HilbertStructure::kernel() const
{
  constexpr double kNystroemGamma = 3.0;
  const double usual = features == HilbertFeatures::Compact ? CompactKernel::kDefaultGamma : kNystroemGamma;
  return CompactKernel(gamma.value_or(usual), cutoff);
}

std::optional<int32_t> HilbertStructure::planarLayer() const
{
  if (!planar) return std::nullopt;
  return static_cast<int32_t>(std::floor(planarHeight / resolution));
}

void HilbertStructure::validate() const
{
  requireLegal(resolution > 0 && std::isfinite(resolution), "resolution", resolution, "a finite length > 0");
  requireLegal(std::abs(planarHeight / resolution) < 2e9, "planarHeight", planarHeight,
               "a height that cells can address");
  AxisReaches::requireReach(kernel(), latticeSpacing);
  requireSupport(kernel(), resolution);
  requireLegal(components >= 1 && components <= 5000, "components", components,
               "a whole number from 1 to 5000");
  requireLegal(priorPrecision >= 1e-6 && priorPrecision <= 1e6, "priorPrecision", priorPrecision,
               "a number from 1e-6 to 1e6");
  if (training == HilbertTraining::Incremental && features == HilbertFeatures::Nystroem)
    throw std::invalid_argument(
        "features = nystroem: training = incremental needs compact features; batch and sgd take both");
}

bool operator==(const HilbertStructure& a, const HilbertStructure& b)
{
  return a.resolution == b.resolution && a.planar == b.planar && a.planarHeight == b.planarHeight &&
         a.training == b.training && a.features == b.features && a.gamma == b.gamma && a.cutoff == b.cutoff &&
         a.latticeSpacing == b.latticeSpacing && a.components == b.components && a.seed == b.seed &&
         a.priorPrecision == b.priorPrecision;
}

HilbertSolver HilbertInference::solverFor(HilbertTraining training) const
{
  return solver.value_or(training == HilbertTraining::Sgd ? HilbertSolver::SgdL1 : HilbertSolver::Lbfgs);
}

uint32_t HilbertInference::iterationsFor(HilbertTraining training) const
{
  return iterations.value_or(training == HilbertTraining::Incremental ? 10U : 25U);
}

RangeLimits HilbertInference::rangeLimits() const
{
  return {minRange, maxRange, considerInvalidRangesAsFreeSpace, rayDecimation};
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
  const uint32_t most = iterationsFor(structure.training);
  requireLegal(most >= 1 && most <= 100000, "iterations", most, "a whole number from 1 to 100000");
  requireLegal(alpha >= 1e-12 && alpha <= 1e6, "alpha", alpha, "a number from 1e-12 to 1e6");
  requireLegal(epochs >= 1 && epochs <= 100000, "epochs", epochs, "a whole number from 1 to 100000");
  thresholds.validate();
}

}  // namespace lamap
