#pragma once

#include <lamap_core/math/exponential.h>
#include <lamap_core/math/registers.h>

namespace lamap
{
/** Several floats that are worked on at once.
 *
 * Each number goes through additions, multiplications and comparisons of its own, each rounded by itself, so
 * how many stand side by side changes no bit. Eight need AVX2 to be fast: code is a template of the number of
 * lanes, run through withRegisters(). */
template <int kLanes>
struct Wide : Vector<float, kLanes>
{
  static constexpr int kCount = kLanes;
  using Floats = typename Vector<float, kLanes>::Numbers;

  /// portableExp(float) of each number, to the last bit.
  static LAMAP_INLINED void exp(Floats& x)
  {
    bound<float, Floats>(x);
    replaceByExp<float, Floats>(x);
  }
};

}  // namespace lamap
