#pragma once

#include <lamap_core/grid/evidence.h>

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

namespace lamap
{
/// Calls visit(block) for the blocks from one to another, x fastest.
template <typename Visit>
void forEachBlock(const BlockIndex& low, const BlockIndex& high, Visit&& visit)
{
  for (int32_t z = low.z; z <= high.z; ++z)
    for (int32_t y = low.y; y <= high.y; ++y)
      for (int32_t x = low.x; x <= high.x; ++x) visit(BlockIndex{x, y, z});
}

/** Items (points, segments) listed by the numbers of the blocks that they reach. */
class BlockLists
{
 public:
  void clear() { entries_.clear(); }
  void add(int32_t block, uint32_t item) { entries_.push_back({block, item}); }
  /// Sorts by block, items of one block in the order they were added.
  void sort(size_t blockCount);

  struct Range
  {
    const uint32_t* first;
    const uint32_t* last;
    [[nodiscard]] const uint32_t* begin() const { return first; }
    [[nodiscard]] const uint32_t* end() const { return last; }
  };
  [[nodiscard]] Range of(size_t block) const
  {
    return {items_.data() + begins_[block], items_.data() + begins_[block + 1]};
  }
  [[nodiscard]] bool empty() const { return entries_.empty(); }

 private:
  struct Entry
  {
    int32_t block;
    uint32_t item;
  };
  std::vector<Entry> entries_;
  std::vector<uint32_t> begins_;
  std::vector<uint32_t> items_;
};

/** Numbers of scan blocks, those together that one block of a map holds. */
class BlockGroups
{
 public:
  struct Group
  {
    BlockIndex place;  ///< of the group, in blocks as large as the larger of the two
    const uint32_t* first;
    const uint32_t* last;
    [[nodiscard]] const uint32_t* begin() const { return first; }
    [[nodiscard]] const uint32_t* end() const { return last; }
  };

  /// @param placeOf(number) place of a scan block's group; @param distinct whether no two share a place
  template <typename PlaceOf>
  void form(size_t count, bool distinct, PlaceOf&& placeOf)
  {
    placed_.clear();
    placed_.reserve(count);
    for (uint32_t i = 0; i < count; ++i) placed_.emplace_back(placeOf(i), i);
    if (!distinct)
      std::stable_sort(placed_.begin(), placed_.end(),
                       [](const auto& a, const auto& b) { return a.first < b.first; });
    numbers_.resize(count);
    groups_.clear();
    for (uint32_t i = 0; i < count; ++i)
    {
      numbers_[i] = placed_[i].second;
      if (i == 0 || !(placed_[i - 1].first == placed_[i].first))
        groups_.push_back({placed_[i].first, &numbers_[i], nullptr});
      groups_.back().last = &numbers_[i] + 1;
    }
  }
  [[nodiscard]] const std::vector<Group>& all() const { return groups_; }

 private:
  std::vector<std::pair<BlockIndex, uint32_t>> placed_;
  std::vector<uint32_t> numbers_;
  std::vector<Group> groups_;
};

}  // namespace lamap
