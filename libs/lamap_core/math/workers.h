#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>

namespace lamap
{
/** Deals independent items to threads. Which thread gets what is not fixed, so items must not share what they
 * write: then the number of threads cannot change a result. */
class Workers
{
 public:
  /// @param threads how many may work at once; 0, or more than the machine has: as many as it has
  explicit Workers(unsigned threads);

  [[nodiscard]] unsigned threads() const { return threads_; }

  /// Calls visit(i) once for each i below count.
  template <typename Visit>
  void forEach(size_t count, Visit&& visit) const
  {
    // Compiled once, for one thread and for several: inlined into the caller, hot loops come out slower.
    const auto call = [](void* visitor, size_t i)
    { (*static_cast<std::remove_reference_t<Visit>*>(visitor))(i); };
    deal(count, call, addressOf(visit));
  }

  /// Calls work(), which may use oneTBB itself, with as many threads.
  template <typename Work>
  void run(Work&& work) const
  {
    if (threads_ == 1)
      work();
    else
      enter([](void* called) { (*static_cast<std::remove_reference_t<Work>*>(called))(); }, addressOf(work));
  }

 private:
  class Arena;  ///< of oneTBB, whose headers our users need not have

  template <typename Callable>
  static void* addressOf(Callable& callable)
  {
    return const_cast<std::remove_const_t<Callable>*>(std::addressof(callable));
  }
  void deal(size_t count, void (*call)(void* visitor, size_t i), void* visitor) const;
  void enter(void (*call)(void* work), void* work) const;

  unsigned threads_;
  /// One for all calls: threads hardly ever join an arena that is gone after a millisecond.
  std::shared_ptr<Arena> arena_;
};

/** Workers that stay for the next call with as many threads. A copy has its own. */
class KeptWorkers
{
 public:
  KeptWorkers() = default;
  KeptWorkers(const KeptWorkers&) {}
  KeptWorkers& operator=(const KeptWorkers&) { return *this; }
  KeptWorkers(KeptWorkers&&) noexcept = default;
  KeptWorkers& operator=(KeptWorkers&&) noexcept = default;

  const Workers& with(unsigned threads)
  {
    if (!workers_ || asked_ != threads) workers_.emplace(threads);
    asked_ = threads;
    return *workers_;
  }

 private:
  std::optional<Workers> workers_;
  unsigned asked_ = 0;
};

/** Working memory of type T, made when it is first needed. A copy has its own. T may be incomplete until
 * then. */
template <typename T>
class WorkingMemory
{
 public:
  WorkingMemory() = default;
  WorkingMemory(const WorkingMemory&) {}
  WorkingMemory& operator=(const WorkingMemory&)
  {
    memory_.reset();
    return *this;
  }
  WorkingMemory(WorkingMemory&&) noexcept = default;
  WorkingMemory& operator=(WorkingMemory&&) noexcept = default;

  /// @param arguments of T's constructor, if there is none yet
  template <typename... Arguments>
  T& get(Arguments&&... arguments)
  {
    if (!memory_) memory_ = std::make_shared<T>(std::forward<Arguments>(arguments)...);
    return *memory_;
  }

 private:
  std::shared_ptr<T> memory_;
};

}  // namespace lamap
