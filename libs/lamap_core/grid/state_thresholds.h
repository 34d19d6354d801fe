#pragma once

#include <lamap_core/grid/cell.h>

namespace lamap
{
/// Thesis eq. (4.9). The defaults were chosen by how well occupied cells cover simulated surfaces.
struct StateThresholds
{
  static constexpr double kOccupiedInThesis = 0.7;

  double free = 0.3;       ///< a cell is free below this P(occupied); in [0, 1], not above `occupied`
  double occupied = 0.55;  ///< a cell is occupied above this P(occupied); in [0, 1]
  double variance =
      0.0;  ///< a cell is unknown unless its variance is below this; 0: variances are not considered

  friend bool operator==(const StateThresholds& a, const StateThresholds& b)
  {
    return a.free == b.free && a.occupied == b.occupied && a.variance == b.variance;
  }
};

/// The state of a cell whose variance is small enough. @param prob P(occupied)
[[nodiscard]] inline CellState stateOf(double prob, const StateThresholds& thresholds)
{
  // Both cannot be true. Without branches, which would wait for the evidence of the cell and often be guessed
  // wrong.
  const int isFree = prob < thresholds.free ? 1 : 0;
  const int isOccupied = prob > thresholds.occupied ? 1 : 0;
  return static_cast<CellState>(isFree * static_cast<int>(CellState::Free) +
                                isOccupied * static_cast<int>(CellState::Occupied));
}

}  // namespace lamap
