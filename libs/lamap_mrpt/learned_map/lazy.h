#pragma once

#include <memory>
#include <mutex>
#include <utility>

namespace lamap
{
/** Something derived from its owner, made on first use.
 *
 * get() may be called from several threads; reset() only by whoever changes the owner. A copy starts empty,
 * because it has another owner. */
template <typename T>
class Lazy
{
 public:
  Lazy() = default;
  Lazy(const Lazy&) {}
  Lazy& operator=(const Lazy&)
  {
    reset();
    return *this;
  }

  /** @param isCurrent returns whether the existing object is still valid.
   *  @param make returns a std::shared_ptr<const T>; called by one thread at a time. */
  template <typename IsCurrent, typename Make>
  [[nodiscard]] std::shared_ptr<const T> get(IsCurrent&& isCurrent, Make&& make) const
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!made_ || !isCurrent(*made_)) made_ = make();
    return made_;
  }

  /// For an object that is valid until reset().
  template <typename Make>
  [[nodiscard]] std::shared_ptr<const T> get(Make&& make) const
  {
    return get([](const T&) { return true; }, make);
  }

  void reset()
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    made_.reset();
  }

 private:
  mutable std::mutex mutex_;
  mutable std::shared_ptr<const T> made_;
};

}  // namespace lamap
