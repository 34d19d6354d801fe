#pragma once

#include <lamap_core/grid/cell.h>
#include <lamap_core/grid/evidence.h>
#include <lamap_core/grid/octant_rule.h>
#include <lamap_core/grid/state_thresholds.h>

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <utility>

namespace lamap
{
class Workers;
template <typename Reading>
class CellAccessor;

/** Evidence in a map: look-up, reading, pruning, merging and writing of cells, for all learners.
 *
 * @tparam Reading how a learner reads two sums:
 *   Structure                 options fixed for the map's life; resolution, blockDepth, pruning, planar and
 *                             planarHeight among them
 *   kKind                     SumKind of its sums
 *   Reading(structure)        throws std::invalid_argument where the structure is illegal
 *   structure()
 *   read(cell, sums, thresholds)   CellEstimate of a cell
 *   mean(cells, count, mean)  mean sums of cells in one state; false where they have none
 *   requireAddable(other)     throws std::invalid_argument unless evidence of the other means the same
 *   hasPriorMap(), priorKnows(cell), visitPriorCells(visit), priorBounds(), priorEmptyAround(cell),
 *   visitPriorCells(low, high, visit): of a map as the prior
 *
 * ReadingOf gives all but read(). For a CellAccessor, besides, functions that are inlined where it is
 * compiled: probOf(reading, cell, sums), stateOf(reading, cell, sums, prob, thresholds)   as read() gives
 * them
 *
 * Invariants: cells without evidence read as nothing, or as the prior map says; pruning changes no state; an
 * addition that throws changes nothing.
 *
 * Thread guarantee: const methods may be called from several threads as long as nobody changes the map.
 *
 * Members are defined in evidence_map_members.h and compiled once per learner, so that no option of a user's
 * compiler changes a bit.
 */
template <typename Reading>
class EvidenceMap
{
 public:
  using Structure = typename Reading::Structure;

  [[nodiscard]] const Structure& structure() const { return reading_.structure(); }
  /// The layer of cells of a planar map.
  [[nodiscard]] int32_t planarLayer() const { return planarLayer_; }

  /// Forgets all evidence; the structure, and a prior map, stay.
  void clear() { evidence_.clear(); }
  [[nodiscard]] bool empty() const { return evidence_.blockCount() == 0; }

  /// Estimate of a cell; nothing where neither this map nor a prior map has evidence.
  [[nodiscard]] std::optional<CellEstimate> cell(const CellIndex& index,
                                                 const StateThresholds& thresholds) const;
  /// The same for the cell at a point [m]. In a planar map the height of the point does not matter.
  [[nodiscard]] std::optional<CellEstimate> at(const Eigen::Vector3d& point_m,
                                               const StateThresholds& thresholds) const;

  /// For many questions to cells that lie together: see cell_accessor.h.
  using Accessor = CellAccessor<Reading>;

  using CellVisitor = std::function<void(const CellIndex&, const CellEstimate&)>;
  /// Each finest cell that has evidence here or in a prior map, once, in no promised order.
  void visitCells(const StateThresholds& thresholds, const CellVisitor& visitor) const;
  /// The smallest and the largest index of these cells along each axis; without a walk of them.
  [[nodiscard]] std::optional<std::pair<CellIndex, CellIndex>> cellBounds() const;
  /// A cube of 2^n cells around a cell, aligned to its size, and those beside it hold none of these cells.
  /// @return the largest n that is known, or 0
  [[nodiscard]] int emptyAround(const CellIndex& index) const;

  /// Bytes of the evidence.
  [[nodiscard]] size_t memoryBytes() const { return evidence_.memoryBytes(); }

  /// The evidence itself, for files and statistics.
  [[nodiscard]] const Evidence& evidence() const { return evidence_; }
  /// Puts evidence in the place of what is there, e.g. from a file.
  /// @throws std::invalid_argument unless its shape and kind are those of this map
  void restoreEvidence(Evidence&& evidence);

 protected:
  explicit EvidenceMap(const Structure& structure);
  ~EvidenceMap() = default;
  EvidenceMap(const EvidenceMap&) = default;
  EvidenceMap& operator=(const EvidenceMap&) = default;
  EvidenceMap(EvidenceMap&&) noexcept = default;
  EvidenceMap& operator=(EvidenceMap&&) noexcept = default;

  [[nodiscard]] Reading& reading() { return reading_; }
  [[nodiscard]] const Reading& reading() const { return reading_; }
  [[nodiscard]] Evidence& mutableEvidence() { return evidence_; }
  [[nodiscard]] RuleForBlock ruleFor(const StateThresholds& thresholds) const;

  /// Adds the evidence of a scan. @throws std::overflow_error, with nothing changed: see addSums().
  void add(Evidence&& said, const StateThresholds& thresholds, const Workers& workers);
  /// Adds the evidence of another map. @throws as add(), and as Reading::requireAddable()
  void merge(const EvidenceMap& other, const StateThresholds& thresholds);
  /// Evidence that holds one cell alone. In a planar map its height does not matter.
  [[nodiscard]] Evidence evidenceOf(const CellIndex& index, const CellSums& sums) const;

 private:
  friend class CellAccessor<Reading>;

  Reading reading_;
  int32_t planarLayer_;
  Evidence evidence_;
};

}  // namespace lamap
