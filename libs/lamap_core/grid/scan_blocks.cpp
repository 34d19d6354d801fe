#include <lamap_core/grid/scan_blocks.h>

#include <stdexcept>
#include <string>

namespace lamap
{
void ScanBlocks::reset(const BlockIndex& low, const BlockIndex& high)
{
  if (dense_)
  {
    for (const BlockIndex& block : blocks_) window_[windowIndex(block)] = 0;
  }
  numbers_.clear();
  blocks_.clear();

  constexpr double kMaxDenseBlocks = 1 << 23;
  const auto extent = [](int32_t from, int32_t to) { return static_cast<double>(to) - from + 1; };
  dense_ = extent(low.x, high.x) * extent(low.y, high.y) * extent(low.z, high.z) <= kMaxDenseBlocks;
  low_ = low;
  high_ = high;
  if (!dense_) return;
  countX_ = static_cast<size_t>(high.x - low.x + 1);
  countY_ = static_cast<size_t>(high.y - low.y + 1);
  const size_t count = countX_ * countY_ * static_cast<size_t>(high.z - low.z + 1);
  if (window_.size() < count) window_.resize(count, 0);
}

int32_t ScanBlocks::findOrAddHashed(const BlockIndex& block)
{
  if (blocks_.size() >= kMaxBlocks && numbers_.count(block) == 0) requireRoom();
  const auto [entry, added] = numbers_.emplace(block, static_cast<int32_t>(blocks_.size()));
  if (added) blocks_.push_back(block);
  return entry->second;
}

void ScanBlocks::refuse()
{
  throw std::length_error(
      "a scan reaches more than " + std::to_string(kMaxBlocks) +
      " blocks with edges of 8 cells: its rays are too long for cells of this size; set maxRange, or a "
      "larger resolution");
}

}  // namespace lamap
