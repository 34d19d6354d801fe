#include <lamap_core/grid/cell_extent.h>

namespace lamap
{
namespace
{
std::array<int32_t, 3> along(const BlockIndex& block)
{
  return {block.x, block.y, block.z};
}

template <typename Visit>
void forEachBit(uint32_t bits, Visit&& visit)
{
  for (; bits != 0; bits &= bits - 1) visit(static_cast<size_t>(__builtin_ctz(bits)));
}
}  // namespace

void CellExtent::grow(const BlockIndex& block, const BlockLayers& before, const BlockLayers& after)
{
  if (before == after) return;
  const std::array<int32_t, 3> indices = along(block);
  size_t grown = 0;
  try
  {
    for (; grown < 3; ++grown)
    {
      const uint32_t added = after[grown] & ~before[grown];
      if (added == 0) continue;
      Slab& slab = slabs_[grown][indices[grown]];
      forEachBit(added,
                 [&](size_t layer)
                 {
                   ++slab.blocks[layer];
                   ++slab.sum;
                 });
    }
    if (before == BlockLayers{}) cubes_.add(shape_.firstCellOf(block));
  }
  catch (...)
  {
    while (grown-- > 0) takeOut(slabs_[grown], indices[grown], after[grown] & ~before[grown]);
    throw;
  }
}

void CellExtent::shrink(const BlockIndex& block, const BlockLayers& before, const BlockLayers& after) noexcept
{
  if (before == after) return;
  const std::array<int32_t, 3> indices = along(block);
  for (size_t axis = 0; axis < 3; ++axis) takeOut(slabs_[axis], indices[axis], before[axis] & ~after[axis]);
  if (after == BlockLayers{}) cubes_.remove(shape_.firstCellOf(block));
}

void CellExtent::takeOut(Slabs& slabs, int32_t index, uint32_t layers) noexcept
{
  if (layers == 0) return;
  const auto slab = slabs.find(index);
  forEachBit(layers,
             [&](size_t layer)
             {
               --slab->second.blocks[layer];
               --slab->second.sum;
             });
  if (slab->second.sum == 0) slabs.erase(slab);
}

std::optional<std::pair<CellIndex, CellIndex>> CellExtent::bounds() const
{
  if (slabs_[0].empty()) return std::nullopt;
  std::array<int32_t, 3> low{};
  std::array<int32_t, 3> high{};
  for (size_t axis = 0; axis < 3; ++axis)
  {
    const auto& [first, firstSlab] = *slabs_[axis].begin();
    const auto& [last, lastSlab] = *slabs_[axis].rbegin();
    int32_t layer = 0;
    while (firstSlab.blocks[static_cast<size_t>(layer)] == 0) ++layer;
    low[axis] = first * edgeAlong(axis) + layer;
    layer = kMostBlockEdge - 1;
    while (lastSlab.blocks[static_cast<size_t>(layer)] == 0) --layer;
    high[axis] = last * edgeAlong(axis) + layer;
  }
  return std::make_pair(CellIndex{low[0], low[1], low[2]}, CellIndex{high[0], high[1], high[2]});
}

size_t CellExtent::memoryBytes() const
{
  constexpr size_t kNode = 4 * sizeof(void*);  // of a tree, beside what it holds
  size_t bytes = cubes_.memoryBytes();
  for (const Slabs& slabs : slabs_) bytes += slabs.size() * (kNode + sizeof(Slabs::value_type));
  return bytes;
}

}  // namespace lamap
