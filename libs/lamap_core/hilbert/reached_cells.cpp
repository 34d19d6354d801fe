#include <lamap_core/hilbert/reached_cells.h>

#include <tsl/robin_set.h>

#include <algorithm>
#include <cmath>

namespace lamap
{
namespace
{
constexpr int kBits = kScanBlockLog2Edge;
constexpr int kEdge = kScanBlockEdge;

/// All cells that sites in a box may reach.
std::pair<CellIndex, CellIndex> cellsNear(const HilbertStructure& structure, const CellIndex& low,
                                          const CellIndex& high)
{
  // With a site's width more than the support, because Nyström's reach is counted in sites.
  const double reach = structure.kernel().support_m() + structure.latticeSpacing;
  const auto cell = [&](int32_t site, int end, double by)
  {
    const double place = (static_cast<double>(site) + end) * structure.latticeSpacing + by;
    return heldCell(place / structure.resolution);
  };
  const auto layer = structure.planarLayer();
  return {{cell(low.x, 0, -reach), cell(low.y, 0, -reach), layer ? *layer : cell(low.z, 0, -reach)},
          {cell(high.x, 1, reach), cell(high.y, 1, reach), layer ? *layer : cell(high.z, 1, reach)}};
}

}  // namespace

std::pair<CellIndex, CellIndex> cellsNearBlocks(const HilbertStructure& structure, const BlockIndex& low,
                                                const BlockIndex& high)
{
  constexpr int32_t kLast = kEdge - 1;
  return cellsNear(structure, {low.x * kEdge, low.y * kEdge, low.z * kEdge},
                   {high.x * kEdge + kLast, high.y * kEdge + kLast, high.z * kEdge + kLast});
}

std::vector<BlockIndex> ReachedCells::blocks() const
{
  tsl::robin_set<BlockIndex, BlockIndexHash> found;
  for (const BlockIndex& index : lattice_.sortedBlocks())
  {
    const SiteSet::Bits bits = lattice_.bitsOf(index);
    CellIndex low{kEdge, kEdge, kEdge};
    CellIndex high{-1, -1, -1};
    for (int32_t z = 0; z < kEdge; ++z)
      for (uint64_t rest = bits[static_cast<size_t>(z)]; rest != 0; rest &= rest - 1)
      {
        const int bit = __builtin_ctzll(rest);
        low = {std::min(low.x, bit % kEdge), std::min(low.y, bit / kEdge), std::min(low.z, z)};
        high = {std::max(high.x, bit % kEdge), std::max(high.y, bit / kEdge), std::max(high.z, z)};
      }
    const auto [first, last] =
        cellsNear(structure_, {index.x * kEdge + low.x, index.y * kEdge + low.y, index.z * kEdge + low.z},
                  {index.x * kEdge + high.x, index.y * kEdge + high.y, index.z * kEdge + high.z});
    const int bitsZ = structure_.planar ? 0 : kBits;
    for (int32_t z = first.z >> bitsZ; z <= last.z >> bitsZ; ++z)
      for (int32_t y = first.y >> kBits; y <= last.y >> kBits; ++y)
        for (int32_t x = first.x >> kBits; x <= last.x >> kBits; ++x) found.insert({x, y, z});
  }
  std::vector<BlockIndex> blocks(found.begin(), found.end());
  std::sort(blocks.begin(), blocks.end());
  return blocks;
}

std::optional<std::pair<CellIndex, CellIndex>> ReachedCells::bounds() const
{
  const std::vector<BlockIndex> blocks = lattice_.sortedBlocks();
  if (blocks.empty()) return std::nullopt;
  BlockIndex low = blocks.front();
  BlockIndex high = low;
  for (const BlockIndex& block : blocks)
  {
    low = {std::min(low.x, block.x), std::min(low.y, block.y), std::min(low.z, block.z)};
    high = {std::max(high.x, block.x), std::max(high.y, block.y), std::max(high.z, block.z)};
  }
  auto [first, last] = cellsNearBlocks(structure_, low, high);
  constexpr int32_t kInBlock = kEdge - 1;
  first = {first.x & ~kInBlock, first.y & ~kInBlock, structure_.planar ? first.z : first.z & ~kInBlock};
  last = {last.x | kInBlock, last.y | kInBlock, structure_.planar ? last.z : last.z | kInBlock};
  return std::make_pair(first, last);
}

}  // namespace lamap
