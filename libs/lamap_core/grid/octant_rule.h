#pragma once

#include <lamap_core/grid/evidence.h>
#include <lamap_core/grid/evidence_block.h>

#include <functional>

namespace lamap
{
/// How a block holds cells that agree (test-data octrees, thesis 4.2.3).
enum class Pruning
{
  None,      ///< each cell by itself
  Lossless,  ///< cells of an octant are held once where their evidence is equal
  State  ///< cells of an octant are held once, with their mean evidence, where their state is equal (thesis)
};

/// How octants of one block of the map are held once.
struct OctantRule
{
  Pruning pruning = Pruning::None;
  OctantMerger merger;  ///< empty for Pruning::None
};
using RuleForBlock = std::function<OctantRule(const BlockIndex& block)>;

/// Pruning::Lossless: an octant is held once where its cells' evidence is equal.
[[nodiscard]] bool mergeEqual(const DenseBlock& block, uint32_t first, uint32_t count, CellSums& merged);

/** Pruning::State: an octant whose cells have one state is held with its mean evidence, if that changes no
 * cell's state.
 * @param meanOf(cells, count, merged) sets the mean evidence of cells, or returns false where there is none
 * @param stateOf(offset, sums) of a cell that has this evidence */
template <typename MeanOf, typename StateOf>
bool mergeSameState(const DenseBlock& block, uint32_t first, uint32_t count, CellSums& merged,
                    MeanOf&& meanOf, StateOf&& stateOf)
{
  const CellState state = stateOf(first, block.at(first));
  for (uint32_t i = first + 1; i < first + count; ++i)
  {
    if (stateOf(i, block.at(i)) != state) return false;
  }
  if (!meanOf(&block.at(first), count, merged)) return false;
  for (uint32_t i = first; i < first + count; ++i)
  {
    if (stateOf(i, merged) != state) return false;
  }
  return true;
}

}  // namespace lamap
