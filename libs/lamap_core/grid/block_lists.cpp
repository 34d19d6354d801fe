#include <lamap_core/grid/block_lists.h>

namespace lamap
{
void BlockLists::sort(size_t blockCount)
{
  begins_.assign(blockCount + 1, 0);
  for (const Entry& entry : entries_) ++begins_[static_cast<size_t>(entry.block) + 1];
  for (size_t block = 0; block < blockCount; ++block) begins_[block + 1] += begins_[block];
  items_.resize(entries_.size());
  std::vector<uint32_t> next(begins_.begin(), begins_.end() - 1);
  for (const Entry& entry : entries_) items_[next[static_cast<size_t>(entry.block)]++] = entry.item;
}

}  // namespace lamap
