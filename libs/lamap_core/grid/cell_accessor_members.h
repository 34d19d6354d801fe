#pragma once

// Members of CellAccessor, for the source that instantiates it for its learner; that must have included the
// learner's probOf() and stateOf(), see EvidenceMap.

#include <lamap_core/grid/cell_accessor.h>

#include <algorithm>
#include <array>

namespace lamap
{
/// P(occupied) of cells without a prior map, by their narrow sums. A learner may have a quicker one.
template <typename Reading>
void probsOf(const Reading& reading, const uint64_t* sums, size_t count, double* probs)
{
  for (size_t i = 0; i < count; ++i) probs[i] = probOf(reading, {}, {sums[i] & 0xFFFFFFFFu, sums[i] >> 32});
}

template <typename Reading>
CellAccessor<Reading>::CellAccessor(const EvidenceMap<Reading>& map, const StateThresholds& thresholds)
    : map_(&map),
      thresholds_(thresholds),
      finder_(map.structure().resolution),
      shape_(map.evidence().shape()),
      hasPrior_(map.reading_.hasPriorMap())
{
  if (map.structure().planar) layer_ = map.planarLayer();
  keep({});
}

template <typename Reading>
void CellAccessor<Reading>::keep(const BlockIndex& index)
{
  index_ = index;
  const EvidenceBlock* const block = map_->evidence_.find(index);
  block_ = block != nullptr ? block->view(shape_) : EvidenceBlock::View{};
  changes_ = map_->evidence_.changes();
}

template <typename Reading>
inline void CellAccessor<Reading>::keepBlockOf(const CellIndex& index)
{
  const BlockIndex block = shape_.blockOf(index);
  if (!(block == index_) || changes_ != map_->evidence_.changes()) keep(block);
}

template <typename Reading>
inline bool CellAccessor<Reading>::find(const CellIndex& index, CellSums& sums)
{
  last_ = index;
  if (layer_ && index.z != *layer_) return false;
  keepBlockOf(index);
  sums = block_.ranks != nullptr ? block_.at(shape_.offsetOf(index)) : CellSums{};
  if (hasPrior_) return sums.any() || map_->reading_.priorKnows(index);
  return sums.any();
}

template <typename Reading>
inline bool CellAccessor<Reading>::findAt(const Eigen::Vector3d& point_m, CellIndex& index) const
{
  if (!finder_.find(point_m, index)) return false;
  if (layer_) index.z = *layer_;
  return true;
}

template <typename Reading>
std::optional<CellEstimate> CellAccessor<Reading>::cell(const CellIndex& index)
{
  CellSums sums;
  if (!find(index, sums)) return std::nullopt;
  return map_->reading_.read(index, sums, thresholds_);
}

template <typename Reading>
std::optional<CellEstimate> CellAccessor<Reading>::at(const Eigen::Vector3d& point_m)
{
  CellIndex index;
  if (!findAt(point_m, index)) return std::nullopt;
  return cell(index);
}

template <typename Reading>
std::optional<double> CellAccessor<Reading>::prob(const CellIndex& index)
{
  CellSums sums;
  if (!find(index, sums)) return std::nullopt;
  return probOf(map_->reading_, index, sums);
}

template <typename Reading>
std::optional<double> CellAccessor<Reading>::probAt(const Eigen::Vector3d& point_m)
{
  CellIndex index;
  CellSums sums;
  if (!findAt(point_m, index) || !find(index, sums)) return std::nullopt;
  return probOf(map_->reading_, index, sums);
}

template <typename Reading>
std::optional<CellState> CellAccessor<Reading>::state(const CellIndex& index)
{
  CellSums sums;
  if (!find(index, sums)) return std::nullopt;
  return stateOf(map_->reading_, index, sums, probOf(map_->reading_, index, sums), thresholds_);
}

template <typename Reading>
std::optional<CellState> CellAccessor<Reading>::stateAt(const Eigen::Vector3d& point_m)
{
  CellIndex index;
  CellSums sums;
  if (!findAt(point_m, index) || !find(index, sums)) return std::nullopt;
  return stateOf(map_->reading_, index, sums, probOf(map_->reading_, index, sums), thresholds_);
}

template <typename Reading>
int CellAccessor<Reading>::emptyAroundLast() const
{
  if (block_.ranks != nullptr || hasPrior_ || (layer_ && last_.z != *layer_)) return 0;
  return std::max(shape_.log2Edge(), map_->emptyAround(last_));
}

template <typename Reading>
std::optional<BlockBox> CellAccessor<Reading>::blocksIn(const CellIndex& low, const CellIndex& high) const
{
  const auto bounds = map_->evidence_.extent()->bounds();
  if (!bounds) return std::nullopt;
  const auto& [least, most] = *bounds;
  const CellIndex first{std::max(low.x, least.x), std::max(low.y, least.y), std::max(low.z, least.z)};
  const CellIndex last{std::min(high.x, most.x), std::min(high.y, most.y), std::min(high.z, most.z)};
  if (first.x > last.x || first.y > last.y || first.z > last.z) return std::nullopt;
  return BlockBox{map_->evidence_.blockOf(first), map_->evidence_.blockOf(last)};
}

template <typename Reading>
inline void CellAccessor<Reading>::addFound(const CellIndex& cell, const CellSums& sums)
{
  const double prob = probOf(map_->reading_, cell, sums);
  found_.push_back({cell, stateOf(map_->reading_, cell, sums, prob, thresholds_), prob});
}

template <typename Reading>
void CellAccessor<Reading>::readBlock(const BlockIndex& index, const EvidenceBlock& block,
                                      const CellIndex& low, const CellIndex& high)
{
  const CellIndex first = shape_.firstCellOf(index);
  const CellIndex last{first.x + shape_.edge() - 1, first.y + shape_.edge() - 1,
                       first.z + (shape_.planar() ? 0 : shape_.edge() - 1)};
  const bool isWhole = first.x >= low.x && first.y >= low.y && first.z >= low.z && last.x <= high.x &&
                       last.y <= high.y && last.z <= high.z;
  const auto isInside = [&](const CellIndex& cell)
  {
    return cell.x >= low.x && cell.y >= low.y && cell.z >= low.z && cell.x <= high.x && cell.y <= high.y &&
           cell.z <= high.z;
  };
  found_.reserve(shape_.cellCount());
  // Most blocks hold every cell by itself, in narrow numbers. Many are read at once where the learner can.
  if (!hasPrior_ && !(thresholds_.variance > 0) && !block.wide() && !block.pruned() && !block.empty())
  {
    const EvidenceBlock::View view = block.view(shape_);
    const uint64_t* sums = view.leaves;
    std::array<double, 64> probs;
    found_.resize(shape_.cellCount());
    // Each number is written by itself: a cell that is put together first has to wait for its parts.
    KnownCell* next = found_.data();
    for (uint32_t word = 0; word < shape_.maskWords(); ++word)
    {
      uint64_t rest = view.observed[word];
      if (rest == 0) continue;
      const auto count = EvidenceBlock::countBits(rest);
      probsOf(map_->reading_, sums, count, probs.data());
      sums += count;
      const double* prob = probs.data();
      for (; rest != 0; rest &= rest - 1, ++prob)
      {
        const CellIndex local = shape_.localOf(word * 64 + static_cast<uint32_t>(__builtin_ctzll(rest)));
        next->cell.x = first.x + local.x;
        next->cell.y = first.y + local.y;
        next->cell.z = first.z + local.z;
        next->state = stateOf(*prob, thresholds_);
        next->prob = *prob;
        if (isWhole || isInside(next->cell)) ++next;
      }
    }
    found_.resize(static_cast<size_t>(next - found_.data()));
    return;
  }
  found_.clear();
  block.visitLeaves(shape_,
                    [&](uint32_t begin, uint32_t count, const CellSums& sums)
                    {
                      const double prob = hasPrior_ ? 0 : probOf(map_->reading_, {}, sums);
                      const CellState state = hasPrior_
                                                  ? CellState::Unknown
                                                  : stateOf(map_->reading_, {}, sums, prob, thresholds_);
                      for (uint32_t offset = begin; offset < begin + count; ++offset)
                      {
                        const CellIndex cell = shape_.plus(first, offset);
                        if (!isWhole && !isInside(cell)) continue;
                        if (hasPrior_)
                          addFound(cell, sums);
                        else
                          found_.push_back({cell, state, prob});
                      }
                    });
}

template <typename Reading>
void CellAccessor<Reading>::readPrior(const CellIndex& low, const CellIndex& high)
{
  found_.clear();
  map_->reading_.visitPriorCells(low, high,
                                 [&](const CellIndex& cell)
                                 {
                                   if (!map_->evidence_.at(cell).any()) addFound(cell, {});
                                 });
}

}  // namespace lamap
