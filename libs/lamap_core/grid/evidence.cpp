#include <lamap_core/grid/evidence.h>

#include <algorithm>
#include <utility>

namespace lamap
{
Evidence::Evidence(const Evidence& other) : shape_(other.shape_), kind_(other.kind_), extent_(other.extent_)
{
  blocks_.reserve(other.blocks_.size());
  for (const auto& [index, block] : other.blocks_)
    blocks_.emplace(index, std::make_unique<EvidenceBlock>(*block));
}

Evidence& Evidence::operator=(const Evidence& other)
{
  if (this != &other) *this = Evidence(other);
  return *this;
}

EvidenceBlock& Evidence::findOrCreate(const BlockIndex& index)
{
  const auto found = blocks_.find(index);
  if (found != blocks_.end()) return *found->second;
  return *blocks_.emplace(index, std::make_unique<EvidenceBlock>()).first->second;
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
  size_t bytes = blocks_.bucket_count() * (sizeof(std::pair<BlockIndex, std::unique_ptr<EvidenceBlock>>) + 8);
  for (const auto& [index, block] : blocks_) bytes += block->memoryBytes();
  return bytes + (extent_ ? extent_->memoryBytes() : 0);
}

bool operator==(const Evidence& a, const Evidence& b)
{
  if (!(a.shape_ == b.shape_) || a.kind_ != b.kind_ || a.blockCount() != b.blockCount()) return false;
  return std::all_of(a.blocks_.begin(), a.blocks_.end(),
                     [&](const auto& entry)
                     {
                       const EvidenceBlock& own = *entry.second;
                       const EvidenceBlock* other = b.find(entry.first);
                       return other != nullptr && own.wide() == other->wide() &&
                              own.pruned() == other->pruned() && own.words() == other->words();
                     });
}

}  // namespace lamap
