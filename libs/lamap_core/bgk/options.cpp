#include <lamap_core/bgk/options.h>

#include <lamap_core/options/legal_range.h>

#include <tuple>

namespace lamap
{
namespace
{
auto fieldsOf(const BgkStructure& s)
{
  return std::tie(static_cast<const BlockOptions&>(s), s.priorAlpha, s.priorBeta);
}

auto fieldsOf(const BgkInference& i)
{
  return std::tie(static_cast<const RangeOptions&>(i), i.freeSpace, i.trainingPoints, i.freeResolution,
                  i.freeMargin, i.freeWeight, i.freeDownsampling, i.hitDownsampling, i.protectHits, i.kernel,
                  i.kernelSupport, i.kernelScale, i.thresholds);
}

}  // namespace

void BgkStructure::validate() const
{
  BlockOptions::validate();
  requireLegal(priorAlpha > 0 && priorAlpha <= 1e6, "priorAlpha", priorAlpha, "a number > 0, at most 1e6");
  requireLegal(priorBeta > 0 && priorBeta <= 1e6, "priorBeta", priorBeta, "a number > 0, at most 1e6");
}

BgkInference BgkInference::resolved(double resolution_m) const
{
  constexpr double kDefaultSupport_cells = 2.0;
  BgkInference filled = *this;
  filled.freeResolution = freeResolution.value_or(resolution_m);
  filled.freeMargin = freeMargin.value_or(resolution_m);
  filled.hitDownsampling = hitDownsampling.value_or(resolution_m);
  filled.kernelSupport = kernelSupport.value_or(kDefaultSupport_cells * resolution_m);
  return filled;
}

TrainingRules BgkInference::trainingRules() const
{
  TrainingRules rules;
  rules.freeSpace = freeWeight > 0 ? freeSpace : FreeSpace::None;
  rules.points = trainingPoints;
  rules.freeResolution = *freeResolution;
  rules.freeMargin = *freeMargin;
  rules.freeDownsampling = freeDownsampling;
  rules.hitDownsampling = *hitDownsampling;
  rules.protectHits = protectHits;
  return rules;
}

void BgkInference::validate(double resolution_m) const
{
  const BgkInference filled = resolved(resolution_m);
  filled.trainingRules().validate(resolution_m);
  // A kernel of hundreds of cells is a mistake in the unit, and would not end.
  constexpr double kMaxSupport_cells = 64.0;
  requireLegal(freeWeight >= 0 && freeWeight <= 1e3, "freeWeight", freeWeight, "a number from 0 to 1000");
  requireLegal(*filled.kernelSupport > 0 && *filled.kernelSupport <= kMaxSupport_cells * resolution_m,
               "kernelSupport", *filled.kernelSupport, "a length [m] > 0, at most 64 times the resolution");
  requireLegal(kernelScale > 0 && kernelScale <= 1e3, "kernelScale", kernelScale,
               "a number > 0, at most 1000");
  rangeLimits().validate();
  thresholds.validate();
}

bool operator==(const BgkStructure& a, const BgkStructure& b)
{
  return fieldsOf(a) == fieldsOf(b);
}
bool operator==(const BgkInference& a, const BgkInference& b)
{
  return fieldsOf(a) == fieldsOf(b);
}

BgkOptions presetOptions(BgkPreset preset)
{
  BgkOptions options;
  if (preset == BgkPreset::Default) return options;

  // What the thesis (section 4.3) and LA3DM have in common.
  options.structure.blockDepth = 3;
  options.structure.pruning = preset == BgkPreset::Thesis ? Pruning::State : Pruning::None;
  options.structure.priorAlpha = 0.001;
  options.structure.priorBeta = 0.001;
  BgkInference& inference = options.inference;
  inference.trainingPoints = TrainingPoints::Centroids;
  inference.freeSpace = FreeSpace::Samples;
  inference.freeResolution = 0.5;
  inference.hitDownsampling = 0.1;
  inference.freeMargin = 0.0;
  inference.freeWeight = 1.0;
  inference.protectHits = 0;
  inference.considerInvalidRangesAsFreeSpace = false;
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
