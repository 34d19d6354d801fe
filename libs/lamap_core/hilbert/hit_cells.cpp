#include <lamap_core/hilbert/hit_cells.h>

#include <lamap_core/grid/block_lists.h>
#include <lamap_core/scan/lattice_frame.h>

#include <algorithm>
#include <utility>

namespace lamap
{
namespace
{
constexpr int kEdge = kScanBlockEdge;
constexpr uint8_t kMostVotes = 255;

CellIndex plus(const CellIndex& a, const CellIndex& b)
{
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}

void raiseTo(uint8_t votes, ReachedLogodds& said)
{
  if (votes > 0 && said.reached) said.logodds = std::max(said.logodds, votes > 1 ? 1.0f : 0.0f);
}

}  // namespace

void HitCells::makeRoomFor(const TrainingSet& scan, const CellIndex& anchor)
{
  scan.forEachCell(&BlockMasks::ended,
                   [&](const CellIndex& local)
                   {
                     const CellIndex cell = plus(anchor, local);
                     SiteSet::Bits bits{};
                     const uint32_t offset = SiteSet::offsetOf(cell);
                     bits[offset / 64] = uint64_t{1} << (offset % 64);
                     votes_.addSites(SiteSet::blockOf(cell), bits, 0);
                   });
}

void HitCells::count(const TrainingSet& scan, const CellIndex& anchor)
{
  takeVotes(scan, anchor);
  scan.forEachCell(&BlockMasks::ended,
                   [&](const CellIndex& local)
                   {
                     uint8_t& votes = *votes_.find(plus(anchor, local));
                     if (votes < kMostVotes) ++votes;
                   });
}

/// The block and its neighbours towards higher indices, x first; null where there is none.
HitCells::Around HitCells::blocksAround(const BlockIndex& low)
{
  Around blocks{};
  for (int i = 0; i < 8; ++i)
    blocks[static_cast<size_t>(i)] =
        votes_.find(BlockIndex{low.x + (i & 1), low.y + (i >> 1 & 1), low.z + (i >> 2)});
  return blocks;
}

void HitCells::takeVotes(const TrainingSet& scan, const CellIndex& anchor)
{
  const CellIndex corner{anchor.x - scan.offset.x, anchor.y - scan.offset.y, anchor.z - scan.offset.z};
  for (size_t number = 0; number < scan.masks.size(); ++number)
  {
    const BlockIndex& index = scan.blocks.blocks()[number];
    const CellIndex first{corner.x + index.x * kEdge, corner.y + index.y * kEdge, corner.z + index.z * kEdge};
    const BlockIndex low = SiteSet::blockOf(first);
    const Around blocks = blocksAround(low);
    if (std::all_of(blocks.begin(), blocks.end(), [](const Block* block) { return block == nullptr; }))
      continue;
    const BlockMasks& masks = scan.masks[number];
    for (size_t z = 0; z < kEdge; ++z)
      for (uint64_t rest = scan.freeInLayer(number, z) & ~masks.protectedHit[z]; rest != 0; rest &= rest - 1)
      {
        const int bit = __builtin_ctzll(rest);
        const CellIndex cell{first.x + bit % kEdge, first.y + bit / kEdge, first.z + static_cast<int>(z)};
        const BlockIndex in = SiteSet::blockOf(cell);
        Block* block = blocks[static_cast<size_t>((in.x - low.x) + 2 * (in.y - low.y) + 4 * (in.z - low.z))];
        const uint32_t offset = SiteSet::offsetOf(cell);
        if (block == nullptr || !block->has(offset)) continue;
        uint8_t& votes = block->weights[block->placeOf(offset)];
        if (votes > 0) --votes;
      }
  }
}

void HitCells::raise(const CellIndex& cell, ReachedLogodds& said) const
{
  if (const uint8_t* votes = votes_.find(cell)) raiseTo(*votes, said);
}

void HitCells::raise(const CellIndex& first, const std::array<int, 3>& counts,
                     std::vector<ReachedLogodds>& said) const
{
  const auto raiseBlock = [&](const BlockIndex& index, const Block& block)
  {
    size_t place = 0;
    SiteBits::forEach(block.bits, index,
                      [&](const CellIndex& cell)
                      {
                        const uint8_t votes = block.weights[place++];
                        const int x = cell.x - first.x;
                        const int y = cell.y - first.y;
                        const int z = cell.z - first.z;
                        const bool isInside =
                            x >= 0 && x < counts[0] && y >= 0 && y < counts[1] && z >= 0 && z < counts[2];
                        if (isInside)
                          raiseTo(votes, said[static_cast<size_t>((z * counts[1] + y) * counts[0] + x)]);
                      });
  };
  const CellIndex last{first.x + counts[0] - 1, first.y + counts[1] - 1, first.z + counts[2] - 1};
  forEachBlock(SiteSet::blockOf(first), SiteSet::blockOf(last),
               [&](const BlockIndex& index)
               {
                 if (const Block* block = votes_.find(index)) raiseBlock(index, *block);
               });
}

void HitCells::save(HilbertState& state) const
{
  for (const BlockIndex& index : votes_.sortedBlocks())
  {
    const auto& block = *votes_.find(index);
    HilbertState::HitBlock kept{index, {}, {}};
    for (uint32_t offset = 0; offset < kScanBlockCells; ++offset)
    {
      if (!block.has(offset)) continue;
      const uint8_t votes = block.weights[block.placeOf(offset)];
      if (votes == 0) continue;
      kept.bits[offset / 64] |= uint64_t{1} << (offset % 64);
      kept.votes.push_back(votes);
    }
    if (!kept.votes.empty()) state.hits.push_back(std::move(kept));
  }
}

void HitCells::restore(const HilbertState& state, const HilbertStructure& structure)
{
  const auto isOfTheMap = [&](const CellIndex& cell)
  {
    const bool inLayer = !structure.planar || cell.z == *structure.planarLayer();
    return inLayer &&
           HilbertFrame::atCell(cell, structure.resolution, structure.latticeSpacing, structure.planar)
               .has_value();
  };
  votes_.clear();
  const BlockIndex* last = nullptr;
  for (const HilbertState::HitBlock& block : state.hits)
  {
    HilbertState::require(last == nullptr || *last < block.index, "blocks of hits are not in their order");
    last = &block.index;
    size_t count = 0;
    bool allOfTheMap = true;
    SiteBits::forEach(block.bits, block.index,
                      [&](const CellIndex& cell)
                      {
                        ++count;
                        allOfTheMap = allOfTheMap && isOfTheMap(cell);
                      });
    HilbertState::require(allOfTheMap, "a hit beyond what can be addressed, or beside the plane");
    HilbertState::require(count > 0 && count == block.votes.size(),
                          "a block does not have votes for each of its hits");
    HilbertState::require(
        std::all_of(block.votes.begin(), block.votes.end(), [](uint8_t votes) { return votes > 0; }),
        "a hit without votes");
    votes_.put(block.index, {{block.bits, {}}, block.votes});
  }
}

}  // namespace lamap
