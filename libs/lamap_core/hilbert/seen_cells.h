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
#include <functional>
#include <vector>

namespace lamap
{
/** What the rays of each cell said by themselves: features are wider than thin things and than what moves, so
 * the weights alone may call free what every scan hit, and occupied what rays pass.
 *
 * A scan in which rays end in a cell is a hit of it; one in which rays only leave free samples in it is a
 * pass. The model's P(occupied) is the mean of a beta prior worth kPriorScans, hits and passes are
 * observations:
 *
 *   P = (k·p + s·w·hits) / (k + s·(w·hits + passes)),  s = 1 / (1 + ρ·max(0, hits + passes − 1))
 *
 * with w = kHitWeight. Scans of a cell are correlated, because poses and surfaces are the same: n of them
 * count as n/(1 + ρ(n − 1)), the size of a sample from clusters with a correlation of ρ = kCorrelation
 * within. Only about the last kScansKept scans count, so that a cell follows what changes.
 *
 * Thread guarantee: const methods may be called from several threads. */
class SeenCells
{
 public:
  static constexpr double kPriorScans = 2;
  static constexpr double kHitWeight = 1.5;
  static constexpr double kCorrelation = 0.1;
  static constexpr int kScansKept = 31;
  static constexpr int kUnits = 8;  ///< of a scan, in what is kept
  /// Whether a cell of the map is where a scan says.
  using IsCertain = std::function<bool(const CellIndex&)>;

  /// Makes room for a scan, which changes nothing that is said. @param anchor cell of its frame
  void makeRoomFor(const TrainingSet& scan, const CellIndex& anchor, const IsCertain& isCertain);
  /// Counts a scan that there is room for. Cannot fail.
  void count(const TrainingSet& scan, const CellIndex& anchor, const IsCertain& isCertain);

  /// Adds what the rays of a cell said to what the weights say of it, if they say anything.
  void addTo(const CellIndex& cell, ReachedLogodds& said) const;
  /// The same for the cells in a box, x fastest, then y, then z.
  void addTo(const CellIndex& first, const std::array<int, 3>& counts,
             std::vector<ReachedLogodds>& said) const;

  [[nodiscard]] size_t memoryBytes() const { return scans_.memoryBytes(); }

  void save(HilbertState& state) const;
  /// @throws std::invalid_argument saying what is wrong with the state
  void restore(const HilbertState& state, const HilbertStructure& structure);

 private:
  /// By cell: hits in the low byte, passes in the high one, in units of 1/kUnits; 0: as if it were none.
  HilbertLattice<uint16_t> scans_;
};

}  // namespace lamap
