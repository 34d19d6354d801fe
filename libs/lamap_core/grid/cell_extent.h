#pragma once

#include <lamap_core/grid/cell.h>
#include <lamap_core/grid/cell_cubes.h>
#include <lamap_core/grid/evidence_block.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>

namespace lamap
{
/** Where the cells of a sparse grid are: the box of them all, and the empty space around them. Told of each
 * block that changes, so that nobody need walk the cells.
 *
 * Along each axis it counts, for every layer of cells, the blocks that have a cell there.
 *
 * Thread guarantee: const methods may be called from several threads. */
class CellExtent
{
 public:
  explicit CellExtent(const BlockShape& shape) : shape_(shape) {}

  /** A block has cells in more layers than before. If it throws, nothing is changed.
   * @param before what the block had, empty for one that is new; @param after all of it, and more */
  void grow(const BlockIndex& block, const BlockLayers& before, const BlockLayers& after);
  /// A block has cells in fewer layers than before. @param after empty for a block that is gone
  void shrink(const BlockIndex& block, const BlockLayers& before, const BlockLayers& after) noexcept;

  /// The smallest and the largest index of the cells along each axis; nothing if there are none.
  [[nodiscard]] std::optional<std::pair<CellIndex, CellIndex>> bounds() const;
  /// As CellCubes::emptyAround(), of the blocks that have cells.
  [[nodiscard]] int emptyAround(const CellIndex& cell) const { return cubes_.emptyAround(cell); }

  [[nodiscard]] size_t memoryBytes() const;

 private:
  /// The blocks with one index along an axis: how many of them have a cell in each layer.
  struct Slab
  {
    std::array<uint32_t, kMostBlockEdge> blocks{};
    uint32_t sum = 0;
  };
  using Slabs = std::map<int32_t, Slab>;

  /// Number of cells from the index of a block to the next along an axis.
  [[nodiscard]] int32_t edgeAlong(size_t axis) const
  {
    return shape_.planar() && axis == 2 ? 1 : shape_.edge();
  }
  static void takeOut(Slabs& slabs, int32_t index, uint32_t layers) noexcept;

  BlockShape shape_;
  std::array<Slabs, 3> slabs_;
  CellCubes cubes_;
};

}  // namespace lamap
