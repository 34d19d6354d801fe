#pragma once

#include <lamap_core/grid/evidence.h>

#include <utility>
#include <vector>

namespace lamap
{
/** The blocks that one thread makes of a scan's evidence, one after the other. */
class EvidenceDraft
{
 public:
  explicit EvidenceDraft(const BlockShape& shape) : shape_(shape), block_(shape) {}

  /// The evidence of a cell of the current block. @param offset its Morton number
  void set(uint32_t offset, const CellSums& sums) { block_.set(offset, sums); }
  /// Ends the current block, which may be without cells.
  void finishBlock(const BlockIndex& index)
  {
    if (!block_.any()) return;
    made_.emplace_back(index, EvidenceBlock{});
    made_.back().second.pack(shape_, block_, {});
    block_.clear();
  }

  /// A whole block at once. @param cells as EvidenceBlock::ofNarrowCells() takes them
  void addBlock(const BlockIndex& index, const uint64_t* cells)
  {
    EvidenceBlock block = EvidenceBlock::ofNarrowCells(shape_, cells);
    if (!block.empty()) made_.emplace_back(index, std::move(block));
  }

  [[nodiscard]] size_t blockCount() const { return made_.size(); }
  /// Hands over all blocks; nobody else has made one of them.
  void moveTo(Evidence& evidence)
  {
    for (auto& [index, block] : made_) evidence.findOrCreate(index) = std::move(block);
    made_.clear();
  }

 private:
  BlockShape shape_;
  DenseBlock block_;
  std::vector<std::pair<BlockIndex, EvidenceBlock>> made_;
};

/// The evidence that several threads have drafted. @param workers hold members `draft`
template <typename WorkerRange>
[[nodiscard]] Evidence collectEvidence(const BlockShape& shape, SumKind kind, WorkerRange& workers)
{
  Evidence evidence(shape, kind);
  size_t blocks = 0;
  for (auto& worker : workers) blocks += worker.draft.blockCount();
  evidence.reserve(blocks);
  for (auto& worker : workers) worker.draft.moveTo(evidence);
  return evidence;
}

}  // namespace lamap
