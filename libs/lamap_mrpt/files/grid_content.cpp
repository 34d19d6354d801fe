#include <lamap_mrpt/files/grid_content.h>

#include <lamap_mrpt/files/content_parts.h>

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace lamap
{
namespace
{
constexpr uint8_t kWide = 1;
constexpr uint8_t kPruned = 2;

/// Whether cells that a file may hold are found at these block indices along an axis.
bool fits(int32_t block, int log2Edge)
{
  const int64_t first = int64_t{block} * (int64_t{1} << log2Edge);
  const int64_t last = first + (int64_t{1} << log2Edge) - 1;
  return first >= -kLastCell && last <= kLastCell;
}

void requirePlace(const Evidence& grid, std::optional<int32_t> planarLayer, const BlockIndex& index,
                  const ByteReader& in)
{
  const int bits = grid.shape().log2Edge();
  const bool isPlace = fits(index.x, bits) && fits(index.y, bits) &&
                       (planarLayer ? index.z == *planarLayer : fits(index.z, bits));
  if (!isPlace)
    in.fail("block (" + std::to_string(index.x) + ", " + std::to_string(index.y) + ", " +
            std::to_string(index.z) + ") is not a place of this map");
}
}  // namespace

void writeGrid(const Evidence& grid, ByteWriter& out)
{
  const std::vector<BlockIndex> blocks = grid.sortedBlocks();
  out.number<uint64_t>(blocks.size());
  for (const BlockIndex& index : blocks)
  {
    const EvidenceBlock& block = *grid.find(index);
    writeIndex(index, out);
    out.number(static_cast<uint8_t>((block.wide() ? kWide : 0) | (block.pruned() ? kPruned : 0)));
    out.vector(block.words(grid.shape()));
  }
}

Evidence readGrid(const Evidence& like, std::optional<int32_t> planarLayer, ByteReader& in)
{
  Evidence grid(like.shape(), like.kind());
  constexpr size_t kLeastBytesOfBlock = kIndexBytes + 1 + sizeof(uint64_t);
  const auto count = in.number<uint64_t>();
  in.requireElements(count, kLeastBytesOfBlock);
  std::optional<BlockIndex> last;
  for (uint64_t i = 0; i < count; ++i)
  {
    const auto index = readIndex<BlockIndex>(in);
    requirePlace(grid, planarLayer, index, in);
    if (last && !(*last < index)) in.fail("blocks are not in their order");
    last = index;
    const auto flags = in.number<uint8_t>();
    if (flags > (kWide | kPruned)) in.fail("a block has unknown flags");
    const std::vector<uint64_t> words = in.vector<uint64_t>();
    try
    {
      grid.findOrCreate(index) = EvidenceBlock::fromWords(grid.shape(), grid.kind(), (flags & kWide) != 0,
                                                          (flags & kPruned) != 0, words);
    }
    catch (const std::runtime_error& error)
    {
      in.fail(error.what());
    }
  }
  return grid;
}

}  // namespace lamap
