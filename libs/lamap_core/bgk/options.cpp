#include <lamap_core/bgk/options.h>

#include <lamap_core/options/shared_options.h>

namespace lamap
{
const OptionTable& BgkStructure::optionTable()
{
  using Self = BgkStructure;
  static const OptionTable table = []
  {
    OptionTableOf<Self> all("creationOpts");
    addResolutionOption(all);
    addBlockOptions(all);
    addPlanarOptions(all)
        .add("priorAlpha", &Self::priorAlpha, plain().above(0).to(1e6),
             "prior pseudo-count for occupied in every cell")
        .add("priorBeta", &Self::priorBeta, plain().above(0).to(1e6),
             "prior pseudo-count for free in every cell")
        .add("maxEvidence", &Self::maxEvidence, plain().from(0).to(1e12),
             "a cell reads as if it had this many pseudo-counts at most, in the proportions of what it has; "
             "0: no "
             "limit");
    return all;
  }();
  return table;
}

const OptionTable& BgkInference::optionTable()
{
  using Self = BgkInference;
  static const OptionTable table = []
  {
    OptionTableOf<Self> all("insertOpts");
    all.add("freeSpace", &Self::freeSpace, oneOf({"samples", "line", "none"}),
            "free evidence of a ray: points along it, its nearest point to each cell, or none");
    addFreeSampleOptions(all, 1, 0.5)
        .add("freeWeight", &Self::freeWeight, plain().from(0).to(1e3), "weight of free evidence");
    addTrainingPointOptions(all)
        .add("protectHits", &Self::protectHits, plain().from(0).to(kWholeMost),
             "a cell with this many hits in a scan takes no free evidence from it; 0: none is protected, nor "
             "are surfaces at a glancing angle")
        .add("kernel", &Self::kernel, oneOf({"sparse", "sparseMatern32", "wendlandC2"}),
             "how evidence decreases with distance")
        // A kernel of hundreds of cells is a mistake in the unit, and would not end.
        .add("kernelSupport", &Self::kernelSupport,
             metres().above(0).to(kMetresMost).atLeastCells(0.001).atMostCells(64).usuallyCells(2),
             "a point has no effect at and beyond this distance; 3 to 4 cells suit sparse scans")
        .add("kernelScale", &Self::kernelScale, plain().above(0).to(1e3), "evidence at distance zero")
        .onlyWhere({"freeResolution", "freeDownsampling"}, {{"freeSpace", {"samples"}}})
        .onlyWhere({"freeMargin", "freeWeight", "protectHits"}, {{"freeSpace", {"samples", "line"}}});
    all.include<RangeOptions>();
    addWidthOptions(all);
    addThresholdOptions(all);
    return addVarianceThresholdOption(all, 1);
  }();
  return table;
}

void BgkStructure::validate() const
{
  requireLegalOptions(*this, resolution);
}

BgkInference BgkInference::resolved(double resolution_m) const
{
  return withLengths(*this, resolution_m);
}

void BgkInference::validate(double resolution_m) const
{
  requireLegalOptions(*this, resolution_m);
}

bool operator==(const BgkStructure& a, const BgkStructure& b)
{
  return sameOptions(a, b);
}
bool operator==(const BgkInference& a, const BgkInference& b)
{
  return sameOptions(a, b);
}

SamplingRules BgkInference::samplingRules() const
{
  SamplingRules rules = rulesWith(freeSpace, *kernelSupport);
  rules.freeWeight = freeWeight;
  return rules;
}

BgkOptions presetOptions(BgkPreset preset)
{
  BgkOptions options;
  if (preset == BgkPreset::Default) return options;

  options.structure.blockDepth = 3;
  options.structure.pruning = preset == BgkPreset::Thesis ? Pruning::State : Pruning::None;
  options.structure.priorAlpha = 0.001;
  options.structure.priorBeta = 0.001;
  BgkInference& inference = options.inference;
  inference.setAsInThesis();
  inference.beamWidth = BeamWidth::None;
  inference.freeResolution = 0.5;
  inference.freeWeight = 1.0;
  inference.thresholds.occupied = StateThresholds::kOccupiedInThesis;
  if (preset == BgkPreset::Thesis)
  {
    inference.kernelSupport = 0.3;
    inference.kernelScale = 10.0;
  }
  else
  {
    inference.kernelSupport = 0.2;
    inference.kernelScale = 1.0;
    inference.freeDownsampling = 0.1;
  }
  return options;
}

}  // namespace lamap
