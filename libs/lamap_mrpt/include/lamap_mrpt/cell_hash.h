#pragma once

#include <lamap_core/block_grid.h>
#include <lamap_core/cell.h>

namespace lamap
{
/// For hash maps over cells.
struct CellIndexHash
{
  [[nodiscard]] size_t operator()(const CellIndex& cell) const noexcept
  {
    return BlockIndexHash()({cell.x, cell.y, cell.z});
  }
};

}  // namespace lamap
