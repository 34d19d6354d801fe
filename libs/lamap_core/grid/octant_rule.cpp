#include <lamap_core/grid/octant_rule.h>

namespace lamap
{
bool mergeEqual(const DenseBlock& block, uint32_t first, uint32_t count, CellSums& merged)
{
  merged = block.at(first);
  for (uint32_t i = first + 1; i < first + count; ++i)
  {
    if (!(block.at(i) == merged)) return false;
  }
  return true;
}

}  // namespace lamap
