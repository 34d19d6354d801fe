#include <lamap_core/grid/block_grid.h>

#include <algorithm>

namespace lamap
{
BlockGrid::BlockGrid(const BlockGrid& other) : shape_(other.shape_)
{
  blocks_.reserve(other.blocks_.size());
  for (const auto& [index, block] : other.blocks_)
    blocks_.emplace(index, std::make_unique<EvidenceBlock>(*block));
}

BlockGrid& BlockGrid::operator=(const BlockGrid& other)
{
  if (this != &other) *this = BlockGrid(other);
  return *this;
}

EvidenceBlock& BlockGrid::findOrCreate(const BlockIndex& index)
{
  const auto found = blocks_.find(index);
  if (found != blocks_.end()) return *found->second;
  return *blocks_.emplace(index, std::make_unique<EvidenceBlock>()).first->second;
}

std::vector<BlockIndex> BlockGrid::sortedBlocks() const
{
  std::vector<BlockIndex> indices;
  indices.reserve(blocks_.size());
  for (const auto& [index, block] : blocks_) indices.push_back(index);
  std::sort(indices.begin(), indices.end());
  return indices;
}

size_t BlockGrid::memoryBytes() const
{
  // A slot of the open-addressing table holds the pair and its probe distance.
  size_t bytes = blocks_.bucket_count() * (sizeof(std::pair<BlockIndex, std::unique_ptr<EvidenceBlock>>) + 8);
  for (const auto& [index, block] : blocks_) bytes += block->memoryBytes();
  return bytes;
}

}  // namespace lamap
