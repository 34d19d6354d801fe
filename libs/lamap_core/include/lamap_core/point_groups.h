#pragma once

#include <lamap_core/scan_frame.h>
#include <tsl/robin_map.h>

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace lamap
{
/// Points of one group, to be averaged.
struct PointGroup
{
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  uint32_t count = 0;

  [[nodiscard]] Eigen::Vector3d mean() const { return sum / count; }
};

/// Groups points of a scan's frame by their cell, in the order of each cell's first point.
class PointGroups
{
 public:
  void clear()
  {
    numbers_.clear();
    groups_.clear();
  }

  /// @param local [cells], within ScanFrame::kReach_cells
  void add(const Eigen::Vector3d& local)
  {
    const uint64_t key = keyOf(local);
    if (groups_.empty() || key != lastKey_)
    {
      const auto [entry, added] = numbers_.emplace(key, static_cast<uint32_t>(groups_.size()));
      if (added) groups_.emplace_back();
      lastKey_ = key;
      lastNumber_ = entry->second;
    }
    PointGroup& group = groups_[lastNumber_];
    group.sum += local;
    ++group.count;
  }

  [[nodiscard]] const std::vector<PointGroup>& groups() const { return groups_; }

 private:
  struct KeyHash
  {
    [[nodiscard]] size_t operator()(uint64_t key) const noexcept
    {
      key *= 0x9E3779B97F4A7C15ULL;
      return static_cast<size_t>(key ^ (key >> 32));
    }
  };

  /// Three signed 21-bit coordinates in one number.
  [[nodiscard]] static uint64_t keyOf(const Eigen::Vector3d& local)
  {
    constexpr uint64_t kMask = (uint64_t{1} << 21) - 1;
    const auto part = [](double coordinate)
    { return static_cast<uint64_t>(int64_t{localCell(coordinate)}) & kMask; };
    return part(local.x()) | part(local.y()) << 21 | part(local.z()) << 42;
  }

  tsl::robin_map<uint64_t, uint32_t, KeyHash> numbers_;
  std::vector<PointGroup> groups_;
  uint64_t lastKey_ = 0;
  uint32_t lastNumber_ = 0;
};

}  // namespace lamap
