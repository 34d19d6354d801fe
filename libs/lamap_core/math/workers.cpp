#include <lamap_core/math/workers.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <thread>

namespace lamap
{
class Workers::Arena : public tbb::task_arena
{
 public:
  using tbb::task_arena::task_arena;
};

Workers::Workers(unsigned threads)
{
  const unsigned all = std::max(1u, std::thread::hardware_concurrency());
  threads_ = threads > 0 ? std::min(threads, all) : all;
  if (threads_ > 1) arena_ = std::make_shared<Arena>(static_cast<int>(threads_));
}

void Workers::deal(size_t count, void (*call)(void* visitor, size_t i), void* visitor) const
{
  if (threads_ == 1 || count < 2)
    for (size_t i = 0; i < count; ++i) call(visitor, i);
  else
    arena_->execute([&] { tbb::parallel_for(size_t{0}, count, [&](size_t i) { call(visitor, i); }); });
}

void Workers::enter(void (*call)(void* work), void* work) const
{
  arena_->execute([&] { call(work); });
}

}  // namespace lamap
