#include <lamap_core/grid/cell_cubes.h>

namespace lamap
{
namespace
{
BlockIndex cubeOf(const CellIndex& cell, int level)
{
  return {cell.x >> level, cell.y >> level, cell.z >> level};
}

/// Is no cube beside a cube among the keys, nor the cube itself?
template <typename Cubes>
bool isEmptyAround(const Cubes& cubes, const BlockIndex& cube)
{
  if (cubes.count(cube) > 0) return false;  // in a map, nearly always
  for (int32_t z = cube.z - 1; z <= cube.z + 1; ++z)
    for (int32_t y = cube.y - 1; y <= cube.y + 1; ++y)
      for (int32_t x = cube.x - 1; x <= cube.x + 1; ++x)
        if (cubes.count({x, y, z}) > 0) return false;
  return true;
}
}  // namespace

void CellCubes::add(const CellIndex& cell)
{
  size_t level = 0;
  try
  {
    for (; level < kLevels.size(); ++level)
      if (counts_[level][cubeOf(cell, kLevels[level])]++ > 0) return;
  }
  catch (...)
  {
    removeBelow(level, cell);
    throw;
  }
}

void CellCubes::remove(const CellIndex& cell) noexcept
{
  removeBelow(kLevels.size(), cell);
}

void CellCubes::removeBelow(size_t level, const CellIndex& cell) noexcept
{
  for (size_t i = 0; i < level; ++i)
  {
    const auto found = counts_[i].find(cubeOf(cell, kLevels[i]));
    if (--found.value() > 0) return;
    counts_[i].erase(found);
  }
}

void CellCubes::clear()
{
  for (Counts& counts : counts_) counts.clear();
}

int CellCubes::emptyAround(const CellIndex& cell) const
{
  int empty = 0;
  for (size_t i = 0; i < kLevels.size(); ++i)
  {
    if (!isEmptyAround(counts_[i], cubeOf(cell, kLevels[i]))) return empty;
    empty = kLevels[i];
  }
  return empty;
}

size_t CellCubes::memoryBytes() const
{
  size_t bytes = 0;
  for (const Counts& counts : counts_)
    bytes += counts.bucket_count() * (sizeof(std::pair<BlockIndex, uint32_t>) + 8);
  return bytes;
}

}  // namespace lamap
