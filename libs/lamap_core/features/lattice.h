#pragma once

#include <lamap_core/features/site_set.h>
#include <lamap_core/grid/cell.h>
#include <lamap_core/grid/evidence.h>
#include <tsl/robin_map.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace lamap
{
/// A dense box of weights copied from a lattice, rows along x. Weights are 0 where there is no site.
struct SiteBox
{
  CellIndex low;  ///< its first site
  std::array<int32_t, 3> counts{};
  int32_t stride = 0;  ///< from row to row, at least counts[0] + 16
  std::vector<float> weights;
  std::vector<uint8_t> isSite;  ///< laid out alike
  bool anySite = false;

  void reset(const CellIndex& first, const CellIndex& last);
  [[nodiscard]] size_t rowOf(int32_t y, int32_t z) const
  {
    return rowNumber(y, z) * static_cast<size_t>(stride);
  }
  [[nodiscard]] size_t rowNumber(int32_t y, int32_t z) const
  {
    return static_cast<size_t>((z - low.z) * counts[1] + (y - low.y));
  }
};

/// Weights of compact features by site, to be read. Site j is centred at (j + 1/2)·h.
class SiteWeights
{
 public:
  virtual ~SiteWeights() = default;
  /// Copies the sites in [first, last] into a box.
  virtual void copyInto(const CellIndex& first, const CellIndex& last, SiteBox& box) const = 0;
  /// Blocks of 8³ sites that hold any, sorted by z, then y, then x.
  [[nodiscard]] virtual std::vector<BlockIndex> sortedBlocks() const = 0;
  /// Which sites of a block there are; nothing set where there is no such block.
  [[nodiscard]] virtual SiteSet::Bits bitsOf(const BlockIndex& block) const = 0;

 protected:
  SiteWeights() = default;
  SiteWeights(const SiteWeights&) = default;
  SiteWeights& operator=(const SiteWeights&) = default;
  SiteWeights(SiteWeights&&) = default;
  SiteWeights& operator=(SiteWeights&&) = default;
};

/// What the incremental map knows of a weight: its Gaussian posterior.
struct SitePosterior
{
  float mean = 0;       ///< μ
  float precision = 0;  ///< Λ

  friend bool operator==(const SitePosterior& a, const SitePosterior& b)
  {
    return a.mean == b.mean && a.precision == b.precision;
  }
};

[[nodiscard]] inline float meanOf(float weight)
{
  return weight;
}
[[nodiscard]] inline float meanOf(const SitePosterior& posterior)
{
  return posterior.mean;
}

/** A sparse lattice of features, packed: blocks of 8³ sites, each a bit per site and the weights of the
 * sites whose bit is set.
 * @tparam Weight float, or SitePosterior
 *
 * Thread guarantee: const methods may be called from several threads. */
template <typename Weight>
class HilbertLattice : public SiteWeights
{
 public:
  struct Block : public SiteBits
  {
    std::vector<Weight> weights;  ///< of the sites whose bit is set, in the order of bits

    [[nodiscard]] float meanAt(size_t place) const { return meanOf(weights[place]); }
    friend bool operator==(const Block& a, const Block& b)
    {
      return a.bits == b.bits && a.weights == b.weights;
    }
  };

  [[nodiscard]] size_t blockCount() const { return blocks_.size(); }
  [[nodiscard]] size_t siteCount() const
  {
    size_t count = 0;
    for (const auto& [index, block] : blocks_) count += block.weights.size();
    return count;
  }
  void clear() { blocks_.clear(); }

  [[nodiscard]] const Block* find(const BlockIndex& index) const
  {
    const auto found = blocks_.find(index);
    return found == blocks_.end() ? nullptr : &found->second;
  }
  [[nodiscard]] Block* find(const BlockIndex& index)
  {
    return const_cast<Block*>(static_cast<const HilbertLattice*>(this)->find(index));
  }
  /// @return the weight of a site, or null.
  [[nodiscard]] const Weight* find(const CellIndex& site) const
  {
    const Block* block = find(SiteSet::blockOf(site));
    const uint32_t offset = SiteSet::offsetOf(site);
    return block != nullptr && block->has(offset) ? &block->weights[block->placeOf(offset)] : nullptr;
  }
  [[nodiscard]] Weight* find(const CellIndex& site)
  {
    return const_cast<Weight*>(static_cast<const HilbertLattice*>(this)->find(site));
  }

  /// Puts a block in the place of the one there, e.g. from a file. @param block with as many weights as bits
  void put(const BlockIndex& index, Block block)
  {
    block.weights.shrink_to_fit();
    block.countBefore();
    blocks_[index] = std::move(block);
  }

  /** Adds the sites of a block that are not there yet, with this weight; if that fails, nothing is changed.
   * @return the block as it was before; nothing if all sites were there */
  std::optional<Block> addSites(const BlockIndex& index, const SiteSet::Bits& bits, const Weight& weight);
  /// Puts a block back that addSites() returned. Cannot fail.
  void putBack(const BlockIndex& index, Block before) noexcept
  {
    if (before.weights.empty())
      blocks_.erase(index);
    else
      *find(index) = std::move(before);
  }

  void copyInto(const CellIndex& first, const CellIndex& last, SiteBox& box) const override;
  [[nodiscard]] std::vector<BlockIndex> sortedBlocks() const override;
  [[nodiscard]] SiteSet::Bits bitsOf(const BlockIndex& index) const override
  {
    const Block* block = find(index);
    return block != nullptr ? block->bits : SiteSet::Bits{};
  }

  /// Bytes of all blocks and of the index over them.
  [[nodiscard]] size_t memoryBytes() const
  {
    size_t bytes = blocks_.bucket_count() * (sizeof(std::pair<BlockIndex, Block>) + 8);
    for (const auto& [index, block] : blocks_) bytes += block.weights.capacity() * sizeof(Weight);
    return bytes;
  }

  friend bool operator==(const HilbertLattice& a, const HilbertLattice& b)
  {
    if (a.blocks_.size() != b.blocks_.size()) return false;
    return std::all_of(a.blocks_.begin(), a.blocks_.end(),
                       [&](const auto& entry)
                       {
                         const Block* other = b.find(entry.first);
                         return other != nullptr && *other == entry.second;
                       });
  }

 private:
  tsl::robin_map<BlockIndex, Block, BlockIndexHash> blocks_;
};

/** Sites that are added to a lattice for something that may yet fail: unless they are kept, the lattice is as
 * it was when this ends. */
template <typename Weight>
class LatticeGrowth
{
 public:
  /// @param blocks that get sites, at most
  LatticeGrowth(HilbertLattice<Weight>& lattice, size_t blocks) : lattice_(lattice)
  {
    before_.reserve(blocks);
  }
  ~LatticeGrowth()
  {
    for (auto& [index, block] : before_) lattice_.putBack(index, std::move(block));
  }
  LatticeGrowth(const LatticeGrowth&) = delete;
  LatticeGrowth& operator=(const LatticeGrowth&) = delete;

  /// As HilbertLattice::addSites(), at most once for each block. @return the sites that are new
  SiteSet::Bits addSites(const BlockIndex& index, const SiteSet::Bits& bits, const Weight& weight)
  {
    SiteSet::Bits added{};
    auto before = lattice_.addSites(index, bits, weight);
    if (!before) return added;
    for (size_t word = 0; word < bits.size(); ++word) added[word] = bits[word] & ~before->bits[word];
    before_.emplace_back(index, *std::move(before));
    return added;
  }
  void keep() { before_.clear(); }

 private:
  HilbertLattice<Weight>& lattice_;
  std::vector<std::pair<BlockIndex, typename HilbertLattice<Weight>::Block>> before_;
};

template <typename Weight>
auto HilbertLattice<Weight>::addSites(const BlockIndex& index, const SiteSet::Bits& bits,
                                      const Weight& weight) -> std::optional<Block>
{
  const Block* there = find(index);
  const Block none;
  const Block& block = there != nullptr ? *there : none;
  size_t count = 0;
  bool any = false;
  for (size_t word = 0; word < bits.size(); ++word)
  {
    count += SiteBits::countOf(bits[word] | block.bits[word]);
    any = any || (bits[word] & ~block.bits[word]) != 0;
  }
  if (!any) return std::nullopt;
  Block merged;
  merged.weights.reserve(count);
  size_t place = 0;
  for (size_t word = 0; word < bits.size(); ++word)
  {
    merged.bits[word] = bits[word] | block.bits[word];
    for (uint64_t rest = merged.bits[word]; rest != 0; rest &= rest - 1)
    {
      const uint64_t bit = rest & ~(rest - 1);
      merged.weights.push_back((block.bits[word] & bit) != 0 ? block.weights[place++] : weight);
    }
  }
  merged.countBefore();
  std::swap(blocks_[index], merged);
  return merged;
}

template <typename Weight>
void HilbertLattice<Weight>::copyInto(const CellIndex& first, const CellIndex& last, SiteBox& box) const
{
  box.reset(first, last);
  const BlockIndex low = SiteSet::blockOf(first);
  const BlockIndex high = SiteSet::blockOf(last);
  const auto copyBlock = [&](const BlockIndex& index, const Block& block)
  {
    const CellIndex corner{index.x * kScanBlockEdge, index.y * kScanBlockEdge, index.z * kScanBlockEdge};
    size_t place = 0;
    for (int32_t z = 0; z < kScanBlockEdge; ++z)
    {
      const uint64_t word = block.bits[static_cast<size_t>(z)];
      if (corner.z + z < first.z || corner.z + z > last.z)
      {
        place += SiteBits::countOf(word);
        continue;
      }
      for (uint64_t rest = word; rest != 0; rest &= rest - 1, ++place)
      {
        const int bit = __builtin_ctzll(rest);
        const int32_t x = corner.x + bit % kScanBlockEdge;
        const int32_t y = corner.y + bit / kScanBlockEdge;
        if (x < first.x || x > last.x || y < first.y || y > last.y) continue;
        const size_t at = box.rowOf(y, corner.z + z) + static_cast<size_t>(x - first.x);
        box.weights[at] = meanOf(block.weights[place]);
        box.isSite[at] = 1;
        box.anySite = true;
      }
    }
  };
  for (int32_t z = low.z; z <= high.z; ++z)
    for (int32_t y = low.y; y <= high.y; ++y)
      for (int32_t x = low.x; x <= high.x; ++x)
        if (const Block* block = find(BlockIndex{x, y, z})) copyBlock({x, y, z}, *block);
}

template <typename Weight>
std::vector<BlockIndex> HilbertLattice<Weight>::sortedBlocks() const
{
  std::vector<BlockIndex> indices;
  indices.reserve(blocks_.size());
  for (const auto& [index, block] : blocks_) indices.push_back(index);
  std::sort(indices.begin(), indices.end());
  return indices;
}

}  // namespace lamap
