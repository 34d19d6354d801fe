#include <lamap_core/logodds_evidence.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace lamap
{
namespace
{
uint64_t addCodes(uint64_t to, uint64_t added)
{
  if (added == 0) return to;
  if (to == 0) return added;
  const int64_t sum = *LogoddsSums::decoded(to) + *LogoddsSums::decoded(added);
  if (sum > LogoddsSums::kLimit || sum < -LogoddsSums::kLimit)
    throw std::overflow_error("the log-odds of a cell would pass 2^41");
  return LogoddsSums::encoded(sum);
}

/// Mean of a sum over cells, those without it counting as 0, rounded half up; nothing where all are without.
template <typename SumOf>
std::optional<int64_t> roundedMean(uint32_t count, SumOf&& sumOf)
{
  const auto n = static_cast<int64_t>(count);
  int64_t quotients = 0;
  int64_t rests = 0;
  bool any = false;
  for (uint32_t i = 0; i < count; ++i)
  {
    const std::optional<int64_t> sum = sumOf(i);
    if (!sum) continue;
    any = true;
    quotients += *sum / n;
    rests += *sum % n;
  }
  if (!any) return std::nullopt;
  const int64_t doubled = 2 * rests + n;
  const int64_t floored = doubled / (2 * n) - (doubled % (2 * n) < 0 ? 1 : 0);
  return quotients + floored;
}

}  // namespace

int64_t logoddsUnits(float logodds, double weight)
{
  constexpr double kMaxLogodds = 1000.0;
  constexpr double kUnitsPerOne = 1 << kEvidenceFractionBits;
  const double bounded = std::clamp(static_cast<double>(logodds), -kMaxLogodds, kMaxLogodds);
  return static_cast<int64_t>(std::floor(bounded * weight * kUnitsPerOne + 0.5));
}

Evidence addLogodds(const Evidence& to, const Evidence& added)
{
  return {addCodes(to.occupied, added.occupied), addCodes(to.free, added.free)};
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
  LogoddsSums means;
  means.inField =
      roundedMean(count, [&](uint32_t i) { return LogoddsSums::decoded(block.occupied[first + i]); });
  means.outOfField =
      roundedMean(count, [&](uint32_t i) { return LogoddsSums::decoded(block.free[first + i]); });
  mean = means.evidence();
  return true;
}

LogoddsAdder::LogoddsAdder(const BlockShape& shape)
    : shape_(shape), dense_(shape), added_(shape.cellCount()), touched_(shape.maskWords())
{
}

void LogoddsAdder::clear()
{
  std::fill(touched_.begin(), touched_.end(), uint64_t{0});
}

bool LogoddsAdder::any() const
{
  return std::any_of(touched_.begin(), touched_.end(), [](uint64_t word) { return word != 0; });
}

void LogoddsAdder::addTo(EvidenceBlock& block, const OctantRule& rule)
{
  block.unpack(shape_, dense_);
  for (size_t word = 0; word < touched_.size(); ++word)
  {
    for (uint64_t rest = touched_[word]; rest != 0; rest &= rest - 1)
    {
      const auto offset = static_cast<uint32_t>(word * 64 + static_cast<size_t>(__builtin_ctzll(rest)));
      const Evidence held = dense_.isObserved(offset) ? dense_.at(offset) : Evidence{};
      const Evidence sum = addLogodds(held, added_[offset]);
      dense_.occupied[offset] = sum.occupied;
      dense_.free[offset] = sum.free;
      dense_.setObserved(offset);
    }
  }
  block.pack(shape_, dense_, rule.merger);
}

}  // namespace lamap
