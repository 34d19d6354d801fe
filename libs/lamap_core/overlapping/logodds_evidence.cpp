#include <lamap_core/overlapping/logodds_evidence.h>

#include <algorithm>
#include <cmath>

namespace lamap
{
int64_t logoddsUnits(float logodds, double weight)
{
  constexpr double kMaxLogodds = 1000.0;
  constexpr double kUnitsPerOne = 1 << kEvidenceFractionBits;
  const double bounded = std::clamp(static_cast<double>(logodds), -kMaxLogodds, kMaxLogodds);
  return static_cast<int64_t>(std::floor(bounded * weight * kUnitsPerOne + 0.5));
}

double logoddsOf(const Evidence& evidence, double outOfFieldLimit)
{
  const LogoddsSums sums = LogoddsSums::of(evidence);
  if (sums.inField) return static_cast<double>(*sums.inField) * kEvidenceUnit;
  const double outside = static_cast<double>(sums.outOfField.value_or(0)) * kEvidenceUnit;
  return std::clamp(outside, -outOfFieldLimit, outOfFieldLimit);
}

bool meanLogodds(const DenseBlock& block, uint32_t first, uint32_t count, Evidence& mean)
{
  const bool inField = block.occupied[first] != 0;
  for (uint32_t i = first; i < first + count; ++i)
    if ((block.occupied[i] != 0) != inField) return false;
  mean = meanSigned(block, first, count);
  return true;
}

}  // namespace lamap
