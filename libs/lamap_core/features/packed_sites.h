#pragma once

#include <lamap_core/features/site_set.h>

#include <cstdint>
#include <optional>
#include <vector>

namespace lamap
{
/** Sites of a lattice and their weights in few bytes, to be read only: blocks of 8³ sites sorted by z, y, x,
 * and a weight for each bit in order. Plain state. */
struct PackedSites
{
  std::vector<BlockIndex> blocks;
  std::vector<SiteSet::Bits> bits;
  std::vector<float> weights;
  std::vector<uint32_t> firstWeights;  ///< number of each block's first weight, see number()

  /// To be called when blocks, bits and weights are complete: finds firstWeights, gives spare memory back.
  void number();

  /// As HilbertLattice's.
  struct Block : public SiteBits
  {
    const float* weights;
    [[nodiscard]] float meanAt(size_t place) const { return weights[place]; }
  };
  [[nodiscard]] std::optional<Block> find(const BlockIndex& index) const;

  [[nodiscard]] size_t memoryBytes() const;

  /// Calls visit(site, weight) for each, in order.
  template <typename Visit>
  void forEach(Visit&& visit) const;

  friend bool operator==(const PackedSites& a, const PackedSites& b)
  {
    return a.blocks == b.blocks && a.bits == b.bits && a.weights == b.weights;
  }
};

template <typename Visit>
void PackedSites::forEach(Visit&& visit) const
{
  size_t number = 0;
  for (size_t block = 0; block < blocks.size(); ++block)
    SiteBits::forEach(bits[block], blocks[block],
                      [&](const CellIndex& site) { visit(site, weights[number++]); });
}

}  // namespace lamap
