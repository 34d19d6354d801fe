#include <lamap_core/overlapping/options.h>

#include <lamap_core/options/legal_range.h>

#include <cmath>
#include <tuple>

namespace lamap
{
namespace
{
auto fieldsOf(const OverlappingStructure& s)
{
  return std::tie(static_cast<const BlockOptions&>(s), static_cast<const FeatureOptions&>(s),
                  s.outOfFieldLimit, s.keepModels);
}

auto fieldsOf(const OverlappingInference& i)
{
  return std::tie(static_cast<const HilbertSampling&>(i), static_cast<const RangeOptions&>(i),
                  static_cast<const DescentOptions&>(i), i.solver, i.iterations, i.scansPerModel,
                  i.boxQuantile, i.fieldNear, i.fieldDepth, i.fieldAngle, i.fieldWeight, i.thresholds);
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

void OverlappingStructure::validate() const
{
  BlockOptions::validate();
  FeatureOptions::validate();
  requireFromTo("outOfFieldLimit", outOfFieldLimit, 0, 1e3, "a number from 0 to 1000");
  if (features == HilbertFeatures::Compact) validateLattice(resolution);
}

void OverlappingInference::validate() const
{
  rangeLimits().validate();
  HilbertSampling::validate();
  requireIterations(iterations);
  DescentOptions::validate();
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
  return fieldsOf(a) == fieldsOf(b);
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
