#include <lamap_core/features/packed_sites.h>

#include <algorithm>

namespace lamap
{
void PackedSites::number()
{
  blocks.shrink_to_fit();
  bits.shrink_to_fit();
  weights.shrink_to_fit();
  firstWeights.clear();
  firstWeights.reserve(bits.size());
  size_t first = 0;
  for (const SiteSet::Bits& words : bits)
  {
    firstWeights.push_back(static_cast<uint32_t>(first));
    for (const uint64_t word : words) first += SiteBits::countOf(word);
  }
}

std::optional<PackedSites::Block> PackedSites::find(const BlockIndex& index) const
{
  const auto found = std::lower_bound(blocks.begin(), blocks.end(), index);
  if (found == blocks.end() || !(*found == index)) return std::nullopt;
  const auto number = static_cast<size_t>(found - blocks.begin());
  Block block{{bits[number], {}}, weights.data() + firstWeights[number]};
  block.countBefore();
  return block;
}

size_t PackedSites::memoryBytes() const
{
  return blocks.capacity() * sizeof(BlockIndex) + bits.capacity() * sizeof(SiteSet::Bits) +
         weights.capacity() * sizeof(float) + firstWeights.capacity() * sizeof(uint32_t);
}

}  // namespace lamap
