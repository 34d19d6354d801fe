#pragma once

#include <lamap_core/grid/cell.h>
#include <lamap_core/grid/scan_blocks.h>

#include <array>
#include <cstdint>
#include <vector>

namespace lamap
{
/** A set of sites of a lattice: a bit each, in blocks of 8³ sites. */
class SiteSet
{
 public:
  /// 64-bit word z, bit y·8 + x.
  using Bits = std::array<uint64_t, kScanBlockEdge>;

  /// Forgets all sites; from now on only sites in [low, high] may be inserted.
  void reset(const CellIndex& low, const CellIndex& high);

  /// @throws std::length_error as ScanBlocks::findOrAdd().
  void insert(const CellIndex& site);
  /// Inserts the sites of a whole block that have their bit set.
  void insert(const BlockIndex& block, const Bits& bits);
  [[nodiscard]] bool contains(const CellIndex& site) const;
  [[nodiscard]] size_t size() const;

  /// Adds every site that is at most this many steps along each axis from one of the set. Steps beyond the
  /// window of reset() must not be needed. @param flat leaves z alone
  void dilate(int steps, bool flat);

  [[nodiscard]] const std::vector<BlockIndex>& blocks() const { return blocks_.blocks(); }
  /// Bits of the block number `i` of blocks().
  [[nodiscard]] const Bits& bits(size_t i) const { return bits_[i]; }
  [[nodiscard]] Bits& bits(size_t i) { return bits_[i]; }

  [[nodiscard]] static BlockIndex blockOf(const CellIndex& site)
  {
    return {site.x >> kScanBlockLog2Edge, site.y >> kScanBlockLog2Edge, site.z >> kScanBlockLog2Edge};
  }
  /// Place of a site in its block, in [0, 512): (z·8 + y)·8 + x.
  [[nodiscard]] static uint32_t offsetOf(const CellIndex& site)
  {
    constexpr int32_t kLow = kScanBlockEdge - 1;
    return static_cast<uint32_t>(((site.z & kLow) * kScanBlockEdge + (site.y & kLow)) * kScanBlockEdge +
                                 (site.x & kLow));
  }

  /// Numbers of the blocks in the order of their indices: by z, then y, then x.
  [[nodiscard]] std::vector<size_t> sortedBlocks() const;

  /// Calls visit(site) for every site by z, then y, then x.
  template <typename Visit>
  void forEachSorted(Visit&& visit) const;

 private:
  Bits& bitsOf(const BlockIndex& block);
  void dilateOnce(int axis);

  ScanBlocks blocks_;
  std::vector<Bits> bits_;
};

/// Which sites of a block of 8³ there are, and the place of each among them.
struct SiteBits
{
  SiteSet::Bits bits{};
  std::array<uint16_t, kScanBlockEdge> before{};  ///< how many sites there are before each word's

  [[nodiscard]] bool has(uint32_t offset) const { return (bits[offset / 64] >> (offset % 64) & 1) != 0; }
  /// The bits of the eight sites along x from an offset on.
  [[nodiscard]] uint64_t rowAt(uint32_t offset) const { return bits[offset / 64] >> (offset % 64) & 0xFF; }
  /// Place of the site at an offset, which must be there. Only after countBefore().
  [[nodiscard]] size_t placeOf(uint32_t offset) const
  {
    return before[offset / 64] + countOf(bits[offset / 64] & ((uint64_t{1} << (offset % 64)) - 1));
  }
  void countBefore()
  {
    size_t count = 0;
    for (size_t word = 0; word < bits.size(); ++word)
    {
      before[word] = static_cast<uint16_t>(count);
      count += countOf(bits[word]);
    }
  }
  /// How many bits are set.
  [[nodiscard]] static size_t countOf(uint64_t word)
  {
    // Without an instruction for it the compiler calls a function: eight bits at a time are faster.
    word -= word >> 1 & 0x5555555555555555;
    word = (word & 0x3333333333333333) + (word >> 2 & 0x3333333333333333);
    word = (word + (word >> 4)) & 0x0F0F0F0F0F0F0F0F;
    return static_cast<size_t>(word * 0x0101010101010101 >> 56);
  }

