#pragma once

#include <lamap_core/features/lattice.h>
#include <lamap_core/hilbert/options.h>

#include <optional>
#include <utility>
#include <vector>

namespace lamap
{
/// First and last cell of a box that holds all cells that sites of blocks in [low, high] may reach.
[[nodiscard]] std::pair<CellIndex, CellIndex> cellsNearBlocks(const HilbertStructure& structure,
                                                              const BlockIndex& low, const BlockIndex& high);

/// Which cells of a map the sites of its lattice may reach.
class ReachedCells
{
 public:
  ReachedCells(const HilbertStructure& structure, const HilbertLattice<SitePosterior>& lattice)
      : structure_(structure), lattice_(lattice)
  {
  }

  /// First and last cell of a box of whole blocks that holds all of them; nothing if there are none.
  [[nodiscard]] std::optional<std::pair<CellIndex, CellIndex>> bounds() const;
  /// Blocks of 8³ cells (8² in a planar map) that may hold one, sorted.
  [[nodiscard]] std::vector<BlockIndex> blocks() const;

 private:
  const HilbertStructure& structure_;
  const HilbertLattice<SitePosterior>& lattice_;
};

}  // namespace lamap
