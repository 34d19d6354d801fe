#pragma once

#include <lamap_core/grid/evidence.h>
#include <lamap_core/grid/evidence_block.h>

#include <functional>

namespace lamap
{
/// When the cells of an octant are stored once (test-data octrees, thesis 4.2.3).
enum class Pruning
{
  None,      ///< never: each cell is stored by itself
  Lossless,  ///< where their evidence is equal
  State      ///< where their state is equal; the octant stores their mean evidence (thesis)
};

/// How the octants of one block of the map are merged.
struct OctantRule
{
  Pruning pruning = Pruning::None;
  OctantMerger merger;  ///< empty for Pruning::None
};
using RuleForBlock = std::function<OctantRule(const BlockIndex& block)>;

/// Pruning::Lossless: merges an octant whose cells have equal evidence.
[[nodiscard]] bool mergeEqual(const DenseBlock& block, uint32_t first, uint32_t count, CellSums& merged);

/** Pruning::State: merges an octant whose cells have one state into their mean evidence, if that changes no
 * cell's state.
 * @param meanOf(cells, count, merged) sets the mean evidence of cells; false if there is none
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
