#pragma once

#include <cstddef>
#include <thread>

namespace tbb
{
namespace detail
{
/// How many threads a parallel_for of this thread may use. Two at least: races do not wait for a second core.
inline int& concurrency()
{
  thread_local int threads = static_cast<int>(std::thread::hardware_concurrency()) + 1;
  return threads;
}

/// Which of the threads of the innermost parallel_for this one is.
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

/// Bounds the number of threads of every parallel_for within execute().
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
