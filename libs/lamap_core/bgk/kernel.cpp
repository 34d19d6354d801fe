#include <lamap_core/bgk/kernel.h>

#include <lamap_core/options/legal_range.h>

namespace lamap
{
namespace
{
constexpr double kTwoPi = 6.283185307179586476925286766559;
constexpr double kSqrt3 = 1.7320508075688772935274463415059;

/** Eq. (4.10) with r = 1 − s: s(2 + cos 2πs)/3 − sin(2πs)/2π = Σₙ (−1)ⁿ (2π)²ⁿ [1/(3·(2n)!) − 1/(2n+1)!]
 * s²ⁿ⁺¹, whose first two terms vanish. Terms beyond n = 22 are below 1e-18. */
std::vector<double> sparseSeries()
{
  constexpr int kLast = 22;
  std::vector<double> highestFirst(kLast - 1);
  double term = 1.0;  // (2π)²ⁿ/(2n)!
  for (int n = 0; n <= kLast; ++n)
  {
    if (n > 0) term *= kTwoPi * kTwoPi / ((2.0 * n - 1.0) * (2.0 * n));
    const double sign = n % 2 == 0 ? 1.0 : -1.0;
    if (n >= 2)
      highestFirst[static_cast<size_t>(kLast - n)] = sign * term * (1.0 / 3.0 - 1.0 / (2.0 * n + 1.0));
  }
  return highestFirst;
}

/// (1 + x)·exp(−x) = Σₙ (−1)ⁿ (1 − n) xⁿ/n!, with x = √3 r. Terms beyond n = 27 are below 1e-19.
std::vector<double> matern32Series()
{
  constexpr int kLast = 27;
  std::vector<double> highestFirst(kLast + 1);
  double power = 1.0;  // √3ⁿ/n!
  for (int n = 0; n <= kLast; ++n)
  {
    if (n > 0) power *= kSqrt3 / n;
    const double sign = n % 2 == 0 ? 1.0 : -1.0;
    highestFirst[static_cast<size_t>(kLast - n)] = sign * (1.0 - n) * power;
  }
  return highestFirst;
}

}  // namespace

Kernel::Kernel(KernelShape shape, double support, double scale)
    : support_(support),
      squaredSupport_(support * support),
      inverseSupport_(1.0 / support),
      scale_(scale),
      fifthPower_(shape != KernelShape::WendlandC2)
{
  requireLegal(support > 0 && std::isfinite(support), "kernelSupport", support, "a finite length > 0");
  requireLegal(scale > 0 && std::isfinite(scale), "kernelScale", scale, "a finite number > 0");
  switch (shape)
  {
    case KernelShape::Sparse:
      inSquaredS_ = sparseSeries();
      break;
    case KernelShape::SparseMatern32:
      inSquaredS_ = sparseSeries();
      inR_ = matern32Series();
      break;
    case KernelShape::WendlandC2:
      inSquaredS_ = {1.0};
      inR_ = {4.0, 1.0};
      break;
  }
}

}  // namespace lamap
