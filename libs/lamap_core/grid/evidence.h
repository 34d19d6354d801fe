#pragma once

#include <lamap_core/grid/cell.h>
#include <lamap_core/grid/cell_extent.h>
#include <lamap_core/grid/evidence_block.h>
#include <tsl/robin_map.h>

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

namespace lamap
{
/** Evidence: what a scan says, or what a map holds. A sparse grid of blocks with two sums per cell.
 *
 * Evidence adds to evidence: see EvidenceChange.
 *
 * Thread guarantee: const methods may be called from several threads.
 */
class Evidence
{
 public:
  explicit Evidence(const BlockShape& shape, SumKind kind = SumKind::Counts) : shape_(shape), kind_(kind) {}
  Evidence(const Evidence& other);
  Evidence& operator=(const Evidence& other);
  Evidence(Evidence&&) noexcept = default;
  Evidence& operator=(Evidence&&) noexcept = default;

  [[nodiscard]] const BlockShape& shape() const { return shape_; }
  [[nodiscard]] SumKind kind() const { return kind_; }
  [[nodiscard]] size_t blockCount() const { return blocks_.size(); }
  void clear()
  {
    blocks_.clear();
    if (extent_) extent_.emplace(shape_);
  }

  [[nodiscard]] BlockIndex blockOf(const CellIndex& cell) const { return shape_.blockOf(cell); }
  [[nodiscard]] CellIndex firstCellOf(const BlockIndex& block) const { return shape_.firstCellOf(block); }

  [[nodiscard]] const EvidenceBlock* find(const BlockIndex& index) const
  {
    const auto found = blocks_.find(index);
    return found == blocks_.end() ? nullptr : found->second.get();
  }
  [[nodiscard]] EvidenceBlock* find(const BlockIndex& index)
  {
    return const_cast<EvidenceBlock*>(static_cast<const Evidence*>(this)->find(index));
  }
  /// An empty block, where there was none: to be filled, or erased again.
  EvidenceBlock& findOrCreate(const BlockIndex& index);

  /// Zero where the cell has no evidence.
  [[nodiscard]] CellSums at(const CellIndex& cell) const
  {
    const EvidenceBlock* block = find(blockOf(cell));
    return block ? block->at(shape_, shape_.offsetOf(cell)) : CellSums{};
  }

  /// From now on knows the extent of its cells; only an EvidenceChange may change them then.
  void keepExtent();
  /// Where its cells are; null unless it keeps that.
  [[nodiscard]] const CellExtent* extent() const { return extent_ ? &*extent_ : nullptr; }
  [[nodiscard]] CellExtent* extent() { return extent_ ? &*extent_ : nullptr; }

  /// Forgets a block, if it is there.
  void erase(const BlockIndex& index) noexcept { blocks_.erase(index); }

  /// The order of blocks in files.
  [[nodiscard]] std::vector<BlockIndex> sortedBlocks() const;
  /// Makes room in the index for that many blocks.
  void reserve(size_t blocks) { blocks_.reserve(blocks); }
  /// Calls visit(index, block) for each block, in no promised order.
  template <typename Visit>
  void forEachBlock(Visit&& visit) const
  {
    for (const auto& [index, block] : blocks_) visit(index, static_cast<const EvidenceBlock&>(*block));
  }
  template <typename Visit>
  void forEachBlock(Visit&& visit)
  {
    for (const auto& [index, block] : blocks_) visit(index, *block);
  }

  /// Bytes of all blocks and of what tells where they are.
  [[nodiscard]] size_t memoryBytes() const;

  /// The same blocks, packed in the same way.
  friend bool operator==(const Evidence& a, const Evidence& b);

 private:
  BlockShape shape_;
  SumKind kind_;
  tsl::robin_map<BlockIndex, std::unique_ptr<EvidenceBlock>, BlockIndexHash> blocks_;
  std::optional<CellExtent> extent_;
};

}  // namespace lamap
