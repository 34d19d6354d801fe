#include <lamap_mrpt/bgk_map_content.h>

#include <stdexcept>

namespace lamap
{
namespace
{
constexpr uint8_t kWide = 1;
constexpr uint8_t kPruned = 2;
/// A prior map may have a prior map; a file in which this does not end is not one of ours.
constexpr int kMaxPriorDepth = 16;

void writeBlocks(const BlockGrid& grid, ByteWriter& out)
{
  const std::vector<BlockIndex> blocks = grid.sortedBlocks();
  out.number<uint64_t>(blocks.size());
  for (const BlockIndex& index : blocks)
  {
    const EvidenceBlock& block = *grid.find(index);
    out.number(index.x);
    out.number(index.y);
    out.number(index.z);
    out.number(static_cast<uint8_t>((block.wide() ? kWide : 0) | (block.pruned() ? kPruned : 0)));
    out.vector(block.words());
  }
}

void requirePlace(const BgkMap& map, const BlockIndex& index, const ByteReader& in)
{
  const int bits = map.grid().shape().log2Edge();
  const auto fits = [&](int32_t i)
  {
    return i >= (std::numeric_limits<int32_t>::min() >> bits) &&
           i <= (std::numeric_limits<int32_t>::max() >> bits);
  };
  const bool planar = map.structure().planar;
  if (!fits(index.x) || !fits(index.y) || (planar ? index.z != map.planarLayer() : !fits(index.z)))
    in.fail("block (" + std::to_string(index.x) + ", " + std::to_string(index.y) + ", " +
            std::to_string(index.z) + ") is not a place of this map");
}

void readBlocks(BgkMap& map, ByteReader& in)
{
  constexpr size_t kLeastBytesOfBlock = 3 * sizeof(int32_t) + 1 + sizeof(uint64_t);
  const auto count = in.number<uint64_t>();
  in.requireElements(count, kLeastBytesOfBlock);
  std::optional<BlockIndex> last;
  for (uint64_t i = 0; i < count; ++i)
  {
    BlockIndex index;
    index.x = in.number<int32_t>();
    index.y = in.number<int32_t>();
    index.z = in.number<int32_t>();
    requirePlace(map, index, in);
    if (last && !(*last < index)) in.fail("blocks are not in their order");
    last = index;
    const auto flags = in.number<uint8_t>();
    if (flags > (kWide | kPruned)) in.fail("a block has unknown flags");
    std::vector<uint64_t> words = in.vector<uint64_t>();
    try
    {
      map.grid().findOrCreate(index) = EvidenceBlock::fromWords(map.grid().shape(), (flags & kWide) != 0,
                                                                (flags & kPruned) != 0, std::move(words));
    }
    catch (const std::runtime_error& error)
    {
      in.fail(error.what());
    }
  }
}

BgkMap readAtDepth(CBGKMap::TCreationOptions& options, ByteReader& in, int depth)
{
  if (depth > kMaxPriorDepth) in.fail("prior maps are nested too deep");
  options = {};
  options.read(in);
  try
  {
    options.validate();
    BgkMap map(options);
    readBlocks(map, in);
    if (in.number<bool>())
    {
      CBGKMap::TCreationOptions priorOptions;
      map.setPriorMap(std::make_shared<const BgkMap>(readAtDepth(priorOptions, in, depth + 1)));
    }
    return map;
  }
  catch (const std::invalid_argument& error)
  {
    in.fail(error.what());
  }
}
}  // namespace

void writeBgkMap(const CBGKMap::TCreationOptions& options, const BgkMap& map, ByteWriter& out)
{
  options.write(out);
  writeBlocks(map.grid(), out);
  out.number(map.priorMap() != nullptr);
  if (!map.priorMap()) return;
  CBGKMap::TCreationOptions priorOptions;
  static_cast<BgkStructure&>(priorOptions) = map.priorMap()->structure();
  writeBgkMap(priorOptions, *map.priorMap(), out);
}

BgkMap readBgkMap(CBGKMap::TCreationOptions& options, ByteReader& in)
{
  return readAtDepth(options, in, 0);
}

}  // namespace lamap
