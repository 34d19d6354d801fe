#pragma once

#include <tbb/task_arena.h>

#include <array>
#include <functional>
#include <memory>
#include <stdexcept>
#include <utility>

namespace tbb
{
/** One T for each thread of a parallel_for that asks for it, made by the given function.
 *
 * Has no lock, which would order the bodies of different threads, unlike TBB.
 */
template <typename T>
class enumerable_thread_specific
{
  static constexpr size_t kMostThreads = 256;
  using Slots = std::array<std::unique_ptr<T>, kMostThreads>;

 public:
  class iterator
  {
   public:
    iterator(Slots& slots, size_t at) : slots_(slots), at_(at) { skipEmpty(); }
    T& operator*() const { return *slots_[at_]; }
    iterator& operator++()
    {
      ++at_;
      skipEmpty();
      return *this;
    }
    bool operator!=(const iterator& other) const { return at_ != other.at_; }

   private:
    void skipEmpty()
    {
      while (at_ < kMostThreads && !slots_[at_]) ++at_;
    }
    Slots& slots_;
    size_t at_;
  };

  explicit enumerable_thread_specific(std::function<T()> make) : make_(std::move(make)) {}

  T& local()
  {
    if (detail::workerNumber() >= kMostThreads)
      throw std::length_error("more threads than this stand-in is made for");
    std::unique_ptr<T>& slot = slots_[detail::workerNumber()];
    if (!slot) slot = std::make_unique<T>(make_());
    return *slot;
  }

  /// Only for use once all other threads have finished.
  iterator begin() { return {slots_, 0}; }
  iterator end() { return {slots_, kMostThreads}; }

 private:
  std::function<T()> make_;
  Slots slots_;
};
}  // namespace tbb
