#pragma once

#include <lamap_core/hilbert/options.h>
#include <lamap_core/hilbert/state.h>
#include <lamap_core/scan/lattice_frame.h>
#include <lamap_core/training/hilbert_training.h>
#include <tsl/robin_map.h>

#include <cstddef>
#include <utility>
#include <vector>

namespace lamap
{
/** All training points of a map that is trained on them together (`Batch`).
 *
 * Points of equal place and label are one with the sum of their weights: the loss is the same. */
class KeptPoints
{
 public:
  /// If this fails, nothing is added. @param atCentres whether the points are the centres of cells. @param
  /// set in `frame`
  void add(const HilbertTrainingSet& set, const HilbertFrame& frame, bool atCentres);

  [[nodiscard]] size_t size() const;
  [[nodiscard]] size_t memoryBytes() const;

  /// As one training set, and the frame that it is in. There must be a point.
  [[nodiscard]] std::pair<HilbertFrame, HilbertTrainingSet> trainingSet(
      const HilbertStructure& structure) const;

  void save(HilbertState& state) const;
  /// @throws std::invalid_argument saying what is wrong with the state
  void restore(const HilbertState& state, const HilbertStructure& structure);

 private:
  struct Weights
  {
    float hits = 0;
    float frees = 0;
  };
  struct CellHash
  {
    [[nodiscard]] size_t operator()(const CellIndex& cell) const noexcept
    {
      return BlockIndexHash{}(BlockIndex{cell.x, cell.y, cell.z});
    }
  };
  void addCells(const HilbertTrainingSet& set, const HilbertFrame& frame);
  void addPoints(const HilbertTrainingSet& set, const HilbertFrame& frame);
  [[nodiscard]] std::vector<HilbertState::CellPoints> sortedCells() const;

  tsl::robin_map<CellIndex, Weights, CellHash> cells_;  ///< without weight: as if it were none
  std::vector<HilbertState::Point> points_;
};

}  // namespace lamap
