#pragma once

#include <lamap_tools/cells/cell_map.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace lamap::test
{
/// A map with exactly the cells that a test adds, so that expected results are known by hand.
class HandMadeCells : public tools::CellMap
{
 public:
  explicit HandMadeCells(double resolution_m = 0.1) : resolution_m_(resolution_m) {}

  /// Evidence follows from the probability: alpha = 10 p, beta = 10 (1 − p).
  HandMadeCells& put(const CellIndex& cell, double prob, CellState state,
                     std::optional<double> variance = std::nullopt)
  {
    CellEstimate estimate;
    estimate.prob = prob;
    estimate.state = state;
    estimate.variance = variance;
    estimate.evidence = {10 * prob, 10 * (1 - prob)};
    cells_.emplace_back(cell, estimate);
    return *this;
  }

  std::string className() const override { return "HandMadeCells"; }
  double resolution() const override { return resolution_m_; }
  std::vector<std::string> evidenceNames() const override { return {"alpha", "beta"}; }

  std::optional<CellEstimate> estimateAt(const mrpt::math::TPoint3D& point_map) const override
  {
    const auto index = cellAt({point_map.x, point_map.y, point_map.z}, resolution_m_);
    for (const auto& [cell, estimate] : cells_)
      if (index && cell == *index) return estimate;
    return std::nullopt;
  }

  /// In the order in which they were added.
  void visitCells(const CellVisitor& visitor) const override
  {
    for (const auto& [cell, estimate] : cells_) visitor(cell, estimate);
  }

 private:
  double resolution_m_;
  std::vector<std::pair<CellIndex, CellEstimate>> cells_;
};

}  // namespace lamap::test
