#pragma once

#include <lamap_core/math/portable_math.h>
#include <lamap_core/math/wide_floats.h>

#include <Eigen/Core>

namespace lamap
{
/// portableExp(float) of four numbers, to the last bit.
[[nodiscard]] inline Eigen::Array4f portableExp(const Eigen::Array4f& x)
{
  Wide<4>::Floats power;
  Wide<4>::load(x.data(), power);
  Wide<4>::exp(power);
  Eigen::Array4f result;
  Wide<4>::store(power, result.data());
  return result;
}

/// logistic(float) of four log-odds, to the last bit.
[[nodiscard]] inline Eigen::Array4f logistic(const Eigen::Array4f& logodds)
{
  return 1.0f / (portableExp(Eigen::Array4f(-logodds)) + 1.0f);
}

}  // namespace lamap
