#include <lamap_core/hilbert/seen_cells.h>

#include <lamap_core/grid/block_lists.h>
#include <lamap_core/math/portable_math.h>
#include <lamap_core/scan/lattice_frame.h>
#include <tsl/robin_map.h>

#include <algorithm>
#include <utility>

namespace lamap
{
namespace
{
constexpr int kEdge = kScanBlockEdge;

/// Hits and passes of a cell, in units of a scan.
struct CellScans
{
  explicit CellScans(uint16_t code) : hits(code & 0xFF), passes(code >> 8) {}
  CellScans(uint8_t ofHits, uint8_t ofPasses) : hits(ofHits), passes(ofPasses) {}

  [[nodiscard]] uint16_t code() const { return static_cast<uint16_t>(passes << 8 | hits); }
  void add(bool isHit)
  {
    constexpr int kMost = SeenCells::kScansKept;
    const auto fade = [](int& units) { units -= (units + kMost - 1) / kMost; };
    if (hits + passes >= kMost * SeenCells::kUnits)
    {
      fade(hits);
      fade(passes);
    }
    (isHit ? hits : passes) += SeenCells::kUnits;
  }

  int hits;
  int passes;
};

void addScans(uint16_t code, ReachedLogodds& said)
{
  if (code == 0 || !said.reached) return;
  const CellScans scans(code);
  const double hits = SeenCells::kHitWeight / SeenCells::kUnits * scans.hits;
  const double passes = 1.0 / SeenCells::kUnits * scans.passes;
  const double repeats = std::max(0.0, 1.0 / SeenCells::kUnits * (scans.hits + scans.passes) - 1);
  const double share = 1 / (1 + SeenCells::kCorrelation * repeats);
  constexpr double kSurest = 50.0;  // far beyond what a float of a probability tells from 0 or 1
  const double model = std::clamp(static_cast<double>(said.logodds), -kSurest, kSurest);
  const double occupied = SeenCells::kPriorScans * logistic(model) + share * hits;
  const double free = SeenCells::kPriorScans * logistic(-model) + share * passes;
  said.logodds = static_cast<float>(portableLog(occupied / free));
}

/// Calls visit(cell, isHit) for each cell of the map of which a scan says anything, block by block.
template <typename Visit>
void forEachSeen(const TrainingSet& scan, const CellIndex& anchor, const SeenCells::IsCertain& isCertain,
                 const Visit& visit)
{
  const CellIndex corner{anchor.x - scan.offset.x, anchor.y - scan.offset.y, anchor.z - scan.offset.z};
  for (size_t number = 0; number < scan.masks.size(); ++number)
  {
    const BlockIndex& index = scan.blocks.blocks()[number];
    const CellIndex first{corner.x + index.x * kEdge, corner.y + index.y * kEdge, corner.z + index.z * kEdge};
    const BlockMasks& masks = scan.masks[number];
    for (size_t z = 0; z < kEdge; ++z)
    {
      const uint64_t passed = scan.freeInLayer(number, z) & ~masks.protectedHit[z];
      for (uint64_t rest = masks.ended[z] | passed; rest != 0; rest &= rest - 1)
      {
        const int bit = __builtin_ctzll(rest);
        const CellIndex cell{first.x + bit % kEdge, first.y + bit / kEdge, first.z + static_cast<int>(z)};
        if (!isCertain || isCertain(cell)) visit(cell, (masks.ended[z] >> bit & 1) != 0);
      }
    }
  }
}

}  // namespace

void SeenCells::makeRoomFor(const TrainingSet& scan, const CellIndex& anchor, const IsCertain& isCertain)
{
  tsl::robin_map<BlockIndex, SiteSet::Bits, BlockIndexHash> seen;
  BlockIndex last;
  SiteSet::Bits* bits = nullptr;
  forEachSeen(scan, anchor, isCertain,
              [&](const CellIndex& cell, bool /*isHit*/)
              {
                const BlockIndex block = SiteSet::blockOf(cell);
                if (bits == nullptr || !(block == last)) bits = &seen[block];
                last = block;
                const uint32_t offset = SiteSet::offsetOf(cell);
                (*bits)[offset / 64] |= uint64_t{1} << (offset % 64);
              });
  for (const auto& [block, cells] : seen) scans_.addSites(block, cells, 0);
}

void SeenCells::count(const TrainingSet& scan, const CellIndex& anchor, const IsCertain& isCertain)
{
  BlockIndex last;
  HilbertLattice<uint16_t>::Block* block = nullptr;
  forEachSeen(scan, anchor, isCertain,
              [&](const CellIndex& cell, bool isHit)
              {
                const BlockIndex index = SiteSet::blockOf(cell);
                if (block == nullptr || !(index == last)) block = scans_.find(index);
                last = index;
                uint16_t& code = block->weights[block->placeOf(SiteSet::offsetOf(cell))];
                CellScans scans(code);
                scans.add(isHit);
                code = scans.code();
              });
}

void SeenCells::addTo(const CellIndex& cell, ReachedLogodds& said) const
{
  if (const uint16_t* code = scans_.find(cell)) addScans(*code, said);
}

void SeenCells::addTo(const CellIndex& first, const std::array<int, 3>& counts,
                      std::vector<ReachedLogodds>& said) const
{
  const auto addBlock = [&](const BlockIndex& index, const HilbertLattice<uint16_t>::Block& block)
  {
    size_t place = 0;
    SiteBits::forEach(block.bits, index,
                      [&](const CellIndex& cell)
                      {
                        const uint16_t code = block.weights[place++];
                        const int x = cell.x - first.x;
                        const int y = cell.y - first.y;
                        const int z = cell.z - first.z;
                        const bool isInside =
                            x >= 0 && x < counts[0] && y >= 0 && y < counts[1] && z >= 0 && z < counts[2];
                        if (isInside)
                          addScans(code, said[static_cast<size_t>((z * counts[1] + y) * counts[0] + x)]);
                      });
  };
  const CellIndex last{first.x + counts[0] - 1, first.y + counts[1] - 1, first.z + counts[2] - 1};
  forEachBlock(SiteSet::blockOf(first), SiteSet::blockOf(last),
               [&](const BlockIndex& index)
               {
                 if (const auto* block = scans_.find(index)) addBlock(index, *block);
               });
}

void SeenCells::save(HilbertState& state) const
{
  for (const BlockIndex& index : scans_.sortedBlocks())
  {
    const auto& block = *scans_.find(index);
    HilbertState::SeenBlock kept{index, {}, {}, {}};
    for (uint32_t offset = 0; offset < kScanBlockCells; ++offset)
    {
      if (!block.has(offset)) continue;
      const CellScans scans(block.weights[block.placeOf(offset)]);
      if (scans.code() == 0) continue;
      kept.bits[offset / 64] |= uint64_t{1} << (offset % 64);
      kept.hits.push_back(static_cast<uint8_t>(scans.hits));
      kept.passes.push_back(static_cast<uint8_t>(scans.passes));
    }
    if (!kept.hits.empty()) state.seen.push_back(std::move(kept));
  }
}

void SeenCells::restore(const HilbertState& state, const HilbertStructure& structure)
{
  const auto isOfTheMap = [&](const CellIndex& cell)
  {
    const bool inLayer = !structure.planar || cell.z == *structure.planarLayer();
    return inLayer &&
           HilbertFrame::atCell(cell, structure.resolution, structure.latticeSpacing, structure.planar)
               .has_value();
  };
  const auto isLegal = [](uint16_t code)
  {
    const CellScans scans(code);
    return code != 0 && scans.hits + scans.passes < (kScansKept + 1) * kUnits;
  };
  scans_.clear();
  const BlockIndex* last = nullptr;
  for (const HilbertState::SeenBlock& block : state.seen)
  {
    HilbertState::require(last == nullptr || *last < block.index,
                          "blocks of seen cells are not in their order");
    last = &block.index;
    constexpr int32_t kLastBlock = kLastCell / kScanBlockEdge;
    const auto fits = [](int32_t i) { return i >= -kLastBlock && i < kLastBlock; };
    HilbertState::require(fits(block.index.x) && fits(block.index.y) && fits(block.index.z),
                          "a block of seen cells is out of range");
    size_t count = 0;
    bool allOfTheMap = true;
    SiteBits::forEach(block.bits, block.index,
                      [&](const CellIndex& cell)
                      {
                        ++count;
                        allOfTheMap = allOfTheMap && isOfTheMap(cell);
                      });
    HilbertState::require(allOfTheMap, "a seen cell beyond what can be addressed, or beside the plane");
    HilbertState::require(count > 0 && count == block.hits.size() && count == block.passes.size(),
                          "a block does not have hits and passes for each of its seen cells");
    std::vector<uint16_t> codes;
    codes.reserve(count);
    for (size_t i = 0; i < count; ++i) codes.push_back(CellScans(block.hits[i], block.passes[i]).code());
    HilbertState::require(std::all_of(codes.begin(), codes.end(), isLegal),
                          "a seen cell without scans, or with more than are kept");
    scans_.put(block.index, {{block.bits, {}}, std::move(codes)});
  }
}

}  // namespace lamap
