#pragma once

#include <lamap_core/bgk/cell_stencil.h>

#include <array>
#include <cstdint>
#include <vector>

namespace lamap
{
/** Sums of a stencil that reaches one cell, as evidence: what CellStencil::addUp() gives, rounded by its
 * scale, in a fraction of the time.
 *
 * With so small a stencil there are few different sums: one for each number of marked cells at each squared
 * distance, 0 to 3. All of them stand in a table, and cells are counted, eight at once, by adding bytes.
 *
 * Immutable: may be shared between threads. */
class EvidenceTable
{
 public:
  /// For each cell of a scan block, at (z·8 + y)·8 + x.
  using BlockEvidence = std::array<uint32_t, kScanBlockCells>;

  /// @param stencil with isTabulable()
  EvidenceTable(const CellStencil& stencil, bool planar);
  /// Whether the stencil reaches one cell, and no sum passes 2^31 as evidence.
  [[nodiscard]] static bool isTabulable(const CellStencil& stencil);

  /// Sets the evidence of the layers that marked cells may reach. @return these layers; the others are
  /// unchanged.
  Layers look(const MaskNeighbourhood& neighbourhood, BlockEvidence& evidence) const;

 private:
  static constexpr size_t kDistances = 4;  ///< squared, in cells²

  struct LayerCounts;
  void lookUpLayer(const LayerCounts& below, const LayerCounts& here, const LayerCounts& above,
                   uint32_t* evidence) const;

  bool planar_;
  std::array<uint16_t, kDistances> strides_{};  ///< place in the table: Σ stride · count
  std::vector<uint32_t> table_;
};

}  // namespace lamap
