#pragma once

#include <lamap_core/grid/cell.h>
#include <lamap_core/grid/cell_sums.h>
#include <lamap_core/options/option_table.h>

#include <functional>
#include <limits>
#include <optional>
#include <utility>

namespace lamap
{
/** What is left of the evidence of a cell where it counts up to a limit: a factor for its sums, so that their
 * ratio stays. Scans of one place have correlated errors, and the n-th of them says little that is new.
 * @param evidence ≥ 0. @param most 0: no limit. @return in (0, 1] */
[[nodiscard]] inline double evidenceFactor(double evidence, double most)
{
  return most > 0 && evidence > most ? most / evidence : 1.0;
}

/** What the Readings of learners have in common: a legal structure, means of all sums, evidence that adds to
 * that of the same structure, and no map as the prior. A learner hides what differs. */
template <typename MapStructure, SumKind kSums>
class ReadingOf
{
 public:
  using Structure = MapStructure;
  static constexpr SumKind kKind = kSums;

  /// @throws std::invalid_argument as the structure's validate().
  explicit ReadingOf(const Structure& structure) : structure_(structure) { structure_.validate(); }

  [[nodiscard]] const Structure& structure() const { return structure_; }
  [[nodiscard]] bool mean(const CellSums* cells, uint32_t count, CellSums& mean) const
  {
    mean = meanSums(kKind, cells, count);
    return true;
  }
  /// Pruning may differ.
  void requireAddable(const ReadingOf& other) const
  {
    Structure theirs = other.structure_;
    theirs.pruning = structure_.pruning;
    requireSameOptions(theirs, structure_, "of the other map", "that of this map");
  }

  [[nodiscard]] bool hasPriorMap() const { return false; }
  [[nodiscard]] bool priorKnows(const CellIndex&) const { return false; }
  void visitPriorCells(const std::function<void(const CellIndex&)>&) const {}
  void visitPriorCells(const CellIndex& /*low*/, const CellIndex& /*high*/,
                       const std::function<void(const CellIndex&)>&) const
  {
  }
  [[nodiscard]] std::optional<std::pair<CellIndex, CellIndex>> priorBounds() const { return std::nullopt; }
  [[nodiscard]] int priorEmptyAround(const CellIndex&) const { return std::numeric_limits<int>::max(); }

 protected:
  Structure structure_;
};

}  // namespace lamap
