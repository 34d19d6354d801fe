#pragma once

// Members of EvidenceMap, for the source that instantiates it for its learner.

#include <lamap_core/grid/evidence_change.h>
#include <lamap_core/grid/evidence_map.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace lamap
{
template <typename Reading>
EvidenceMap<Reading>::EvidenceMap(const Structure& structure)
    : reading_(structure),
      planarLayer_(heldCell(structure.planarHeight / structure.resolution)),
      evidence_(BlockShape(structure.blockDepth - 1, structure.planar), Reading::kKind)
{
  evidence_.keepExtent();
}

template <typename Reading>
RuleForBlock EvidenceMap<Reading>::ruleFor(const StateThresholds& thresholds) const
{
  switch (structure().pruning)
  {
    case Pruning::None:
      return [](const BlockIndex&) { return OctantRule{}; };
    case Pruning::Lossless:
      return [](const BlockIndex&) { return OctantRule{Pruning::Lossless, mergeEqual}; };
    case Pruning::State:
      break;
  }
  return [this, thresholds](const BlockIndex& block)
  {
    const CellIndex first = evidence_.firstCellOf(block);
    const auto stateOf = [this, thresholds, first](uint32_t offset, const CellSums& sums)
    {
      const CellIndex local = evidence_.shape().localOf(offset);
      return reading_.read({first.x + local.x, first.y + local.y, first.z + local.z}, sums, thresholds).state;
    };
    const auto meanOf = [this](const CellSums* cells, uint32_t count, CellSums& mean)
    { return reading_.mean(cells, count, mean); };
    const auto merger = [=](const DenseBlock& dense, uint32_t begin, uint32_t count, CellSums& merged)
    { return mergeSameState(dense, begin, count, merged, meanOf, stateOf); };
    return OctantRule{Pruning::State, merger};
  };
}

template <typename Reading>
void EvidenceMap<Reading>::add(Evidence&& said, const StateThresholds& thresholds, const Workers& workers)
{
  EvidenceChange::addition(evidence_, std::move(said), ruleFor(thresholds), workers).commit();
}

template <typename Reading>
void EvidenceMap<Reading>::merge(const EvidenceMap& other, const StateThresholds& thresholds)
{
  reading_.requireAddable(other.reading_);
  const Workers workers(1);
  EvidenceChange::addition(evidence_, other.evidence_, ruleFor(thresholds), workers).commit();
}

template <typename Reading>
Evidence EvidenceMap<Reading>::evidenceOf(const CellIndex& index, const CellSums& sums) const
{
  CellIndex cell = index;
  if (structure().planar) cell.z = planarLayer_;
  const BlockShape& shape = evidence_.shape();
  Evidence evidence(shape, Reading::kKind);
  DenseBlock dense(shape);
  dense.set(shape.offsetOf(cell), sums);
  evidence.findOrCreate(evidence.blockOf(cell)).pack(shape, dense, {});
  return evidence;
}

template <typename Reading>
std::optional<CellEstimate> EvidenceMap<Reading>::cell(const CellIndex& index,
                                                       const StateThresholds& thresholds) const
{
  if (structure().planar && index.z != planarLayer_) return std::nullopt;
  const CellSums sums = evidence_.at(index);
  if (!sums.any() && !reading_.priorKnows(index)) return std::nullopt;
  return reading_.read(index, sums, thresholds);
}

template <typename Reading>
std::optional<CellEstimate> EvidenceMap<Reading>::at(const Eigen::Vector3d& point_m,
                                                     const StateThresholds& thresholds) const
{
  auto index = cellAt(point_m, structure().resolution);
  if (!index) return std::nullopt;
  if (structure().planar) index->z = planarLayer_;
  return cell(*index, thresholds);
}

template <typename Reading>
void EvidenceMap<Reading>::visitCells(const StateThresholds& thresholds, const CellVisitor& visitor) const
{
  const BlockShape& shape = evidence_.shape();
  for (const BlockIndex& index : evidence_.sortedBlocks())
  {
    const CellIndex first = evidence_.firstCellOf(index);
    evidence_.find(index)->visitLeaves(
        shape,
        [&](uint32_t begin, uint32_t count, const CellSums& sums)
        {
          CellEstimate estimate;
          for (uint32_t offset = begin; offset < begin + count; ++offset)
          {
            const CellIndex local = shape.localOf(offset);
            const CellIndex cell{first.x + local.x, first.y + local.y, first.z + local.z};
            if (offset == begin || reading_.hasPriorMap()) estimate = reading_.read(cell, sums, thresholds);
            visitor(cell, estimate);
          }
        });
  }
  reading_.visitPriorCells(
      [&](const CellIndex& cell)
      {
        if (!evidence_.at(cell).any()) visitor(cell, reading_.read(cell, {}, thresholds));
      });
}

template <typename Reading>
void EvidenceMap<Reading>::restoreEvidence(Evidence&& evidence)
{
  if (!(evidence.shape() == evidence_.shape()) || evidence.kind() != evidence_.kind())
    throw std::invalid_argument("the evidence is not that of such a map: its blocks or sums differ");
  evidence.keepExtent();
  evidence_ = std::move(evidence);
}

template <typename Reading>
std::optional<std::pair<CellIndex, CellIndex>> EvidenceMap<Reading>::cellBounds() const
{
  const auto own = evidence_.extent()->bounds();
  const auto prior = reading_.priorBounds();
  if (!own || !prior) return own ? own : prior;
  const auto& [low, high] = *own;
  const auto& [priorLow, priorHigh] = *prior;
  return std::make_pair(
      CellIndex{std::min(low.x, priorLow.x), std::min(low.y, priorLow.y), std::min(low.z, priorLow.z)},
      CellIndex{std::max(high.x, priorHigh.x), std::max(high.y, priorHigh.y), std::max(high.z, priorHigh.z)});
}

template <typename Reading>
int EvidenceMap<Reading>::emptyAround(const CellIndex& index) const
{
  const int empty = evidence_.extent()->emptyAround(index);
  return empty == 0 ? 0 : std::min(empty, reading_.priorEmptyAround(index));
}

}  // namespace lamap
