#pragma once

#include <cstddef>

namespace tbb
{
template <typename Index>
class blocked_range
{
 public:
  blocked_range(Index begin, Index end, size_t grainSize = 1)
      : begin_(begin), end_(end), grainSize_(grainSize)
  {
  }

  Index begin() const { return begin_; }
  Index end() const { return end_; }
  size_t grainsize() const { return grainSize_; }
  size_t size() const { return static_cast<size_t>(end_ - begin_); }
  bool empty() const { return !(begin_ < end_); }

 private:
  Index begin_;
  Index end_;
  size_t grainSize_;
};
}  // namespace tbb
