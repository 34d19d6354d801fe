#pragma once

#include <lamap_core/math/portable_math.h>

#include <Eigen/Core>

namespace lamap
{
/// portableExp(float) of four numbers, to the last bit, without a branch.
[[nodiscard]] inline Eigen::Array4f portableExp(const Eigen::Array4f& x)
{
  constexpr float kRounder = 0x1.8p23f;
  const Eigen::Array4f bounded = x.max(-87.0f).min(88.0f);
  const Eigen::Array4f scaled = bounded * 0x1.715476p+0f;
  const Eigen::Array4f shifted = scaled + kRounder;
  const Eigen::Array4f n = shifted - kRounder;
  const Eigen::Array4f high = n * 0x1.62e4p-1f;
  const Eigen::Array4f low = n * 0x1.7f7d1cp-20f;
  const Eigen::Array4f r = (bounded - high) - low;
  Eigen::Array4f sum = Eigen::Array4f::Constant(1.0f / 5040.0f);
  for (const float term : {1.0f / 720.0f, 1.0f / 120.0f, 1.0f / 24.0f, 1.0f / 6.0f, 0.5f, 1.0f, 1.0f})
  {
    // Product and sum apart: no processor may fuse them.
    const Eigen::Array4f product = sum * r;
    sum = product + term;
  }
  Eigen::Array<int32_t, 4, 1> bits;
  std::memcpy(bits.data(), shifted.data(), 4 * sizeof(float));
  bits = (bits + 127).shiftLeft<23>();
  Eigen::Array4f power;
  std::memcpy(power.data(), bits.data(), 4 * sizeof(float));
  return sum * power;
}

/// logistic(float) of four log-odds, to the last bit.
[[nodiscard]] inline Eigen::Array4f logistic(const Eigen::Array4f& logodds)
{
  const Eigen::Array4f negative = -logodds;
  const Eigen::Array4f divisor = portableExp(negative) + 1.0f;
  return 1.0f / divisor;
}

}  // namespace lamap
