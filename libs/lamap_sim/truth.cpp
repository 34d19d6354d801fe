#include <lamap_core/options/legal_range.h>
#include <lamap_sim/truth.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

namespace lamap::sim
{
namespace
{
using Eigen::AlignedBox3d;
using Eigen::Vector3d;
using Index3 = std::array<int32_t, 3>;

enum Label : uint8_t
{
  kNeither,  ///< contains a surface, or is outside the interior without being solid
  kOpen,
  kSolid,
  kDeep  ///< solid, but too far behind any surface
};

/// Labels of a box of cells.
class LabelGrid
{
 public:
  LabelGrid(const World& world, const TruthOptions& options)
      : world_(world), resolution_m_(options.resolution_m), depth_(options.depthCells)
  {
    double count = 1;
    for (size_t axis = 0; axis < 3; ++axis)
    {
      const auto at = static_cast<Eigen::Index>(axis);
      double low = std::floor(world.interior_map.min()[at] / resolution_m_) - depth_;
      double high = std::ceil(world.interior_map.max()[at] / resolution_m_) + depth_;
      if (axis == 2 && world.flat)
      {
        low = 0;
        high = 1;
      }
      count *= high - low;
      constexpr double kMostCells = 1e9;
      if (!(count <= kMostCells))
        throw std::invalid_argument("resolution = " + std::to_string(resolution_m_) +
                                    " m: the world would have more than 1e9 cells; give a larger one");
      first_[axis] = static_cast<int32_t>(low);
      size_[axis] = static_cast<int32_t>(high - low);
    }
    labels_.resize(static_cast<size_t>(count), kNeither);
  }

  /// Labels the cells begin .. begin+edge-1, all together if they agree.
  /// @return false if it was stopped
  bool label(const Index3& begin, int32_t edge, const std::function<bool()>& shouldStop)
  {
    Index3 end{};
    for (size_t axis = 0; axis < 3; ++axis)
    {
      end[axis] = std::min(begin[axis] + edge, size_[axis]);
      if (begin[axis] >= end[axis]) return true;
    }
    const AlignedBox3d box = boxOf(begin, end);
    const Relation relation = world_.scene.relationOf(box, edge == 1 ? kSplits : 0);
    const bool within = world_.flat || world_.interior_map.contains(box);
    if (relation == Relation::Inside || (relation == Relation::Outside && within))
    {
      fill(begin, end, relation == Relation::Inside ? kSolid : kOpen);
      return true;
    }
    if (edge == 1) return true;
    if (edge == kBlock && shouldStop && shouldStop()) return false;
    return forEachPart(begin, end, edge / 2,
                       [&](const Index3& part) { return label(part, edge / 2, shouldStop); });
  }

  bool labelAll(const std::function<bool()>& shouldStop)
  {
    return forEachPart({0, 0, 0}, size_, kBlock,
                       [&](const Index3& part) { return label(part, kBlock, shouldStop); });
  }

  /// Removes solid cells that have only solid cells around them.
  void dropDeepCells()
  {
    // Spread along one axis after the other: near[i] is set where a cell within depth_ was.
    std::vector<uint8_t> near(labels_.size(), 0);
    forEachPart({0, 0, 0}, size_, 1,
                [&](const Index3& cell)
                {
                  const size_t i = at(cell[0], cell[1], cell[2]);
                  near[i] = labels_[i] != kSolid && isInInterior(cell) ? 1 : 0;
                  return true;
                });
    for (size_t axis = 0; axis < 3; ++axis) spread(near, axis);
    for (size_t i = 0; i < labels_.size(); ++i)
      if (labels_[i] == kSolid && near[i] == 0) labels_[i] = kDeep;
  }

  [[nodiscard]] std::vector<TrueCell> cells() const
  {
    std::vector<TrueCell> cells;
    forEachPart({0, 0, 0}, size_, 1,
                [&](const Index3& cell)
                {
                  const uint8_t label = labels_[at(cell[0], cell[1], cell[2])];
                  if (label == kOpen || label == kSolid)
                    cells.push_back(
                        {{first_[0] + cell[0], first_[1] + cell[1], first_[2] + cell[2]}, label == kSolid});
                  return true;
                });
    return cells;
  }

 private:
  static constexpr int32_t kBlock = 16;
  static constexpr int kSplits = 3;

  template <class Visit>
  static bool forEachPart(const Index3& begin, const Index3& end, int32_t edge, const Visit& visit)
  {
    for (int32_t z = begin[2]; z < end[2]; z += edge)
      for (int32_t y = begin[1]; y < end[1]; y += edge)
        for (int32_t x = begin[0]; x < end[0]; x += edge)
          if (!visit(Index3{x, y, z})) return false;
    return true;
  }

  [[nodiscard]] AlignedBox3d boxOf(const Index3& begin, const Index3& end) const
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

  [[nodiscard]] size_t at(int32_t x, int32_t y, int32_t z) const
  {
    return (static_cast<size_t>(z) * static_cast<size_t>(size_[1]) + static_cast<size_t>(y)) *
               static_cast<size_t>(size_[0]) +
           static_cast<size_t>(x);
  }

  /// Whether a cell overlaps the interior.
  [[nodiscard]] bool isInInterior(const Index3& begin) const
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

  void fill(const Index3& begin, const Index3& end, Label label)
  {
    for (int32_t z = begin[2]; z < end[2]; ++z)
      for (int32_t y = begin[1]; y < end[1]; ++y)
        std::fill_n(labels_.begin() + static_cast<long>(at(begin[0], y, z)), end[0] - begin[0], label);
  }

  void spread(std::vector<uint8_t>& near, size_t axis) const
  {
    const std::array<size_t, 3> strides{1, at(0, 1, 0), at(0, 0, 1)};
    const size_t stride = strides[axis];
    const int32_t length = size_[axis];
    std::vector<uint8_t> line(static_cast<size_t>(length));
    Index3 starts = size_;  // of the lines along the axis
    starts[axis] = 1;
    const auto spreadLine = [&](const Index3& begin)
    {
      const size_t start = at(begin[0], begin[1], begin[2]);
      for (int32_t i = 0; i < length; ++i) line[static_cast<size_t>(i)] = near[start + i * stride];
      for (int32_t i = 0; i < length; ++i)
      {
        const auto from = line.begin() + std::max(0, i - depth_);
        const auto to = line.begin() + std::min(length, i + depth_ + 1);
        near[start + i * stride] = std::find(from, to, 1) != to ? 1 : 0;
      }
      return true;
    };
    forEachPart({0, 0, 0}, starts, 1, spreadLine);
  }

  const World& world_;
  double resolution_m_;
  int depth_;
  Index3 first_{};
  Index3 size_{};
  std::vector<uint8_t> labels_;
};
}  // namespace

std::vector<TrueCell> truthOf(const World& world, const TruthOptions& options,
                              const std::function<bool()>& shouldStop)
{
  requireLegal(options.resolution_m > 0 && std::isfinite(options.resolution_m), "resolution",
               options.resolution_m, "finite and above 0 (metres)");
  requireLegal(options.depthCells >= 1 && options.depthCells <= 1000, "truth depth", options.depthCells,
               "between 1 and 1000 cells");
  LabelGrid grid(world, options);
  if (!grid.labelAll(shouldStop)) return {};
  grid.dropDeepCells();
  return grid.cells();
}

}  // namespace lamap::sim
