#pragma once

#include <lamap_core/grid/evidence.h>

#include <cstdint>
#include <vector>

namespace lamap
{
/// Edge, in cells, of the blocks a scan's training set is sorted into, whatever the map's own blocks are.
constexpr int kScanBlockLog2Edge = 3;
constexpr int kScanBlockEdge = 1 << kScanBlockLog2Edge;
constexpr int kScanBlockCells = kScanBlockEdge * kScanBlockEdge * kScanBlockEdge;

/** The blocks a scan touches, numbered in the order of their first touch.
 *
 * Finding one is an access to a dense array where the scan spans few enough blocks, else a look-up in a hash
 * table. */
class ScanBlocks
{
 public:
  /// Forgets all blocks; from now on only blocks in [low, high] may be asked for.
  void reset(const BlockIndex& low, const BlockIndex& high);

  /// How many blocks one scan may touch: their masks and sums shall fit a machine's memory.
  static constexpr size_t kMaxBlocks = size_t{1} << 22;
  /// @throws std::length_error that says that a scan touches more
  [[noreturn]] static void refuse();

  /// @return the block's number, or −1.
  [[nodiscard]] int32_t find(const BlockIndex& block) const
  {
    if (!inWindow(block)) return -1;
    if (!dense_)
    {
      const auto found = numbers_.find(block);
      return found == numbers_.end() ? -1 : found->second;
    }
    return window_[windowIndex(block)] - 1;
  }

  /// @throws std::length_error if the scan touches more than kMaxBlocks.
  [[nodiscard]] int32_t findOrAdd(const BlockIndex& block)
  {
    if (!dense_) return findOrAddHashed(block);
    int32_t& numberPlusOne = window_[windowIndex(block)];
    if (numberPlusOne == 0)
    {
      requireRoom();
      blocks_.push_back(block);
      numberPlusOne = static_cast<int32_t>(blocks_.size());
    }
    return numberPlusOne - 1;
  }

  [[nodiscard]] const std::vector<BlockIndex>& blocks() const { return blocks_; }
  [[nodiscard]] const BlockIndex& low() const { return low_; }
  [[nodiscard]] const BlockIndex& high() const { return high_; }

 private:
  [[nodiscard]] bool inWindow(const BlockIndex& block) const
  {
    return block.x >= low_.x && block.x <= high_.x && block.y >= low_.y && block.y <= high_.y &&
           block.z >= low_.z && block.z <= high_.z;
  }
  [[nodiscard]] size_t windowIndex(const BlockIndex& block) const
  {
    return (static_cast<size_t>(block.z - low_.z) * countY_ + static_cast<size_t>(block.y - low_.y)) *
               countX_ +
           static_cast<size_t>(block.x - low_.x);
  }
  int32_t findOrAddHashed(const BlockIndex& block);
  void requireRoom() const
  {
    if (blocks_.size() >= kMaxBlocks) refuse();
  }

  BlockIndex low_;
  BlockIndex high_;
  size_t countX_ = 0;
  size_t countY_ = 0;
  bool dense_ = true;
  std::vector<int32_t> window_;  ///< number + 1; 0: not touched
  tsl::robin_map<BlockIndex, int32_t, BlockIndexHash> numbers_;
  std::vector<BlockIndex> blocks_;
};

}  // namespace lamap
