#pragma once

#include <lamap_core/features/lattice.h>
#include <lamap_core/hilbert/options.h>

#include <optional>
#include <utility>
#include <vector>

namespace lamap
{
/// Which cells of a map the sites of its lattice may reach.
class ReachedCells
{
 public:
  ReachedCells(const HilbertStructure& structure, const HilbertLattice<SitePosterior>& lattice)
      : structure_(structure), lattice_(lattice)
  {
  }

  /// First and last cell of a box that holds all of them; nothing if there are none.
  [[nodiscard]] std::optional<std::pair<CellIndex, CellIndex>> bounds() const;
  /// Blocks of 8³ cells (8² in a planar map) that may hold one, sorted.
  [[nodiscard]] std::vector<BlockIndex> blocks() const;

 private:
  /// All cells that sites in a box may reach.
  [[nodiscard]] std::pair<CellIndex, CellIndex> cellsNear(const CellIndex& low, const CellIndex& high) const;

  const HilbertStructure& structure_;
  const HilbertLattice<SitePosterior>& lattice_;
};

}  // namespace lamap
