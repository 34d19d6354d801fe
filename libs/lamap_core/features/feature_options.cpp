#include <lamap_core/features/feature_options.h>

#include <lamap_core/options/legal_range.h>

#include <tuple>

namespace lamap
{
double FeatureOptions::resolvedGamma() const
{
  constexpr double kNystroemGamma = 3.0;  // of the thesis
  return gamma.value_or(features == HilbertFeatures::Compact ? CompactKernel::kDefaultGamma : kNystroemGamma);
}

void FeatureOptions::validate() const
{
  const double g = resolvedGamma();
  requireLegal(g >= 1e-6 && g <= 1e6, "gamma", g, "a number [1/m^2] from 1e-6 to 1e6");
  requireLegal(cutoff >= 1e-6 && cutoff <= 0.999, "cutoff", cutoff, "a number from 1e-6 to 0.999");
  requireLegal(latticeSpacing >= 1e-4 && latticeSpacing <= 1e4, "latticeSpacing", latticeSpacing,
               "a length from 0.0001 to 10000 m");
  requireLegal(components >= 1 && components <= 5000, "components", components,
               "a whole number from 1 to 5000");
  requireLegal(priorPrecision >= 1e-6 && priorPrecision <= 1e6, "priorPrecision", priorPrecision,
               "a number from 1e-6 to 1e6");
}

void FeatureOptions::validateLattice(double resolution_m) const
{
  AxisReaches::requireReach(kernel(), latticeSpacing);
  requireSupport(kernel(), resolution_m);
}

bool operator==(const FeatureOptions& a, const FeatureOptions& b)
{
  const auto fields = [](const FeatureOptions& o) {
    return std::tie(o.features, o.gamma, o.cutoff, o.latticeSpacing, o.components, o.seed, o.priorPrecision);
  };
  return fields(a) == fields(b);
}

}  // namespace lamap
