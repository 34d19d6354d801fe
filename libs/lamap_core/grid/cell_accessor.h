#pragma once

#include <lamap_core/grid/cell.h>
#include <lamap_core/grid/cell_place.h>
#include <lamap_core/grid/evidence_map.h>
#include <lamap_core/grid/state_thresholds.h>

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace lamap
{
/// A cell that has evidence, as box visitors get it.
struct KnownCell
{
  CellIndex cell;
  CellState state = CellState::Unknown;
  double prob = 0.5;  ///< P(occupied), in [0, 1]
};

/// The blocks from one corner to the other.
struct BlockBox
{
  BlockIndex low;
  BlockIndex high;

  [[nodiscard]] bool holds(const BlockIndex& index) const
  {
    return index.x >= low.x && index.x <= high.x && index.y >= low.y && index.y <= high.y &&
           index.z >= low.z && index.z <= high.z;
  }
  [[nodiscard]] bool isFewerThan(size_t count) const
  {
    const auto along = [](int32_t from, int32_t to) { return static_cast<double>(to) - from + 1; };
    return along(low.x, high.x) * along(low.y, high.y) * along(low.z, high.z) < static_cast<double>(count);
  }
  template <typename Visit>
  void forEach(Visit&& visit) const
  {
    BlockIndex index;
    for (index.z = low.z; index.z <= high.z; ++index.z)
      for (index.y = low.y; index.y <= high.y; ++index.y)
        for (index.x = low.x; index.x <= high.x; ++index.x) visit(index);
  }
};

/** Reads many cells of a map, of which each lies near the one before: along a ray, in a box, in a row. It
 * keeps the block of the last cell, so that only the first cell in a block is looked up in the map.
 *
 *   CellAccessor accessor(map.core(), map.stateThresholds());  // of a CBGKMap
 *   for (const Eigen::Vector3d& point : path)
 *     if (accessor.stateAt(point) == CellState::Occupied) …
 *
 * Invariants: the answers are those of the map's cell() and at(), to the last bit. Nothing is allocated, but
 * by the first visitBox(), and where another map is the prior.
 *
 * A map that changed is noticed: the kept block is forgotten, and answers are those of the map as it is then.
 * The map must outlive the accessor and stay in its place.
 *
 * Thread guarantee: one accessor per thread, since questions change it. Any number of them may read one map
 * as long as nobody changes it.
 *
 * @tparam Reading that of the map, see EvidenceMap; deduced from a BgkMap, GpMap or OverlappingHilbertMap */
template <typename Reading>
class CellAccessor
{
 public:
  explicit CellAccessor(const EvidenceMap<Reading>& map, const StateThresholds& thresholds = {});

  /// As EvidenceMap::cell() and at().
  [[nodiscard]] std::optional<CellEstimate> cell(const CellIndex& index);
  [[nodiscard]] std::optional<CellEstimate> at(const Eigen::Vector3d& point_m);

  /// P(occupied) of a cell or at a point [m]; nothing where there is no evidence.
  [[nodiscard]] std::optional<double> prob(const CellIndex& index);
  [[nodiscard]] std::optional<double> probAt(const Eigen::Vector3d& point_m);

  /// State of a cell or at a point [m]; nothing where there is no evidence.
  [[nodiscard]] std::optional<CellState> state(const CellIndex& index);
  [[nodiscard]] std::optional<CellState> stateAt(const Eigen::Vector3d& point_m);

  /** Visits each cell with evidence in [low, high] once, in no promised order: all that the map has of a
   * block at a time. The visitor must not ask this accessor for anything else.
   * @param visit void(const KnownCell&) */
  template <typename Visit>
  void visitBox(const CellIndex& low, const CellIndex& high, Visit&& visit);

  /** For walks along a ray. @return n where a cube of 2^n cells around the cell that was asked last, aligned
   * to its size, is known to be without evidence; 0 where it is not known */
  [[nodiscard]] int emptyAroundLast() const;

 private:
  using Map = EvidenceMap<Reading>;

  /// Makes the block of a cell the kept one.
  void keepBlockOf(const CellIndex& index);
  void keep(const BlockIndex& index);
  /// @return whether the cell has evidence here or in a prior map
  bool find(const CellIndex& index, CellSums& sums);
  bool findAt(const Eigen::Vector3d& point_m, CellIndex& index) const;
  /// The blocks that may have cells in a box; nothing if there are none.
  [[nodiscard]] std::optional<BlockBox> blocksIn(const CellIndex& low, const CellIndex& high) const;
  /// Puts the cells of a block that are in a box into `found_`.
  void readBlock(const BlockIndex& index, const EvidenceBlock& block, const CellIndex& low,
                 const CellIndex& high);
  void addFound(const CellIndex& cell, const CellSums& sums);
  /// Puts the cells of a prior map that are in a box, and without evidence here, into `found_`.
  void readPrior(const CellIndex& low, const CellIndex& high);

  const Map* map_;
  StateThresholds thresholds_;
  CellFinder finder_;
  BlockShape shape_;
  std::optional<int32_t> layer_;
  bool hasPrior_;

  // The block of the last question.
  BlockIndex index_;
  EvidenceBlock::View block_;
  uint64_t changes_ = 0;  ///< of the map when it was looked up
  CellIndex last_;

  std::vector<KnownCell> found_;
};

template <typename Reading>
CellAccessor(const EvidenceMap<Reading>&, const StateThresholds&) -> CellAccessor<Reading>;
template <typename Reading>
CellAccessor(const EvidenceMap<Reading>&) -> CellAccessor<Reading>;

template <typename Reading>
template <typename Visit>
void CellAccessor<Reading>::visitBox(const CellIndex& low, const CellIndex& high, Visit&& visit)
{
  const auto visitFound = [&]
  {
    for (const KnownCell& known : found_) visit(known);
  };
  if (const auto blocks = blocksIn(low, high))
  {
    const Evidence& evidence = map_->evidence();
    const auto visitBlock = [&](const BlockIndex& index, const EvidenceBlock& block)
    {
      readBlock(index, block, low, high);
      visitFound();
    };
    if (blocks->isFewerThan(evidence.blockCount()))
      blocks->forEach(
          [&](const BlockIndex& index)
          {
            if (const EvidenceBlock* const block = evidence.find(index)) visitBlock(index, *block);
          });
    else
      evidence.forEachBlock(
          [&](const BlockIndex& index, const EvidenceBlock& block)
          {
            if (blocks->holds(index)) visitBlock(index, block);
          });
  }
  if (!hasPrior_) return;
  readPrior(low, high);
  visitFound();
}

}  // namespace lamap
