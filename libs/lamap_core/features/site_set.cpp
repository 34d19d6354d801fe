#include <lamap_core/features/site_set.h>

#include <algorithm>
#include <numeric>

namespace lamap
{
namespace
{
constexpr uint64_t kFirstColumn = 0x0101010101010101;
constexpr uint64_t kLastColumn = 0x8080808080808080;
}  // namespace

void SiteSet::reset(const CellIndex& low, const CellIndex& high)
{
  blocks_.reset(blockOf(low), blockOf(high));
  bits_.clear();
}

SiteSet::Bits& SiteSet::bitsOf(const BlockIndex& block)
{
  const auto number = static_cast<size_t>(blocks_.findOrAdd(block));
  if (number >= bits_.size()) bits_.resize(number + 1);
  return bits_[number];
}

void SiteSet::insert(const CellIndex& site)
{
  const uint32_t offset = offsetOf(site);
  bitsOf(blockOf(site))[offset / 64] |= uint64_t{1} << (offset % 64);
}

void SiteSet::insert(const BlockIndex& block, const Bits& bits)
{
  Bits& own = bitsOf(block);
  for (size_t z = 0; z < bits.size(); ++z) own[z] |= bits[z];
}

bool SiteSet::contains(const CellIndex& site) const
{
  const int32_t number = blocks_.find(blockOf(site));
  if (number < 0) return false;
  const uint32_t offset = offsetOf(site);
  return (bits_[static_cast<size_t>(number)][offset / 64] >> (offset % 64) & 1) != 0;
}

size_t SiteSet::size() const
{
  size_t count = 0;
  for (const Bits& bits : bits_)
    for (const uint64_t word : bits) count += static_cast<size_t>(__builtin_popcountll(word));
  return count;
}

void SiteSet::dilate(int steps, bool flat)
{
  for (int axis = 0; axis < (flat ? 2 : 3); ++axis)
    for (int step = 0; step < steps; ++step) dilateOnce(axis);
}

void SiteSet::dilateOnce(int axis)
{
  const std::vector<Bits> before = bits_;
  const std::vector<BlockIndex> blocksBefore = blocks();
  for (size_t i = 0; i < before.size(); ++i)
  {
    const BlockIndex block = blocksBefore[i];
    Bits below{};  // what goes to the neighbour with the smaller index
    Bits above{};
    Bits& own = bits_[i];
    for (size_t z = 0; z < kScanBlockEdge; ++z)
    {
      const uint64_t word = before[i][z];
      switch (axis)
      {
        case 0:
          own[z] |= (word << 1 & ~kFirstColumn) | (word >> 1 & ~kLastColumn);
          below[z] = (word & kFirstColumn) << 7;
          above[z] = (word & kLastColumn) >> 7;
          break;
        case 1:
          own[z] |= word << 8 | word >> 8;
          below[z] = word << 56;
          above[z] = word >> 56;
          break;
        default:
          if (z > 0)
            own[z - 1] |= word;
          else
            below[kScanBlockEdge - 1] = word;
          if (z + 1 < kScanBlockEdge)
            own[z + 1] |= word;
          else
            above[0] = word;
      }
    }
    const auto neighbour = [&](int by)
    {
      return BlockIndex{block.x + (axis == 0 ? by : 0), block.y + (axis == 1 ? by : 0),
                        block.z + (axis == 2 ? by : 0)};
    };
    const auto any = [](const Bits& bits)
    { return std::any_of(bits.begin(), bits.end(), [](uint64_t word) { return word != 0; }); };
    if (any(below)) insert(neighbour(-1), below);
    if (any(above)) insert(neighbour(1), above);
  }
}

std::vector<size_t> SiteSet::sortedBlocks() const
{
  std::vector<size_t> order(blocks().size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return blocks()[a] < blocks()[b]; });
  return order;
}

void SiteNumbers::reset(const SiteSet& sites, int width)
{
  width_ = width;
  used_.clear();
  sites_.clear();
  const std::vector<BlockIndex>& blocks = sites.blocks();
  numbers_.assign(blocks.size(), {});
  if (blocks.empty())
  {
    blocks_.reset({}, {});
    count_ = static_cast<size_t>(width);
    isUsed_.assign(count_, 0.0f);
    return;
  }
  BlockIndex low = blocks.front();
  BlockIndex high = low;
  for (const BlockIndex& block : blocks)
  {
    low = {std::min(low.x, block.x), std::min(low.y, block.y), std::min(low.z, block.z)};
    high = {std::max(high.x, block.x), std::max(high.y, block.y), std::max(high.z, block.z)};
  }
  blocks_.reset(low, high);
  for (const BlockIndex& block : blocks) (void)blocks_.findOrAdd(block);

  // Before the first and after the last site of a row there are width − 1 numbers that a run may begin or end
  // with.
  int64_t number = -1;
  CellIndex last;
  sites.forEachSorted(
      [&](const CellIndex& site)
      {
        const bool sameRow = number >= 0 && site.y == last.y && site.z == last.z;
        number += sameRow ? std::min<int64_t>(int64_t{site.x} - last.x, width) : width;
        last = site;
        const auto block = static_cast<size_t>(blocks_.find(SiteSet::blockOf(site)));
        numbers_[block][SiteSet::offsetOf(site)] = static_cast<uint32_t>(number) + 1;
        used_.push_back(static_cast<uint32_t>(number));
        sites_.push_back(site);
      });
  count_ = static_cast<size_t>(number + 1 + width);
  isUsed_.assign(count_, 0.0f);
  for (const uint32_t used : used_) isUsed_[used] = 1.0f;
}

}  // namespace lamap
