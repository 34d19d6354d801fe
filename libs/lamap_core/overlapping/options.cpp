#include <lamap_core/overlapping/options.h>

#include <lamap_core/features/compact_kernel.h>
#include <lamap_core/options/legal_range.h>

#include <cmath>
#include <tuple>

namespace lamap
{
namespace
{
auto fieldsOf(const OverlappingStructure& s)
{
  return std::tie(s.resolution, s.blockDepth, s.pruning, s.planar, s.planarHeight, s.features, s.gamma,
                  s.latticeSpacing, s.cutoff, s.components, s.seed, s.priorPrecision, s.outOfFieldLimit,
                  s.keepModels);
}

auto fieldsOf(const OverlappingInference& i)
{
  return std::tie(i.minRange, i.maxRange, i.considerInvalidRangesAsFreeSpace, i.rayDecimation, i.solver,
                  i.iterations, i.alpha, i.epochs, i.scansPerModel, i.boxQuantile, i.fieldNear, i.fieldDepth,
                  i.fieldAngle, i.fieldWeight, i.thresholds.free, i.thresholds.occupied,
                  i.thresholds.variance);
}

void requireNotNegative(const char* name, double value)
{
  requireLegal(value >= 0 && std::isfinite(value), name, value, "a finite number >= 0");
}

void requireFromTo(const char* name, double value, double low, double high, const std::string& legal)
{
  requireLegal(value >= low && value <= high, name, value, legal);
}

}  // namespace

double OverlappingStructure::resolvedGamma() const
{
  constexpr double kThesisGamma = 3.0;
  const bool compact = features == HilbertFeatures::Compact;
  return gamma.value_or(compact ? CompactKernel::kDefaultGamma : kThesisGamma);
}

void OverlappingStructure::validate() const
{
  requireFromTo("resolution", resolution, 1e-4, 1e4, "a length from 0.0001 to 10000 m");
  requireFromTo("blockDepth", blockDepth, 2, 6, "a whole number from 2 to 6");
  requireLegal(std::abs(planarHeight) <= 1e9 * resolution, "planarHeight", planarHeight,
               "a finite height [m] within 1e9 cells");
  requireFromTo("gamma", resolvedGamma(), 1e-6, 1e9, "a number [1/m^2] from 1e-6 to 1e9");
  requireFromTo("components", components, 1, 5000, "a whole number from 1 to 5000");
  requireFromTo("priorPrecision", priorPrecision, 1e-9, 1e9, "a number from 1e-9 to 1e9");
  requireFromTo("outOfFieldLimit", outOfFieldLimit, 0, 1e3, "a number from 0 to 1000");
  if (features != HilbertFeatures::Compact) return;
  requireFromTo("cutoff", cutoff, 1e-6, 0.99, "a number from 1e-6 to 0.99");
  const CompactKernel kernel(resolvedGamma(), cutoff);
  (void)AxisReaches(kernel, latticeSpacing);  // refuses a lattice too fine for the kernel
  requireLegal(latticeSpacing <= 1e4, "latticeSpacing", latticeSpacing, "a length [m], at most 10000");
  requireSupport(kernel, resolution);
}

void OverlappingInference::validate() const
{
  rangeLimits().validate();
  HilbertSampling::validate();
  requireFromTo("iterations", iterations, 1, 10000, "a whole number from 1 to 10000");
  requireFromTo("alpha", alpha, 1e-12, 1e6, "a number from 1e-12 to 1e6");
  requireFromTo("epochs", epochs, 1, 10000, "a whole number from 1 to 10000");
  requireFromTo("scansPerModel", scansPerModel, 1, 10000, "a whole number from 1 to 10000");
  requireLegal(boxQuantile >= 0 && boxQuantile < 0.5, "boxQuantile", boxQuantile, "in [0, 0.5)");
  requireNotNegative("fieldNear", fieldNear);
  requireNotNegative("fieldDepth", fieldDepth);
  requireFromTo("fieldAngle", fieldAngle, 0.1, 90, "degrees from 0.1 to 90");
  requireFromTo("fieldWeight", fieldWeight, 1e-3, 1e3, "a number from 0.001 to 1000");
  thresholds.validate();
  requireLegal(thresholds.variance == 0, "varianceThreshold", thresholds.variance,
               "0: Hilbert maps give no variance");
}

bool operator==(const OverlappingStructure& a, const OverlappingStructure& b)
{
  return fieldsOf(a) == fieldsOf(b);
}
bool operator==(const OverlappingInference& a, const OverlappingInference& b)
{
  return static_cast<const HilbertSampling&>(a) == static_cast<const HilbertSampling&>(b) &&
         fieldsOf(a) == fieldsOf(b);
}

RangeLimits OverlappingInference::rangeLimits() const
{
  return {minRange, maxRange, considerInvalidRangesAsFreeSpace, rayDecimation};
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
  OverlappingInference& inference = options.inference;
  inference.solver = HilbertSolver::SgdL1;
  inference.trainingPoints = HilbertPoints::Points;
  // Samples at regular distances from the sensor end up to one of them before the hit: half of one on
  // average.
  inference.freeMargin = 0.25;
  inference.freeResolution = 0.5;
  inference.hitWeight = 1.0;
  inference.fieldWeight = 1.0;
  return options;
}

}  // namespace lamap
