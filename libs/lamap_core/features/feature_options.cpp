#include <lamap_core/features/feature_options.h>

namespace lamap
{
double FeatureOptions::resolvedGamma() const
{
  constexpr double kNystroemGamma = 3.0;  // of the thesis
  return gamma.value_or(features == HilbertFeatures::Compact ? CompactKernel::kDefaultGamma : kNystroemGamma);
}

void FeatureOptions::validateLattice(double resolution_m) const
{
  AxisReaches::requireReach(kernel(), latticeSpacing);
  requireSupport(kernel(), resolution_m);
}

}  // namespace lamap
