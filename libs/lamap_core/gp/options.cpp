#include <lamap_core/gp/options.h>

#include <lamap_core/options/legal_range.h>

#include <tuple>

namespace lamap
{
namespace
{
auto fieldsOf(const GpStructure& s)
{
  return std::tie(static_cast<const BlockOptions&>(s), s.fusion, s.signalVariance, s.noiseVariance,
                  s.squashGain, s.minVariance);
}

auto fieldsOf(const GpInference& i)
{
  return std::tie(static_cast<const RangeOptions&>(i), i.nested, i.freeSpace, i.trainingPoints,
                  i.freeResolution, i.freeMargin, i.freeDownsampling, i.hitDownsampling, i.protectHits,
                  i.kernelSupport, i.lengthScale, i.maxPoints, i.thresholds);
}
}  // namespace

void GpStructure::validate() const
{
  BlockOptions::validate();
  requireLegal(signalVariance >= 1e-3 && signalVariance <= 1e3, "signalVariance", signalVariance,
               "a number from 0.001 to 1000");
  requireLegal(noiseVariance >= 1e-6 && noiseVariance <= 1e3, "noiseVariance", noiseVariance,
               "a number from 1e-06 to 1000");
  requireLegal(squashGain > 0 && squashGain <= 1e6, "squashGain", squashGain, "a number > 0, at most 1e6");
  requireLegal(resolvedMinVariance() > 0 && resolvedMinVariance() <= 1e3, "minVariance",
               resolvedMinVariance(), "a number > 0, at most 1000");
}

GpInference GpInference::resolved(double resolution_m) const
{
  GpInference filled = *this;
  filled.freeResolution = freeResolution.value_or(2.0 * resolution_m);
  filled.freeMargin = freeMargin.value_or(resolution_m);
  filled.hitDownsampling = hitDownsampling.value_or(resolution_m);
  filled.kernelSupport = kernelSupport.value_or(2.0 * resolution_m);
  return filled;
}

TrainingRules GpInference::trainingRules() const
{
  TrainingRules rules;
  rules.freeSpace = freeSpace == GpFreeSpace::Samples ? FreeSpace::Samples : FreeSpace::None;
  rules.points = trainingPoints;
  rules.freeResolution = *freeResolution;
  rules.freeMargin = *freeMargin;
  rules.freeDownsampling = freeDownsampling;
  rules.hitDownsampling = *hitDownsampling;
  rules.protectHits = protectHits;
  return rules;
}

RangeLimits GpInference::rangeLimits() const
{
  RangeLimits limits = RangeOptions::rangeLimits();
  limits.noReturnIsFree = limits.noReturnIsFree && freeSpace != GpFreeSpace::None;
  return limits;
}

void GpInference::validate(double resolution_m) const
{
  const GpInference filled = resolved(resolution_m);
  filled.trainingRules().validate(resolution_m);
  // A support of hundreds of cells is a mistake in the unit: each GP would speak of millions of cells.
  constexpr double kMaxSupport_cells = 64.0;
  requireLegal(*filled.kernelSupport > 0 && *filled.kernelSupport <= kMaxSupport_cells * resolution_m,
               "kernelSupport", *filled.kernelSupport, "a length [m] > 0, at most 64 times the resolution");
  requireLegal(lengthScale >= 1e-2 * resolution_m && lengthScale <= 1e6, "lengthScale", lengthScale,
               "a length [m] of at least 1/100 of the resolution");
  requireLegal(maxPoints >= 1 && maxPoints <= 4096, "maxPoints", maxPoints, "a whole number from 1 to 4096");
  rangeLimits().validate();
  thresholds.validate();
}

bool operator==(const GpStructure& a, const GpStructure& b)
{
  return fieldsOf(a) == fieldsOf(b);
}
bool operator==(const GpInference& a, const GpInference& b)
{
  return fieldsOf(a) == fieldsOf(b);
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
  GpInference& inference = options.inference;
  inference.nested = true;
  inference.trainingPoints = TrainingPoints::Centroids;
  inference.freeResolution = preset == GpPreset::Thesis ? 0.5 : 0.3;
  inference.freeDownsampling = 0.1;
  inference.hitDownsampling = 0.1;
  inference.freeMargin = 0.0;
  inference.protectHits = 0;
  inference.kernelSupport = 0.4;  // a block of 4 cells of 0.1 m and its neighbours
  inference.lengthScale = 1.0;
  inference.considerInvalidRangesAsFreeSpace = false;
  inference.thresholds.variance = 0.02;
  return options;
}

}  // namespace lamap
