#pragma once

#include <lamap_core/bgk/kernel.h>
#include <lamap_core/grid/weight_scale.h>

#include <array>
#include <cstddef>
#include <cstdint>

namespace lamap
{
/** Distances at which a kernel is to be evaluated, and the cells to whose sums its weights are added: many at
 * once, which takes a fraction of the time. Each weight is that of Kernel::atSquaredDistance(), to the last
 * bit. */
class KernelQueue
{
 public:
  KernelQueue(const Kernel& kernel, const WeightScale& scale, BlockSums& sums)
      : kernel_(kernel), scale_(scale), sums_(sums)
  {
  }
  ~KernelQueue() { flush(); }
  KernelQueue(const KernelQueue&) = delete;
  KernelQueue& operator=(const KernelQueue&) = delete;

  /// The next push() calls, so many at most, find room.
  void reserve(size_t count)
  {
    if (count_ + count > kRoom) flush();
  }
  /** Adds factor · k to the sum of a cell, later. Only after reserve().
   * @param isWithin the squared distance is below that of the support; else nothing is added */
  void push(double squaredDistance, bool isWithin, double factor, size_t cell)
  {
    squared_[count_] = squaredDistance;
    factors_[count_] = factor;
    cells_[count_] = static_cast<uint16_t>(cell);
    count_ += isWithin ? 1 : 0;
    any_ = any_ || isWithin;
  }

  /// Whether anything was ever added.
  [[nodiscard]] bool any() const { return any_; }

 private:
  static constexpr size_t kRoom = 256;
  static constexpr size_t kAtOnce = 16;
  using Numbers = std::array<double, kRoom + kAtOnce>;

  void flush();
  template <typename Lanes>
  void evaluate(size_t count);

  const Kernel& kernel_;
  WeightScale scale_;
  BlockSums& sums_;
  size_t count_ = 0;
  bool any_ = false;
  // The first numbers are in use; one more may be written.
  alignas(32) Numbers squared_;
  alignas(32) Numbers factors_;
  alignas(32) Numbers radii_;
  alignas(32) Numbers weights_;
  std::array<uint16_t, kRoom + 1> cells_;
};

}  // namespace lamap
