#pragma once

#include <lamap_core/grid/cell.h>
#include <lamap_core/grid/evidence_block.h>
#include <tsl/robin_map.h>

#include <cstddef>
#include <cstdint>
#include <memory>
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

/** A sparse grid of blocks whose cells add evidence.
 *
 * Thread guarantee: const methods may be called from several threads; blocks of different indices may be
 * changed from different threads once they exist.
 */
class BlockGrid
{
 public:
  explicit BlockGrid(const BlockShape& shape) : shape_(shape) {}
  BlockGrid(const BlockGrid& other);
  BlockGrid& operator=(const BlockGrid& other);
  BlockGrid(BlockGrid&&) noexcept = default;
  BlockGrid& operator=(BlockGrid&&) noexcept = default;

  [[nodiscard]] const BlockShape& shape() const { return shape_; }
  [[nodiscard]] size_t blockCount() const { return blocks_.size(); }
  void clear() { blocks_.clear(); }

  [[nodiscard]] BlockIndex blockOf(const CellIndex& cell) const
  {
    return {cell.x >> shape_.log2Edge(), cell.y >> shape_.log2Edge(),
            shape_.planar() ? cell.z : cell.z >> shape_.log2Edge()};
  }
  /// The cell of a block with the smallest indices.
  [[nodiscard]] CellIndex firstCellOf(const BlockIndex& block) const
  {
    const int32_t edge = int32_t{1} << shape_.log2Edge();
    return {block.x * edge, block.y * edge, shape_.planar() ? block.z : block.z * edge};
  }

  [[nodiscard]] const EvidenceBlock* find(const BlockIndex& index) const
  {
    const auto found = blocks_.find(index);
    return found == blocks_.end() ? nullptr : found->second.get();
  }
  [[nodiscard]] EvidenceBlock* find(const BlockIndex& index)
  {
    return const_cast<EvidenceBlock*>(static_cast<const BlockGrid*>(this)->find(index));
  }
  EvidenceBlock& findOrCreate(const BlockIndex& index);

  /// Zero where the cell has no evidence.
  [[nodiscard]] Evidence evidence(const CellIndex& cell) const
  {
    const EvidenceBlock* block = find(blockOf(cell));
    return block ? block->at(shape_, shape_.offsetOf(cell)) : Evidence{};
  }

  /// Forgets a block, if it is there.
  void erase(const BlockIndex& index) { blocks_.erase(index); }

  [[nodiscard]] std::vector<BlockIndex> sortedBlocks() const;

  /// Bytes of all blocks and of the index over them.
  [[nodiscard]] size_t memoryBytes() const;

 private:
  BlockShape shape_;
  tsl::robin_map<BlockIndex, std::unique_ptr<EvidenceBlock>, BlockIndexHash> blocks_;
};

}  // namespace lamap
