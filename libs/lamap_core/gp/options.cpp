#include <lamap_core/gp/options.h>

#include <lamap_core/options/shared_options.h>

namespace lamap
{
const OptionTable& GpStructure::optionTable()
{
  using Self = GpStructure;
  static const OptionTable table = []
  {
    OptionTableOf<Self> all("creationOpts");
    addResolutionOption(all);
    addBlockOptions(all);
    addPlanarOptions(all)
        .add("fusion", &Self::fusion, oneOf({"bcm", "bayes"}),
             "the evidence that adds up: precisions and weighted means (BCM), or log-odds (no variance)")
        .add("signalVariance", &Self::signalVariance, plain().from(1e-3).to(1e3),
             "variance of f where there is no data")
        .add("noiseVariance", &Self::noiseVariance, plain().from(1e-6).to(1e3), "variance of labels around f")
        .add("squashGain", &Self::squashGain, plain().above(0).to(1e6),
             "gain of the function that maps means and variances to probabilities")
        .add("minVariance", &Self::minVariance, plain().above(0).to(1e3).usually("noiseVariance"),
             "minimum variance in that function")
        .add("maxEvidence", &Self::maxEvidence, plain().from(0).to(1e12).usually("7.5 / noiseVariance"),
             "a cell reads as if scans had given it this precision at most, with the same mean of theirs; 0: "
             "no limit")
        .onlyWhere({"maxEvidence"}, {{"fusion", {"bcm"}}});
    return all;
  }();
  return table;
}

const OptionTable& GpInference::optionTable()
{
  using Self = GpInference;
  static const OptionTable table = []
  {
    OptionTableOf<Self> all("insertOpts");
    all.add("nested", &Self::nested, plain(),
            "one GP per block with data, those around a cell fused (nested BCM); otherwise one per block, on "
            "all surrounding data")
        .add("freeSpace", &Self::freeSpace, oneOf({"samples", "none"}),
             "free evidence of a ray: points along it, or none");
    addFreeSampleOptions(all, 2, 1);
    addTrainingPointOptions(all)
        .add("protectHits", &Self::protectHits, plain().from(0).to(kWholeMost),
             "no free points in a cell with this many hits in a scan; 0: none is protected, nor are surfaces "
             "at a glancing angle")
        // A support of hundreds of cells is a mistake in the unit: each GP would speak of millions of cells.
        .add("kernelSupport", &Self::kernelSupport,
             metres().above(0).to(kMetresMost).atLeastCells(0.001).atMostCells(64).usuallyCells(2),
             "a GP predicts nothing this far from all its data, and uses no data farther from its block")
        .add("lengthScale", &Self::lengthScale, metres().above(0).to(kMetresMost).atLeastCells(0.01),
             "correlation length of the surface")
        .add("maxPoints", &Self::maxPoints, plain().from(1).to(4096),
             "most training points of one GP; more are split, and the parts fused")
        .onlyWhere({"freeResolution", "freeMargin", "freeDownsampling", "protectHits"},
                   {{"freeSpace", {"samples"}}});
    all.include<RangeOptions>();
    addWidthOptions(all);
    addThresholdOptions(all);
    return addVarianceThresholdOption(all, 1e3).onlyWhere({"varianceThreshold"}, {{"fusion", {"bcm"}}});
  }();
  return table;
}

void GpStructure::validate() const
{
  requireLegalOptions(*this, resolution);
}

GpStructure GpStructure::resolved() const
{
  GpStructure filled = *this;
  filled.minVariance = resolvedMinVariance();
  filled.maxEvidence = resolvedMaxEvidence();
  return filled;
}

GpInference GpInference::resolved(double resolution_m) const
{
  return withLengths(*this, resolution_m);
}

void GpInference::validate(double resolution_m) const
{
  requireLegalOptions(*this, resolution_m);
}

bool operator==(const GpStructure& a, const GpStructure& b)
{
  return sameOptions(a, b);
}
bool operator==(const GpInference& a, const GpInference& b)
{
  return sameOptions(a, b);
}

GpOptions presetOptions(GpPreset preset)
{
  GpOptions options;
  if (preset == GpPreset::Default) return options;

  // LA3DM's configuration of its GPOctoMap; thesis section 4.3 has free samples every 0.5 m, and prunes.
  options.structure.blockDepth = 3;
  options.structure.pruning = preset == GpPreset::Thesis ? Pruning::State : Pruning::None;
  options.structure.signalVariance = 1.0;
  options.structure.noiseVariance = 0.01;
  options.structure.squashGain = 100.0;
  options.structure.minVariance = 0.001;
  options.structure.maxEvidence = 0;
  GpInference& inference = options.inference;
  inference.nested = true;
  inference.setAsInThesis();
  inference.freeResolution = preset == GpPreset::Thesis ? 0.5 : 0.3;
  inference.freeDownsampling = 0.1;
  inference.kernelSupport = 0.4;  // a block of 4 cells of 0.1 m and its neighbours
  inference.lengthScale = 1.0;
  inference.thresholds.occupied = StateThresholds::kOccupiedInThesis;
  inference.thresholds.variance = 0.02;
  return options;
}

}  // namespace lamap
