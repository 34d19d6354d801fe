#include <lamap_core/grid/evidence.h>

#include <algorithm>
#include <atomic>
#include <utility>

namespace lamap
{
Evidence& Evidence::operator=(const Evidence& other)
{
  if (this != &other) *this = Evidence(other);
  return *this;
}

EvidenceBlock& Evidence::findOrCreate(const BlockIndex& index)
{
  changes_.add();
  const auto found = blocks_.find(index);
  if (found != blocks_.end()) return ownOf(found.value());
  return *blocks_.emplace(index, std::make_shared<EvidenceBlock>()).first->second;
}

std::shared_ptr<EvidenceBlock> Evidence::take(const BlockIndex& index)
{
  const auto found = blocks_.find(index);
  if (found == blocks_.end()) return nullptr;
  BlockPointer block = std::move(found.value());
  erase(index);
  return block;
}

EvidenceBlock& Evidence::ownOf(BlockPointer& block)
{
  if (block.use_count() > 1)
    block = std::make_shared<EvidenceBlock>(*block);
  else
    std::atomic_thread_fence(std::memory_order_acquire);  // after whoever had it last
  return *block;
}

void Evidence::keepExtent()
{
  CellExtent extent(shape_);
  for (const auto& [index, block] : blocks_) extent.grow(index, {}, block->layers(shape_));
  extent_ = std::move(extent);
}

std::vector<BlockIndex> Evidence::sortedBlocks() const
{
  std::vector<BlockIndex> indices;
  indices.reserve(blocks_.size());
  for (const auto& [index, block] : blocks_) indices.push_back(index);
  std::sort(indices.begin(), indices.end());
  return indices;
}

size_t Evidence::memoryBytes() const
{
  // A slot of the open-addressing table holds the pair and its probe distance.
  size_t bytes = blocks_.bucket_count() * (sizeof(std::pair<BlockIndex, BlockPointer>) + 8);
  for (const auto& [index, block] : blocks_) bytes += block->memoryBytes();
  return bytes + (extent_ ? extent_->memoryBytes() : 0);
}

bool operator==(const Evidence& a, const Evidence& b)
{
  if (!(a.shape_ == b.shape_) || a.kind_ != b.kind_ || a.blockCount() != b.blockCount()) return false;
  return std::all_of(a.blocks_.begin(), a.blocks_.end(),
                     [&](const auto& entry)
                     {
                       const EvidenceBlock* other = b.find(entry.first);
                       return other != nullptr && *entry.second == *other;
                     });
}

}  // namespace lamap
