#pragma once

#include <lamap_core/grid/cell.h>
#include <lamap_core/grid/evidence_block.h>
#include <tsl/robin_map.h>

#include <array>
#include <cstddef>
#include <cstdint>

namespace lamap
{
/** Large cubes around all that has been added, so that a walk may skip the empty space between: two cells of
 * a map may be millions of cells apart.
 *
 * Thread guarantee: const methods may be called from several threads. */
class CellCubes
{
 public:
  /// Larger cubes than these are asked for where these are empty.
  static constexpr int kFinest = 5;

  /// Counts the cube of 2^kFinest cells that holds a cell once more. If it throws, nothing is changed.
  void add(const CellIndex& cell);
  /// Takes back what add() did once for a cell of the same cube.
  void remove(const CellIndex& cell) noexcept;
  void clear();

  /** A cube of 2^n cells around a cell, aligned to its size, is empty, and so are the cubes beside it.
   * @return the largest n that is known, or 0 */
  [[nodiscard]] int emptyAround(const CellIndex& cell) const;

  [[nodiscard]] size_t memoryBytes() const;

 private:
  static constexpr std::array<int, 4> kLevels{kFinest, 11, 17, 23};
  /// By cube: at the finest level how often it was added, above it how many cubes of the level below it
  /// holds.
  using Counts = tsl::robin_map<BlockIndex, uint32_t, BlockIndexHash>;

  void removeBelow(size_t level, const CellIndex& cell) noexcept;

  std::array<Counts, kLevels.size()> counts_;
};

}  // namespace lamap
