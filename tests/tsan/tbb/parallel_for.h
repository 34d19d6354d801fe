#pragma once

#include <tbb/blocked_range.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace tbb
{
namespace detail
{
/// Runs chunk(0) ... chunk(chunks - 1) on several threads, including this one, and waits; rethrows the first
/// exception. A relaxed counter hands out the chunks and orders nothing: only the start and the join do.
template <typename Chunk>
void forkAndJoin(size_t chunks, const Chunk& chunk)
{
  std::atomic<size_t> next{0};
  std::mutex errorMutex;
  std::exception_ptr error;
  const auto work = [&](size_t number)
  {
    const NumberedWorker numbered(number);
    for (size_t i = next.fetch_add(1, std::memory_order_relaxed); i < chunks;
         i = next.fetch_add(1, std::memory_order_relaxed))
    {
      try
      {
        chunk(i);
      }
      catch (...)
      {
        const std::lock_guard<std::mutex> lock(errorMutex);
        if (!error) error = std::current_exception();
      }
    }
  };
  const size_t threadCount = std::min(chunks, static_cast<size_t>(std::max(concurrency(), 1)));
  std::vector<std::thread> others;
  for (size_t i = 1; i < threadCount; ++i) others.emplace_back(work, i);
  work(0);
  for (std::thread& other : others) other.join();
  if (error) std::rethrow_exception(error);
}
}  // namespace detail

template <typename Index, typename Body>
void parallel_for(Index first, Index last, const Body& body)
{
  if (!(first < last)) return;
  detail::forkAndJoin(static_cast<size_t>(last - first),
                      [&](size_t i) { body(static_cast<Index>(first + i)); });
}

template <typename Index, typename Body>
void parallel_for(const blocked_range<Index>& range, const Body& body)
{
  const size_t grain = std::max<size_t>(range.grainsize(), 1);
  detail::forkAndJoin((range.size() + grain - 1) / grain,
                      [&](size_t i)
                      {
                        const size_t end = std::min(range.size(), (i + 1) * grain);
                        body(blocked_range<Index>(range.begin() + static_cast<Index>(i * grain),
                                                  range.begin() + static_cast<Index>(end), grain));
                      });
}
}  // namespace tbb
