#pragma once

#include <lamap_core/grid/cell.h>
#include <lamap_core/grid/cell_sums.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace lamap
{
/// Index of a block: floor of the cell index divided by the block's edge in cells.
struct BlockIndex
{
  int32_t x = 0;
  int32_t y = 0;
  int32_t z = 0;

  friend bool operator==(const BlockIndex& a, const BlockIndex& b)
  {
    return a.x == b.x && a.y == b.y && a.z == b.z;
  }
  /// By z, then y, then x: the order of blocks in files.
  friend bool operator<(const BlockIndex& a, const BlockIndex& b)
  {
    if (a.z != b.z) return a.z < b.z;
    if (a.y != b.y) return a.y < b.y;
    return a.x < b.x;
  }
};

struct BlockIndexHash
{
  [[nodiscard]] size_t operator()(const BlockIndex& index) const noexcept
  {
    uint64_t h = static_cast<uint32_t>(index.x) * 0x9E3779B97F4A7C15ULL;
    h ^= (static_cast<uint32_t>(index.y) + (h >> 29)) * 0xBF58476D1CE4E5B9ULL;
    h ^= (static_cast<uint32_t>(index.z) + (h >> 32)) * 0x94D049BB133111EBULL;
    return static_cast<size_t>(h ^ (h >> 31));
  }
};

/// The longest edge of a block [cells].
constexpr int kMostBlockEdge = 32;

/// In which layers along x, y and z a block has a cell with evidence: a bit each, that of its first cells the
/// lowest.
using BlockLayers = std::array<uint32_t, 3>;

/** Size of a block and the order of its cells.
 *
 * Cells are numbered along the Morton curve, so that an octant (a quadrant in a planar grid) of any level is
 * one run of numbers. */
class BlockShape
{
 public:
  /// @param log2Edge of the edge in cells, 1 to 5. A planar block is one cell high.
  BlockShape(int log2Edge, bool planar);

  [[nodiscard]] int log2Edge() const { return log2Edge_; }
  [[nodiscard]] int edge() const { return 1 << log2Edge_; }
  [[nodiscard]] bool planar() const { return planar_; }
  [[nodiscard]] size_t cellCount() const { return size_t{1} << (log2Edge_ * axes()); }
  /// 64-bit words of a mask with one bit per cell.
  [[nodiscard]] size_t maskWords() const { return (cellCount() + 63) / 64; }
  /// Children of a node: 8, or 4 in a planar grid.
  [[nodiscard]] size_t branching() const { return size_t{1} << axes(); }

  /// Morton number of a cell in its block.
  [[nodiscard]] uint32_t offsetOf(const CellIndex& cell) const
  {
    const uint32_t mask = static_cast<uint32_t>(edge() - 1);
    return offsetOfLocal(static_cast<uint32_t>(cell.x) & mask, static_cast<uint32_t>(cell.y) & mask,
                         planar_ ? 0 : static_cast<uint32_t>(cell.z) & mask);
  }
  [[nodiscard]] uint32_t offsetOfLocal(uint32_t x, uint32_t y, uint32_t z) const
  {
    return planar_ ? (kSpread2[x] | kSpread2[y] << 1) : (kSpread3[x] | kSpread3[y] << 1 | kSpread3[z] << 2);
  }
  /// The inverse: local coordinates of a Morton number.
  [[nodiscard]] CellIndex localOf(uint32_t offset) const
  {
    const uint32_t packed =
        planar_ ? kLocal2[offset & 63] + (kLocal2[offset >> 6] << 3)
                : kLocal3[offset & 63] + (kLocal3[offset >> 6 & 63] << 2) + (kLocal3[offset >> 12] << 4);
    return {static_cast<int32_t>(packed & 0xFF), static_cast<int32_t>(packed >> 8 & 0xFF),
            static_cast<int32_t>(packed >> 16)};
  }
  /// The cell with a Morton number in a block. @param first of the block's cells
  [[nodiscard]] CellIndex plus(const CellIndex& first, uint32_t offset) const
  {
    const CellIndex local = localOf(offset);
    return {first.x + local.x, first.y + local.y, first.z + local.z};
  }

  [[nodiscard]] BlockIndex blockOf(const CellIndex& cell) const
  {
    return {cell.x >> log2Edge_, cell.y >> log2Edge_, planar_ ? cell.z : cell.z >> log2Edge_};
  }
  /// The cell of a block with the smallest indices.
  [[nodiscard]] CellIndex firstCellOf(const BlockIndex& block) const
  {
    return {block.x * edge(), block.y * edge(), planar_ ? block.z : block.z * edge()};
  }

  friend bool operator==(const BlockShape& a, const BlockShape& b)
  {
    return a.log2Edge_ == b.log2Edge_ && a.planar_ == b.planar_;
  }

 private:
  [[nodiscard]] int axes() const { return planar_ ? 2 : 3; }
  static const uint32_t kSpread2[32];
  static const uint32_t kSpread3[32];
  /// By six bits of a Morton number: x | y << 8 | z << 16.
  static const uint32_t kLocal2[64];
  static const uint32_t kLocal3[64];

  int log2Edge_;
  bool planar_;
};

/// A block with each cell by itself, to be filled or changed; packed by EvidenceBlock. Indices are Morton
/// numbers.
struct DenseBlock
{
  explicit DenseBlock(const BlockShape& shape) : observed(shape.maskWords()), sums(shape.cellCount()) {}

  [[nodiscard]] bool isObserved(uint32_t offset) const { return observed[offset >> 6] >> (offset & 63) & 1; }
  [[nodiscard]] bool any() const;
  /// Zero, or what was there before clear(), where the cell is not observed.
  [[nodiscard]] const CellSums& at(uint32_t offset) const { return sums[offset]; }
  void set(uint32_t offset, const CellSums& cell)
  {
    sums[offset] = cell;
    observed[offset >> 6] |= uint64_t{1} << (offset & 63);
  }
  /// No cell is observed any more.
  void clear();

  std::vector<uint64_t> observed;
  std::vector<CellSums> sums;
};

/// May the cells of an octant, numbered [first, first + count), be held once, and with which evidence?
using OctantMerger =
    std::function<bool(const DenseBlock& block, uint32_t first, uint32_t count, CellSums& merged)>;

/** The test-data octree of one block, packed: a mask of the observed cells, a mask of the leaves' first cells
 * where octants are held once, and the evidence of each leaf in order; 32 bits per number, 64 where one
 * needs them.
 *
 * The masks are kept apart from the evidence, with how many leaves begin before each of their words: those of
 * a whole map stay in a processor's cache, and finding a cell takes no more than one access beyond it. */
class EvidenceBlock
{
 public:
  /// Bits without hardware support assumed: the architecture's baseline has none.
  static size_t countBits(uint64_t word)
  {
    word -= word >> 1 & 0x5555555555555555u;
    word = (word & 0x3333333333333333u) + (word >> 2 & 0x3333333333333333u);
    word = (word + (word >> 4)) & 0x0F0F0F0F0F0F0F0Fu;
    return static_cast<size_t>(word * 0x0101010101010101u >> 56);
  }
  static size_t countBits(const uint64_t* words, size_t count)
  {
    size_t sum = 0;
    for (size_t i = 0; i < count; ++i) sum += countBits(words[i]);
    return sum;
  }

  /// Where the parts of a block that holds cells are, for many questions; valid until the block changes.
  struct View
  {
    const uint64_t* ranks = nullptr;  ///< null: of no block
    const uint64_t* observed = nullptr;
    const uint64_t* leafStarts = nullptr;
    const uint64_t* leaves = nullptr;
    bool wide = false;

    /// Zero where the cell has no evidence. Not of no block.
    [[nodiscard]] CellSums at(uint32_t offset) const
    {
      const uint32_t word = offset >> 6;
      const uint64_t bit = uint64_t{1} << (offset & 63);
      if ((observed[word] & bit) == 0) return {};
      const uint64_t before = ranks[word >> 2] >> (word & 3) * 16 & 0xFFFFu;
      const size_t rank = before + countBits(leafStarts[word] & (bit | (bit - 1))) - 1;
      if (wide) return {leaves[2 * rank], leaves[2 * rank + 1]};
      return {leaves[rank] & 0xFFFFFFFFu, leaves[rank] >> 32};
    }
  };
  [[nodiscard]] View view(const BlockShape& shape) const
  {
    if (empty()) return {};
    return {masks_.data(), observedMask(shape), leafMask(shape), leaves_.data(), wide_};
  }

  /// Zero where the cell has no evidence.
  [[nodiscard]] CellSums at(const BlockShape& shape, uint32_t offset) const
  {
    return empty() ? CellSums{} : view(shape).at(offset);
  }

  void unpack(const BlockShape& shape, DenseBlock& dense) const;

  /** Whether addPlain() may add this block of counts to another: both are neither pruned nor wide, and no sum
   * can pass 2^32. */
  [[nodiscard]] bool isPlainFor(const EvidenceBlock& other) const;
  /// Adds the counts of another block: see isPlainFor().
  void addPlain(const BlockShape& shape, const EvidenceBlock& other);

  /// In a block that is neither pruned nor wide: are all cells of some finest octant observed and equal?
  [[nodiscard]] bool hasEqualOctant(const BlockShape& shape) const;

  /** Packs every cell by itself, then holds octants once from the finest level up.
   * @param merger decides; empty: no octant is held once. */
  void pack(const BlockShape& shape, const DenseBlock& dense, const OctantMerger& merger);

  /// Every cell by itself. @param cells by Morton number: first | second << 32; 0 where not observed
  [[nodiscard]] static EvidenceBlock ofNarrowCells(const BlockShape& shape, const uint64_t* cells);

  [[nodiscard]] bool empty() const { return masks_.empty(); }
  [[nodiscard]] bool wide() const { return wide_; }
  [[nodiscard]] bool pruned() const { return pruned_; }
  [[nodiscard]] size_t leafCount(const BlockShape& shape) const;
  [[nodiscard]] size_t observedCount(const BlockShape& shape) const;
  [[nodiscard]] BlockLayers layers(const BlockShape& shape) const;
  [[nodiscard]] size_t memoryBytes() const
  {
    return sizeof(*this) + (masks_.capacity() + leaves_.capacity()) * sizeof(uint64_t);
  }

  /// For files: observed mask, leaf mask if pruned, leaves; and back. The same content gives the same words.
  [[nodiscard]] std::vector<uint64_t> words(const BlockShape& shape) const;
  /// @throws std::runtime_error if the words are not what pack() could have made of sums of this kind.
  static EvidenceBlock fromWords(const BlockShape& shape, SumKind kind, bool wide, bool pruned,
                                 const std::vector<uint64_t>& words);

  /// The same cells, packed in the same way.
  friend bool operator==(const EvidenceBlock& a, const EvidenceBlock& b)
  {
    return a.wide_ == b.wide_ && a.pruned_ == b.pruned_ && a.masks_ == b.masks_ && a.leaves_ == b.leaves_;
  }

  /// Calls visit(first cell, number of cells, evidence) for each leaf, in order.
  template <typename Visitor>
  void visitLeaves(const BlockShape& shape, Visitor&& visit) const;

 private:
  /// Of numbers of 16 bits, one per word of the leaf mask: how many leaves begin before it.
  static size_t rankWords(const BlockShape& shape) { return (shape.maskWords() + 3) / 4; }

  [[nodiscard]] const uint64_t* observedMask(const BlockShape& shape) const
  {
    return masks_.data() + rankWords(shape);
  }
  [[nodiscard]] const uint64_t* leafMask(const BlockShape& shape) const
  {
    return masks_.data() + rankWords(shape) + (pruned_ ? shape.maskWords() : 0);
  }
  /// Puts masks in their place and counts the leaves. @param leafStarts null: every observed cell is a leaf
  void setMasks(const BlockShape& shape, const uint64_t* observed, const uint64_t* leafStarts);
  /// Number of cells of the leaf that begins there: the largest octant none of whose other cells begins a
  /// leaf.
  [[nodiscard]] uint32_t leafCells(const BlockShape& shape, uint32_t begin) const;
  [[nodiscard]] CellSums leaf(size_t rank) const
  {
    if (wide_) return {leaves_[2 * rank], leaves_[2 * rank + 1]};
    return {leaves_[rank] & 0xFFFFFFFFu, leaves_[rank] >> 32};
  }

  std::vector<uint64_t> masks_;   ///< ranks, observed mask, leaf mask if pruned
  std::vector<uint64_t> leaves_;  ///< one word each, or two if wide
  uint32_t most_ = 0;             ///< no number of a block that is not wide is larger
  bool wide_ = false;
  bool pruned_ = false;
};

template <typename Visitor>
void EvidenceBlock::visitLeaves(const BlockShape& shape, Visitor&& visit) const
{
  if (empty()) return;
  const uint64_t* first = leafMask(shape);
  size_t rank = 0;
  for (size_t word = 0; word < shape.maskWords(); ++word)
  {
    for (uint64_t rest = first[word]; rest != 0; rest &= rest - 1)
    {
      const auto begin = static_cast<uint32_t>(word * 64 + static_cast<size_t>(__builtin_ctzll(rest)));
      visit(begin, pruned_ ? leafCells(shape, begin) : 1u, leaf(rank++));
    }
  }
}

}  // namespace lamap
