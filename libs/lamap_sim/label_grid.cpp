#include <lamap_core/options/legal_range.h>
#include <lamap_sim/label_grid.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace lamap::sim
{
using Eigen::AlignedBox3d;

LabelGrid::LabelGrid(const World& world, double resolution_m, int margin)
    : world_(world), resolution_m_(resolution_m), margin_(margin)
{
  requireLegal(resolution_m > 0 && std::isfinite(resolution_m), "resolution", resolution_m,
               "finite and above 0 (metres)");
  double count = 1;
  for (size_t axis = 0; axis < 3; ++axis)
  {
    const auto at = static_cast<Eigen::Index>(axis);
    double low = std::floor(world.interior_map.min()[at] / resolution_m_) - margin_;
    double high = std::ceil(world.interior_map.max()[at] / resolution_m_) + margin_;
    if (axis == 2 && world.flat)
    {
      low = 0;
      high = 1;
    }
    count *= high - low;
    constexpr double kMostCells = 1e9;
    if (!(count <= kMostCells))
      throw std::invalid_argument("resolution = " + shortText(resolution_m_) +
                                  " m: the world would have more than 1e9 cells; give a larger one");
    first_[axis] = static_cast<int32_t>(low);
    size_[axis] = static_cast<int32_t>(high - low);
  }
  labels_.resize(static_cast<size_t>(count), CellLabel::Outside);
}

bool LabelGrid::label(const Index3& begin, int32_t edge, const std::function<bool()>& shouldStop)
{
  Index3 end{};
  for (size_t axis = 0; axis < 3; ++axis)
  {
    end[axis] = std::min(begin[axis] + edge, size_[axis]);
    if (begin[axis] >= end[axis]) return true;
  }
  const AlignedBox3d box = boxBetween(begin, end);
  const Relation relation = world_.scene.relationOf(box, edge == 1 ? kSplits : 0);
  const bool within = world_.flat || world_.interior_map.contains(box);
  if (relation == Relation::Inside || (relation == Relation::Outside && within))
  {
    fill(begin, end, relation == Relation::Inside ? CellLabel::Solid : CellLabel::Open);
    return true;
  }
  if (edge == 1)
  {
    if (relation == Relation::Mixed) fill(begin, end, CellLabel::Mixed);
    return true;
  }
  if (edge == kBlock && shouldStop && shouldStop()) return false;
  return forEachPart(begin, end, edge / 2,
                     [&](const Index3& part) { return label(part, edge / 2, shouldStop); });
}

bool LabelGrid::labelAll(const std::function<bool()>& shouldStop)
{
  return forEachPart({0, 0, 0}, size_, kBlock,
                     [&](const Index3& part) { return label(part, kBlock, shouldStop); });
}

void LabelGrid::dropDeepCells()
{
  // Spread along one axis after the other: near[i] is set where a cell within the margin was.
  std::vector<uint8_t> near(labels_.size(), 0);
  forEachCell(
      [&](const Index3& cell)
      {
        near[at(cell)] = labelOf(cell) != CellLabel::Solid && isInInterior(cell) ? 1 : 0;
        return true;
      });
  for (size_t axis = 0; axis < 3; ++axis) spread(near, axis);
  for (size_t i = 0; i < labels_.size(); ++i)
    if (labels_[i] == CellLabel::Solid && near[i] == 0) labels_[i] = CellLabel::Deep;
}

size_t LabelGrid::at(const Index3& cell) const
{
  return (static_cast<size_t>(cell[2]) * static_cast<size_t>(size_[1]) + static_cast<size_t>(cell[1])) *
             static_cast<size_t>(size_[0]) +
         static_cast<size_t>(cell[0]);
}

CellIndex LabelGrid::indexOf(const Index3& cell) const
{
  return {first_[0] + cell[0], first_[1] + cell[1], first_[2] + cell[2]};
}

std::optional<LabelGrid::Index3> LabelGrid::cellOf(const CellIndex& index) const
{
  const Index3 cell{index.x - first_[0], index.y - first_[1], index.z - first_[2]};
  for (size_t axis = 0; axis < 3; ++axis)
    if (cell[axis] < 0 || cell[axis] >= size_[axis]) return std::nullopt;
  return cell;
}

AlignedBox3d LabelGrid::boxOf(const Index3& cell) const
{
  return boxBetween(cell, {cell[0] + 1, cell[1] + 1, cell[2] + 1});
}

bool LabelGrid::holdsSurface(const Index3& cell) const
{
  if (labelOf(cell) != CellLabel::Solid) return labelOf(cell) == CellLabel::Mixed;
  for (size_t axis = 0; axis < 3; ++axis)
    for (const int step : {-1, 1})
    {
      Index3 beside = cell;
      beside[axis] += step;
      if (beside[axis] >= 0 && beside[axis] < size_[axis] && labelOf(beside) == CellLabel::Open) return true;
    }
  return false;
}

AlignedBox3d LabelGrid::boxBetween(const Index3& begin, const Index3& end) const
{
  AlignedBox3d box;
  for (size_t axis = 0; axis < 3; ++axis)
  {
    const auto at = static_cast<Eigen::Index>(axis);
    box.min()[at] = (first_[axis] + begin[axis]) * resolution_m_;
    box.max()[at] = (first_[axis] + end[axis]) * resolution_m_;
  }
  return box;
}

bool LabelGrid::isInInterior(const Index3& begin) const
{
  for (size_t axis = 0; axis < 3; ++axis)
  {
    if (axis == 2 && world_.flat) continue;
    const auto along = static_cast<Eigen::Index>(axis);
    if ((first_[axis] + begin[axis] + 1) * resolution_m_ <= world_.interior_map.min()[along] ||
        (first_[axis] + begin[axis]) * resolution_m_ >= world_.interior_map.max()[along])
      return false;
  }
  return true;
}

void LabelGrid::fill(const Index3& begin, const Index3& end, CellLabel label)
{
  for (int32_t z = begin[2]; z < end[2]; ++z)
    for (int32_t y = begin[1]; y < end[1]; ++y)
      std::fill_n(labels_.begin() + static_cast<long>(at({begin[0], y, z})), end[0] - begin[0], label);
}

void LabelGrid::spread(std::vector<uint8_t>& near, size_t axis) const
{
  const std::array<size_t, 3> strides{1, at({0, 1, 0}), at({0, 0, 1})};
  const size_t stride = strides[axis];
  const int32_t length = size_[axis];
  std::vector<uint8_t> line(static_cast<size_t>(length));
  Index3 starts = size_;  // of the lines along the axis
  starts[axis] = 1;
  const auto spreadLine = [&](const Index3& begin)
  {
    const size_t start = at(begin);
    for (int32_t i = 0; i < length; ++i) line[static_cast<size_t>(i)] = near[start + i * stride];
    for (int32_t i = 0; i < length; ++i)
    {
      const auto from = line.begin() + std::max(0, i - margin_);
      const auto to = line.begin() + std::min(length, i + margin_ + 1);
      near[start + i * stride] = std::find(from, to, 1) != to ? 1 : 0;
    }
    return true;
  };
  forEachPart({0, 0, 0}, starts, 1, spreadLine);
}

}  // namespace lamap::sim
