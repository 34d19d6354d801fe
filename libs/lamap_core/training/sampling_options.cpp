#include <lamap_core/training/sampling_options.h>

namespace lamap
{
void SamplingOptions::setAsInThesis()
{
  trainingPoints = TrainingPoints::Centroids;
  hitDownsampling = 0.1;
  freeMargin = 0.0;
  protectHits = 0;
  considerInvalidRangesAsFreeSpace = false;
  usePoseCovariance = false;
}

SamplingRules SamplingOptions::rulesWith(FreeSpace freeSpace, double widthUnit) const
{
  SamplingRules rules{*this};
  rules.freeSpace = freeSpace;
  rules.points = trainingPoints;
  rules.freeResolution = *freeResolution;
  rules.freeMargin = *freeMargin;
  rules.freeDownsampling = freeDownsampling;
  rules.hitDownsampling = *hitDownsampling;
  rules.protectHits = protectHits;
  rules.keepGlancingSurfaces = protectHits > 0;
  rules.usePoseCovariance = usePoseCovariance;
  rules.widthUnit = widthUnit;
  return rules;
}

RangeOptions SamplingOptions::limitsWith(FreeSpace freeSpace) const
{
  RangeOptions limits = *this;
  if (freeSpace == FreeSpace::None) limits.considerInvalidRangesAsFreeSpace = false;
  return limits;
}

}  // namespace lamap
