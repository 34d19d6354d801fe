#include <lamap_core/overlapping/options.h>

#include <lamap_core/options/hilbert_options.h>

namespace lamap
{
const OptionTable& OverlappingStructure::optionTable()
{
  using Self = OverlappingStructure;
  static const OptionTable table = []
  {
    OptionTableOf<Self> all("creationOpts");
    addResolutionOption(all);
    addBlockOptions(all);
    addPlanarOptions(all);
    return addFeatureOptions(all)
        .add("outOfFieldLimit", &Self::outOfFieldLimit, plain().from(0).to(1e3),
             "limit of log-odds in cells outside the field of every scan; 0: no log-odds there")
        .add("fieldLimit", &Self::fieldLimit, plain().from(0).to(1e3),
             "limit that log-odds in cells in the field of scans tend to, because their sum is "
             "overconfident; 0: none")
        .add("keepModels", &Self::keepModels, plain(),
             "keep models, for queries at points and for moving them; otherwise only cells are kept")
        .onlyWhere({"cutoff", "latticeSpacing"}, {{"features", {"compact"}}})
        .check(
            [](const Self& self)
            {
              if (self.features == HilbertFeatures::Compact) self.validateLattice(self.resolution);
            });
  }();
  return table;
}

const OptionTable& OverlappingInference::optionTable()
{
  using Self = OverlappingInference;
  static const OptionTable table = []
  {
    OptionTableOf<Self> all("insertOpts");
    addSamplingOptions(all);
    all.include<RangeOptions>().add("solver", &Self::solver, oneOf({"lbfgs", "sgdL1", "sgdL2"}),
                                    "algorithm that minimizes the loss");
    addSolverOptions(all)
        .add("scansPerModel", &Self::scansPerModel, plain().from(1).to(1e4),
             "scans that one model is trained on together")
        .add("boxQuantile", &Self::boxQuantile, plain().from(0).to(0.4999),
             "share of training points excluded from a model's box at each of its ends, as outliers")
        .add("fieldNear", &Self::fieldNear, metres().from(0).to(kMetresMost),
             "cells within this distance of the sensor are in its field")
        .add("fieldDepth", &Self::fieldDepth, metres().from(0).to(kMetresMost),
             "the field extends this far behind the end of a ray")
        .add(
            "fieldAngle", &Self::fieldAngle, OptionTraits{"deg"}.from(0.1).to(90).orZero(),
            "width of the bins of directions that share a depth; 0: 5/4 of the distance between neighbouring "
            "beams, from 0.5 to 10")
        .add("fieldWeight", &Self::fieldWeight, plain().from(1e-3).to(1e3),
             "weight of log-odds in the field, because their sum is overconfident");
    addUncertaintyOptions(all);
    return addThresholdOptions(all).check(
        [](const Self& self)
        {
          requireLegal(self.thresholds.variance == 0, "varianceThreshold", self.thresholds.variance,
                       "0: Hilbert maps give no variance");
        });
  }();
  return table;
}

OverlappingStructure OverlappingStructure::resolved() const
{
  OverlappingStructure filled = *this;
  filled.gamma = resolvedGamma();
  return filled;
}

void OverlappingStructure::validate() const
{
  requireLegalOptions(*this, resolution);
}

SamplingRules OverlappingInference::rules() const
{
  SamplingRules rules = HilbertSampling::rules(*this);
  rules.keepGlancingSurfaces = false;
  return rules;
}

void OverlappingInference::validate() const
{
  requireLegalOptions(*this, std::nullopt);
}

bool operator==(const OverlappingStructure& a, const OverlappingStructure& b)
{
  return sameOptions(a, b);
}
bool operator==(const OverlappingInference& a, const OverlappingInference& b)
{
  return sameOptions(a, b);
}

OverlappingOptions presetOptions(OverlappingPreset preset)
{
  OverlappingOptions options;
  if (preset == OverlappingPreset::Default) return options;
  options.structure.features = HilbertFeatures::Nystroem;
  options.structure.gamma = 3.0;
  options.structure.components = 100;
  options.structure.pruning = Pruning::None;
  options.structure.outOfFieldLimit = 0.0;
  options.structure.fieldLimit = 0.0;
  OverlappingInference& inference = options.inference;
  inference.fieldAngle = 2.5;
  inference.solver = HilbertSolver::SgdL1;
  inference.trainingPoints = HilbertPoints::Points;
  // Samples at regular distances from the sensor end up to one of them before the hit: half of one on
  // average.
  inference.freeMargin = 0.25;
  inference.freeResolution = 0.5;
  inference.hitWeight = 1.0;
  inference.thresholds.occupied = StateThresholds::kOccupiedInThesis;
  inference.fieldWeight = 1.0;
  return options;
}

}  // namespace lamap
