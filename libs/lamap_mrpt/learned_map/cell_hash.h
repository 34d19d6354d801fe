#pragma once

#include <lamap_core/grid/cell.h>
#include <lamap_core/grid/evidence.h>

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
