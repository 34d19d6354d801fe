#pragma once

#include <lamap_core/bgk/options.h>
#include <lamap_core/grid/reading.h>

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

namespace lamap
{
class BgkMap;

/** How a BGK map reads the two sums of a cell: ȳ and k̄ − ȳ over all scans (thesis eq. 4.5, 4.6), to which α₀
 * and β₀ are added; the sums count up to maxEvidence, but `evidence` tells all of them. A Reading as
 * EvidenceMap requires it. */
class BgkReading : public ReadingOf<BgkStructure, SumKind::Counts>
{
 public:
  using ReadingOf::ReadingOf;

  [[nodiscard]] CellEstimate read(const CellIndex& cell, const CellSums& sums,
                                  const StateThresholds& thresholds) const;
  /// Priors, the limit of evidence and pruning may differ.
  void requireAddable(const BgkReading& other) const;

  /// @throws std::invalid_argument if its resolution or planar layer differs.
  void setPriorMap(std::shared_ptr<const BgkMap> prior);
  [[nodiscard]] const std::shared_ptr<const BgkMap>& priorMap() const { return priorMap_; }
  [[nodiscard]] bool hasPriorMap() const { return priorMap_ != nullptr; }
  [[nodiscard]] bool priorKnows(const CellIndex& cell) const;
  void visitPriorCells(const std::function<void(const CellIndex&)>& visit) const;
  void visitPriorCells(const CellIndex& low, const CellIndex& high,
                       const std::function<void(const CellIndex&)>& visit) const;
  [[nodiscard]] std::optional<std::pair<CellIndex, CellIndex>> priorBounds() const;
  [[nodiscard]] int priorEmptyAround(const CellIndex& cell) const;
  /// α₀ and β₀ of a cell, from the prior map where that has evidence.
  [[nodiscard]] std::array<double, 2> priorOf(const CellIndex& cell) const;

 private:
  std::shared_ptr<const BgkMap> priorMap_;
};

/// Eq. (4.1): mean; eq. (4.2): variance; eq. (4.9): state.
[[nodiscard]] double bgkMean(double alpha, double beta);
[[nodiscard]] double bgkVariance(double alpha, double beta);
[[nodiscard]] CellState bgkState(double mean, double variance, const StateThresholds& thresholds);

}  // namespace lamap
