#pragma once

#include <lamap_core/math/exponential.h>

#include <cstdint>
#include <cstring>

namespace lamap
{
// Exponentials and logarithms from additions, multiplications and divisions alone. The last bit of the C
// library's own differs between processors; what must come out alike everywhere uses these.

/// e^x; 0 below −708, never beyond e^709.
[[nodiscard]] inline double portableExp(double x) noexcept
{
  double power = x;
  bound<double>(power);
  replaceByExp<double>(power);
  return x < Exponential<double>::kLowest ? 0.0 : power;
}

/// e^x for x in [−87, 88], the nearest of these elsewhere.
[[nodiscard]] inline float portableExp(float x) noexcept
{
  bound<float>(x);
  replaceByExp<float>(x);
  return x;
}

/// log(x) for finite normal x > 0.
[[nodiscard]] inline double portableLog(double x) noexcept
{
  uint64_t bits = 0;
  std::memcpy(&bits, &x, sizeof(bits));
  auto exponent = static_cast<int>(bits >> 52) - 1023;
  bits = (bits & ((uint64_t{1} << 52) - 1)) | uint64_t{1023} << 52;
  double mantissa = 0;
  std::memcpy(&mantissa, &bits, sizeof(mantissa));
  if (mantissa > 1.4142135623730951)
  {
    mantissa *= 0.5;
    ++exponent;
  }
  const double s = (mantissa - 1.0) / (mantissa + 1.0);
  const double s2 = s * s;
  double sum = 0.0;
  for (int n = 23; n >= 1; n -= 2) sum = sum * s2 + 1.0 / n;
  return exponent * 0x1.62e42feep-1 + (2.0 * s * sum + exponent * 0x1.a39ef35793c76p-33);
}

/// P = 1/(1 + e^−f): the probability of log-odds f.
[[nodiscard]] inline double logistic(double logodds) noexcept
{
  return 1.0 / (1.0 + portableExp(-logodds));
}
[[nodiscard]] inline float logistic(float logodds) noexcept
{
  return 1.0f / (1.0f + portableExp(-logodds));
}

}  // namespace lamap
