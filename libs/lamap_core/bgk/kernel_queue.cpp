#include <lamap_core/bgk/kernel_queue.h>

#include <lamap_core/math/registers.h>

#include <cmath>
#include <vector>

namespace lamap
{
namespace
{
/// Horner's rule for kVectors vectors of numbers at once: each waits for none of the others.
/// @param coefficients highest power first
template <typename Lanes, int kVectors>
LAMAP_INLINED void horner(const std::vector<double>& coefficients, const double* x, double* result)
{
  using Some = Vector<double, Lanes::kDoubles>;
  typename Some::Numbers power[kVectors];
  typename Some::Numbers sum[kVectors];
#pragma GCC unroll 8
  for (int i = 0; i < kVectors; ++i)
  {
    Some::load(x + i * Lanes::kDoubles, power[i]);
    sum[i] = power[i] - power[i];
  }
  for (const double coefficient : coefficients)
  {
#pragma GCC unroll 8
    for (int i = 0; i < kVectors; ++i) sum[i] = sum[i] * power[i] + coefficient;
  }
#pragma GCC unroll 8
  for (int i = 0; i < kVectors; ++i) Some::store(sum[i], result + i * Lanes::kDoubles);
}

}  // namespace

/// @param count of the numbers; those up to the next multiple of kAtOnce may hold anything finite
template <typename Lanes>
LAMAP_INLINED void KernelQueue::evaluate(size_t count)
{
  constexpr int kVectors = 4;
  constexpr size_t kStep = static_cast<size_t>(kVectors * Lanes::kDoubles);
  static_assert(kAtOnce % kStep == 0);
  const double inverseSupport = kernel_.inverseSupport_;
  const double kernelScale = kernel_.scale_;
  for (size_t first = 0; first < count; first += kStep)
  {
    double* const r = radii_.data() + first;
    alignas(32) double s[kStep];
    alignas(32) double s2[kStep];
    alignas(32) double series[kStep];
    for (size_t i = 0; i < kStep; ++i)
    {
      r[i] = std::sqrt(squared_[first + i]) * inverseSupport;
      const double inside = 1.0 - r[i];
      s[i] = inside > 0.0 ? inside : 0.0;
      s2[i] = s[i] * s[i];
    }
    horner<Lanes, kVectors>(kernel_.inSquaredS_, s2, series);
    double* const weights = weights_.data() + first;
    if (kernel_.fifthPower_)
      for (size_t i = 0; i < kStep; ++i) weights[i] = s2[i] * s2[i] * s[i] * series[i];
    else
      for (size_t i = 0; i < kStep; ++i) weights[i] = s2[i] * s2[i] * series[i];
    if (!kernel_.inR_.empty())
    {
      horner<Lanes, kVectors>(kernel_.inR_, r, series);
      for (size_t i = 0; i < kStep; ++i) weights[i] *= series[i];
    }
    for (size_t i = 0; i < kStep; ++i)
    {
      const double weight = weights[i] * kernelScale;
      weights[i] = factors_[first + i] * (weights[i] < 1.0 ? weight : kernelScale);
    }
  }
}

void KernelQueue::flush()
{
  if (count_ == 0) return;
  for (size_t i = count_; i % kAtOnce != 0; ++i) squared_[i] = factors_[i] = 0.0;
  withRegisters([&](auto lanes) LAMAP_INLINED_LAMBDA { evaluate<decltype(lanes)>(count_); });
  for (size_t i = 0; i < count_; ++i) sums_[cells_[i]] += scale_.quantized(weights_[i]);
  count_ = 0;
}

}  // namespace lamap
