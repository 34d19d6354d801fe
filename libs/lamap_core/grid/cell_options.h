#pragma once

#include <lamap_core/grid/cell.h>
#include <lamap_core/grid/octant_rule.h>

#include <cstdint>
#include <optional>

namespace lamap
{
/// The cells of a map; fixed for its life.
struct CellOptions
{
  double resolution = 0.10;   ///< edge of a finest cell [m], from 0.0001 to 10000
  bool planar = false;        ///< one layer of cells, distances in the plane: for 2D sensors
  double planarHeight = 0.0;  ///< [m], in the layer of a planar map

  /// The layer of cells of a planar map.
  [[nodiscard]] std::optional<int32_t> planarLayer() const
  {
    if (!planar) return std::nullopt;
    return heldCell(planarHeight / resolution);
  }
};

/// The cells of a map that holds them in blocks.
struct BlockOptions : public CellOptions
{
  int blockDepth = 4;  ///< a block is 2^(blockDepth−1) cells wide; 2 to 6
  Pruning pruning = Pruning::Lossless;
};

}  // namespace lamap
