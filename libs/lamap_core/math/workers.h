#pragma once

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <thread>

namespace lamap
{
/** Deals independent items to threads. Which thread gets what is not fixed, so items must not share what they
 * write: then the number of threads cannot change a result. */
class Workers
{
 public:
  /// @param threads how many may work at once; 0, or more than the machine has: as many as it has
  explicit Workers(unsigned threads)
  {
    const unsigned all = std::max(1u, std::thread::hardware_concurrency());
    threads_ = threads > 0 ? std::min(threads, all) : all;
    if (threads_ > 1) arena_ = std::make_shared<tbb::task_arena>(static_cast<int>(threads_));
  }

  [[nodiscard]] unsigned threads() const { return threads_; }

  /// Calls visit(i) once for each i below count.
  template <typename Visit>
  void forEach(size_t count, Visit&& visit) const
  {
    if (threads_ == 1 || count < 2)
    {
      for (size_t i = 0; i < count; ++i) visit(i);
      return;
    }
    arena_->execute([&] { tbb::parallel_for(size_t{0}, count, visit); });
  }

 private:
  unsigned threads_;
  /// One for all calls: threads hardly ever join an arena that is gone after a millisecond.
  std::shared_ptr<tbb::task_arena> arena_;
};

}  // namespace lamap
