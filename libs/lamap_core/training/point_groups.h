#pragma once

#include <lamap_core/scan/scan_frame.h>
#include <tsl/robin_map.h>

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <vector>

namespace lamap
{
/// Points of one group, to be averaged.
struct PointGroup
{
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  uint32_t count = 0;
  double narrowest = 0;  ///< width of its sharpest point
  double weight = 0;     ///< sum of the weights of groups that were added

  [[nodiscard]] Eigen::Vector3d mean() const { return sum / count; }
};

/// Three signed 21-bit coordinates in one number.
[[nodiscard]] inline uint64_t packKey(int64_t x, int64_t y, int64_t z)
{
  constexpr uint64_t kMask = (uint64_t{1} << 21) - 1;
  return (static_cast<uint64_t>(x) & kMask) | (static_cast<uint64_t>(y) & kMask) << 21 |
         (static_cast<uint64_t>(z) & kMask) << 42;
}

/// Of a point's cell. @param local [cells], within ScanFrame::kReach_cells
[[nodiscard]] inline uint64_t cellKey(const Eigen::Vector3d& local)
{
  return packKey(localCell(local.x()), localCell(local.y()), localCell(local.z()));
}

/// Groups points by a key, in the order of each group's first point.
class PointGroups
{
 public:
  void clear()
  {
    numbers_.clear();
    groups_.clear();
  }

  void add(uint64_t key, const Eigen::Vector3d& point, double width)
  {
    PointGroup& group = groupOf(key, point);
    group.narrowest = group.count == 0 ? width : std::min(group.narrowest, width);
    group.sum += point;
    ++group.count;
  }

  void add(uint64_t key, const PointGroup& points)
  {
    PointGroup& group = groupOf(key, points.first);
    group.narrowest = group.count == 0 ? points.narrowest : std::min(group.narrowest, points.narrowest);
    group.sum += points.sum;
    group.count += points.count;
    group.weight += points.weight;
  }

  [[nodiscard]] const std::vector<PointGroup>& groups() const { return groups_; }

 private:
  PointGroup& groupOf(uint64_t key, const Eigen::Vector3d& first)
  {
    if (groups_.empty() || key != lastKey_)
    {
      const auto [entry, added] = numbers_.emplace(key, static_cast<uint32_t>(groups_.size()));
      if (added) groups_.emplace_back().first = first;
      lastKey_ = key;
      lastNumber_ = entry->second;
    }
    return groups_[lastNumber_];
  }

  struct KeyHash
  {
    [[nodiscard]] size_t operator()(uint64_t key) const noexcept
    {
      key *= 0x9E3779B97F4A7C15ULL;
      return static_cast<size_t>(key ^ (key >> 32));
    }
  };

  tsl::robin_map<uint64_t, uint32_t, KeyHash> numbers_;
  std::vector<PointGroup> groups_;
  uint64_t lastKey_ = 0;
  uint32_t lastNumber_ = 0;
};

}  // namespace lamap