  /// Calls visit(site) for the sites of a block, in the order of bits.
  template <typename Visit>
  static void forEach(const SiteSet::Bits& bits, const BlockIndex& block, Visit&& visit)
  {
    for (int z = 0; z < kScanBlockEdge; ++z)
      for (uint64_t rest = bits[static_cast<size_t>(z)]; rest != 0; rest &= rest - 1)
      {
        const int bit = __builtin_ctzll(rest);
        visit(CellIndex{block.x * kScanBlockEdge + bit % kScanBlockEdge,
                        block.y * kScanBlockEdge + bit / kScanBlockEdge, block.z * kScanBlockEdge + z});
      }
  }
};

/** Numbers for the sites of a set, by z, then y, then x, such that any `width` neighbours along x have
 * neighbouring numbers, of which those between are no site's: vectors of weights can be read `width` at a
 * time. */
class SiteNumbers
{
 public:
  void reset(const SiteSet& sites, int width);

  /// Numbers in use and those between, `width` unused ones at the end included.
  [[nodiscard]] size_t count() const { return count_; }
  /// Numbers in use.
  [[nodiscard]] const std::vector<uint32_t>& used() const { return used_; }
  /// Their sites.
  [[nodiscard]] const std::vector<CellIndex>& sites() const { return sites_; }
  [[nodiscard]] int width() const { return width_; }
  /// 1 for each number in use, else 0.
  [[nodiscard]] const float* isUsed() const { return isUsed_.data(); }

  /// @return the number of the site, or −1.
  [[nodiscard]] int64_t numberOf(const CellIndex& site) const
  {
    const int32_t block = blocks_.find(SiteSet::blockOf(site));
    if (block < 0) return -1;
    return int64_t{numbers_[static_cast<size_t>(block)][SiteSet::offsetOf(site)]} - 1;
  }

  /// The number for a run of `width` sites along x: of its first, were that a site. −1 if none is.
  [[nodiscard]] int64_t numberOfRun(CellIndex first) const
  {
    for (int i = 0; i < width_; ++i, ++first.x)
    {
      const int64_t number = numberOf(first);
      if (number >= 0) return number - i;
    }
    return -1;
  }

 private:
  int width_ = 4;
  size_t count_ = 0;
  ScanBlocks blocks_;
  std::vector<std::array<uint32_t, kScanBlockCells>> numbers_;  ///< + 1; 0: no site
  std::vector<uint32_t> used_;
  std::vector<float> isUsed_;
  std::vector<CellIndex> sites_;
};

template <typename Visit>
void SiteSet::forEachSorted(Visit&& visit) const
{
  const std::vector<size_t> order = sortedBlocks();
  const auto blockAt = [&](size_t i) -> const BlockIndex& { return blocks()[order[i]]; };
  for (size_t layer = 0; layer < order.size();)
  {
    size_t layerEnd = layer;
    while (layerEnd < order.size() && blockAt(layerEnd).z == blockAt(layer).z) ++layerEnd;
    for (int z = 0; z < kScanBlockEdge; ++z)
      for (size_t row = layer; row < layerEnd;)
      {
        size_t rowEnd = row;
        while (rowEnd < layerEnd && blockAt(rowEnd).y == blockAt(row).y) ++rowEnd;
        for (int y = 0; y < kScanBlockEdge; ++y)
          for (size_t i = row; i < rowEnd; ++i)
          {
            const BlockIndex& block = blockAt(i);
            uint64_t rest = bits_[order[i]][static_cast<size_t>(z)] >> (y * kScanBlockEdge) & 0xFF;
            for (; rest != 0; rest &= rest - 1)
              visit(CellIndex{block.x * kScanBlockEdge + __builtin_ctzll(rest), block.y * kScanBlockEdge + y,
                              block.z * kScanBlockEdge + z});
          }
        row = rowEnd;
      }
    layer = layerEnd;
  }
}

}  // namespace lamap
