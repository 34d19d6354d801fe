#pragma once

#include <lamap_core/grid/cell.h>
#include <lamap_core/grid/cell_extent.h>
#include <lamap_core/grid/evidence_block.h>
#include <tsl/robin_map.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace lamap
{
/// Counts changes. Also goes on where another object is put in the place of its owner, or its owner is moved
/// from; a copy begins anew.
class ChangeCount
{
 public:
  ChangeCount() = default;
  ChangeCount(const ChangeCount&) noexcept {}
  ChangeCount(ChangeCount&& other) noexcept { other.add(); }
  ChangeCount& operator=(const ChangeCount&) noexcept
  {
    add();
    return *this;
  }
  ChangeCount& operator=(ChangeCount&& other) noexcept
  {
    add();
    other.add();
    return *this;
  }

  void add() noexcept { ++count_; }
  [[nodiscard]] uint64_t count() const { return count_; }

 private:
  uint64_t count_ = 0;
};

/** Evidence: what a scan says, or what a map holds. A sparse grid of blocks with two sums per cell.
 *
 * Evidence adds to evidence: see EvidenceChange. Copies share their blocks until one of them changes, so that
 * a particle filter copies maps in no time.
 *
 * Thread guarantee: const methods may be called from several threads; copies may be changed by one thread
 * each.
 */
class Evidence
{
 public:
  explicit Evidence(const BlockShape& shape, SumKind kind = SumKind::Counts) : shape_(shape), kind_(kind) {}
  Evidence(const Evidence& other) = default;
  Evidence& operator=(const Evidence& other);
  Evidence(Evidence&&) noexcept = default;
  Evidence& operator=(Evidence&&) noexcept = default;

  [[nodiscard]] const BlockShape& shape() const { return shape_; }
  [[nodiscard]] SumKind kind() const { return kind_; }
  [[nodiscard]] size_t blockCount() const { return blocks_.size(); }
  void clear()
  {
    changes_.add();
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
  /// An empty block, where there was none: to be filled, or erased again.
  EvidenceBlock& findOrCreate(const BlockIndex& index);
  /// Puts a block in the place of one that is there.
  void replace(const BlockIndex& index, std::shared_ptr<EvidenceBlock>&& by) noexcept
  {
    changes_.add();
    blocks_.find(index).value() = std::move(by);
  }
  /// Takes a block out; null if there is none.
  [[nodiscard]] std::shared_ptr<EvidenceBlock> take(const BlockIndex& index);

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
  void erase(const BlockIndex& index) noexcept
  {
    changes_.add();
    blocks_.erase(index);
  }

  /// Another number after each change: while it stays, blocks stay where they are and as they are.
  [[nodiscard]] uint64_t changes() const { return changes_.count(); }

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
  /// The same, of blocks that may be changed.
  template <typename Visit>
  void forEachBlock(Visit&& visit)
  {
    changes_.add();
    for (auto entry = blocks_.begin(); entry != blocks_.end(); ++entry)
      visit(entry->first, ownOf(entry.value()));
  }

  /// Bytes of all blocks and of what tells where they are.
  [[nodiscard]] size_t memoryBytes() const;

  /// The same blocks, packed in the same way.
  friend bool operator==(const Evidence& a, const Evidence& b);

 private:
  using BlockPointer = std::shared_ptr<EvidenceBlock>;
  /// The block, which no copy of this evidence has any more.
  static EvidenceBlock& ownOf(BlockPointer& block);

  BlockShape shape_;
  SumKind kind_;
  tsl::robin_map<BlockIndex, BlockPointer, BlockIndexHash> blocks_;
  std::optional<CellExtent> extent_;
  ChangeCount changes_;
};

}  // namespace lamap
