#pragma once

#include <lamap_core/features/lattice.h>
#include <lamap_core/features/logodds.h>
#include <lamap_core/grid/cell.h>
#include <lamap_core/hilbert/options.h>
#include <lamap_core/hilbert/state.h>
#include <lamap_core/training/training_set.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace lamap
{
/** The cells in which rays ended: features are wider than thin things, so the weights alone may call free
 * what every scan hit.
 *
 * A scan in which rays end in a cell gives it a vote; one in which only rays that go on leave a free sample
 * in it takes a vote away. The log-odds of a cell with v > 0 votes are at least min(v − 1, 1): not free with
 * one, P(occupied) = 0.73 with more.
 *
 * Thread guarantee: const methods may be called from several threads. */
class HitCells
{
 public:
  /// Makes room for the votes of a scan, which changes nothing that is said. @param anchor cell of its frame
  void makeRoomFor(const TrainingSet& scan, const CellIndex& anchor);
  /// Counts the votes of a scan that there is room for. Cannot fail.
  void count(const TrainingSet& scan, const CellIndex& anchor);

  /// Raises what the weights say of a cell, if they say anything.
  void raise(const CellIndex& cell, ReachedLogodds& said) const;
  /// The same of the cells in a box, x fastest, then y, then z.
  void raise(const CellIndex& first, const std::array<int, 3>& counts,
             std::vector<ReachedLogodds>& said) const;

  [[nodiscard]] size_t memoryBytes() const { return votes_.memoryBytes(); }

  void save(HilbertState& state) const;
  /// @throws std::invalid_argument saying what is wrong with the state
  void restore(const HilbertState& state, const HilbertStructure& structure);

 private:
  using Block = HilbertLattice<uint8_t>::Block;
  using Around = std::array<Block*, 8>;

  [[nodiscard]] Around blocksAround(const BlockIndex& low);
  void takeVotes(const TrainingSet& scan, const CellIndex& anchor);

  HilbertLattice<uint8_t> votes_;  ///< a cell a site; 0: as if it were none
};

}  // namespace lamap
