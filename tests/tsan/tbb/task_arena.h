#pragma once

#include <cstddef>
#include <thread>

namespace tbb
{
namespace detail
{
/// Number of threads for a parallel_for of this thread. At least two, so that races show on a single core.
inline int& concurrency()
{
  thread_local int threads = static_cast<int>(std::thread::hardware_concurrency()) + 1;
  return threads;
}

/// The number of this thread within the innermost parallel_for.
inline size_t& workerNumber()
{
  thread_local size_t number = 0;
  return number;
}

class NumberedWorker
{
 public:
  explicit NumberedWorker(size_t number) { workerNumber() = number; }
  ~NumberedWorker() { workerNumber() = before_; }
  NumberedWorker(const NumberedWorker&) = delete;
  NumberedWorker& operator=(const NumberedWorker&) = delete;

 private:
  size_t before_ = workerNumber();
};
}  // namespace detail

/// Limits the number of threads of every parallel_for within execute().
class task_arena
{
 public:
  explicit task_arena(int maxConcurrency) : maxConcurrency_(maxConcurrency) {}

  template <typename Function>
  decltype(auto) execute(Function&& function)
  {
    struct Restore
    {
      int before = detail::concurrency();
      ~Restore() { detail::concurrency() = before; }
    } restore;
    detail::concurrency() = maxConcurrency_;
    return function();
  }

 private:
  int maxConcurrency_;
};
}  // namespace tbb
