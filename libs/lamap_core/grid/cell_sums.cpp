#include <lamap_core/grid/cell_sums.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace lamap
{
namespace
{
uint64_t addCounts(uint64_t to, uint64_t added)
{
  const uint64_t sum = to + added;
  if (sum >> 63) throw std::overflow_error("the evidence of a cell would pass 2^63 units");
  return sum;
}

uint64_t addCodes(uint64_t to, uint64_t added)
{
  if (added == 0) return to;
  if (to == 0) return added;
  const int64_t sum = *SignedSums::decoded(to) + *SignedSums::decoded(added);
  if (sum > kMostSignedSum || sum < -kMostSignedSum)
    throw std::overflow_error("a sum of the evidence of a cell would pass 2^41");
  return SignedSums::encoded(sum);
}

/// Counts may have 63 bits: their sum is kept in two parts of 32 bits each.
struct LongSum
{
  uint64_t high = 0;
  uint64_t low = 0;

  void add(uint64_t count)
  {
    high += count >> 32;
    low += count & 0xFFFFFFFFu;
  }
  [[nodiscard]] uint64_t roundedMean(uint32_t count) const
  {
    const uint64_t rest = ((high % count) << 32) + low;
    return (high / count << 32) + (rest + count / 2) / count;
  }
};

CellSums meanCounts(const CellSums* cells, uint32_t count)
{
  LongSum first;
  LongSum second;
  for (uint32_t i = 0; i < count; ++i)
  {
    first.add(cells[i].first);
    second.add(cells[i].second);
  }
  CellSums mean{first.roundedMean(count), second.roundedMean(count)};
  if (!mean.any()) (first.low > second.low ? mean.first : mean.second) = 1;
  return mean;
}

uint64_t meanCode(const CellSums* cells, uint32_t count, uint64_t CellSums::*code)
{
  const auto n = static_cast<int64_t>(count);
  int64_t quotients = 0;
  int64_t rests = 0;
  bool any = false;
  for (uint32_t i = 0; i < count; ++i)
  {
    const std::optional<int64_t> sum = SignedSums::decoded(cells[i].*code);
    if (!sum) continue;
    any = true;
    quotients += *sum / n;
    rests += *sum % n;
  }
  if (!any) return 0;
  const int64_t doubled = 2 * rests + n;
  return SignedSums::encoded(quotients + doubled / (2 * n) - (doubled % (2 * n) < 0 ? 1 : 0));
}

}  // namespace

int64_t inEvidenceUnits(double number)
{
  constexpr double kUnitsPerOne = 1 << kEvidenceFractionBits;
  constexpr auto kMost = static_cast<double>(kMostSignedSum);
  return static_cast<int64_t>(std::clamp(std::floor(number * kUnitsPerOne + 0.5), -kMost, kMost));
}

CellSums addSums(SumKind kind, const CellSums& to, const CellSums& added)
{
  if (kind == SumKind::Counts) return {addCounts(to.first, added.first), addCounts(to.second, added.second)};
  return {addCodes(to.first, added.first), addCodes(to.second, added.second)};
}

CellSums meanSums(SumKind kind, const CellSums* cells, uint32_t count)
{
  if (kind == SumKind::Counts) return meanCounts(cells, count);
  return {meanCode(cells, count, &CellSums::first), meanCode(cells, count, &CellSums::second)};
}

}  // namespace lamap
