#include <lamap_core/grid/signed_evidence.h>

#include <algorithm>
#include <stdexcept>

namespace lamap
{
namespace
{
uint64_t addCodes(uint64_t to, uint64_t added)
{
  if (added == 0) return to;
  if (to == 0) return added;
  const int64_t sum = *decodedSum(to) + *decodedSum(added);
  if (sum > kMostSignedSum || sum < -kMostSignedSum)
    throw std::overflow_error("a sum of the evidence of a cell would pass 2^41");
  return encodedSum(sum);
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

Evidence addSigned(const Evidence& to, const Evidence& added)
{
  return {addCodes(to.occupied, added.occupied), addCodes(to.free, added.free)};
}

Evidence meanSigned(const DenseBlock& block, uint32_t first, uint32_t count)
{
  const auto mean = [&](const std::vector<uint64_t>& codes)
  { return encodedSum(roundedMean(count, [&](uint32_t i) { return decodedSum(codes[first + i]); })); };
  return {mean(block.occupied), mean(block.free)};
}

SignedAdder::SignedAdder(const BlockShape& shape)
    : shape_(shape), dense_(shape), added_(shape.cellCount()), touched_(shape.maskWords())
{
}

void SignedAdder::clear()
{
  std::fill(touched_.begin(), touched_.end(), uint64_t{0});
}

bool SignedAdder::any() const
{
  return std::any_of(touched_.begin(), touched_.end(), [](uint64_t word) { return word != 0; });
}

void SignedAdder::addTo(EvidenceBlock& block, const OctantRule& rule)
{
  block.unpack(shape_, dense_);
  for (size_t word = 0; word < touched_.size(); ++word)
  {
    for (uint64_t rest = touched_[word]; rest != 0; rest &= rest - 1)
    {
      const auto offset = static_cast<uint32_t>(word * 64 + static_cast<size_t>(__builtin_ctzll(rest)));
      const Evidence held = dense_.isObserved(offset) ? dense_.at(offset) : Evidence{};
      const Evidence sum = addSigned(held, added_[offset]);
      dense_.occupied[offset] = sum.occupied;
      dense_.free[offset] = sum.free;
      dense_.setObserved(offset);
    }
  }
  block.pack(shape_, dense_, rule.merger);
}

}  // namespace lamap
