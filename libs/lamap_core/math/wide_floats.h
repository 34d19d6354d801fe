#pragma once

#include <cstdint>
#include <cstring>

/// A function that is to be part of its caller, compiled for the instructions that this one has.
#define LAMAP_INLINED inline __attribute__((always_inline))
#if defined(__x86_64__)
/// A function that only a processor with AVX2 can run.
#define LAMAP_FOR_AVX2 __attribute__((target("avx2")))
#endif

namespace lamap
{
/** Several floats that are worked on at once.
 *
 * Each number goes through additions, multiplications and comparisons of its own, each rounded by itself, so
 * how many stand side by side changes no bit. Eight need AVX2 to be fast: code is a template of the number of
 * lanes, inlined (LAMAP_INLINED) into one function for the baseline and one for AVX2 (LAMAP_FOR_AVX2), and
 * hasAvx2() chooses when the program runs. */
template <int kLanes>
struct Wide
{
  static constexpr int kCount = kLanes;
  typedef float Floats __attribute__((vector_size(kLanes * sizeof(float))));
  typedef uint32_t Words __attribute__((vector_size(kLanes * sizeof(uint32_t))));

  // By reference: vectors as arguments would depend on the instruction set.
  static LAMAP_INLINED void load(const float* from, Floats& to) { std::memcpy(&to, from, sizeof(to)); }
  static LAMAP_INLINED void store(const Floats& from, float* to) { std::memcpy(to, &from, sizeof(from)); }

  /// portableExp(float) of each number, to the last bit.
  static LAMAP_INLINED void exp(Floats& x)
  {
    const Floats lowest = Floats{} - 87.0f;
    const Floats highest = Floats{} + 88.0f;
    constexpr float kRounder = 0x1.8p23f;
    Floats bounded = x > lowest ? x : lowest;  // one instruction, written in this order
    bounded = bounded < highest ? bounded : highest;
    const Floats shifted = bounded * 0x1.715476p+0f + kRounder;
    const Floats n = shifted - kRounder;
    const Floats r = (bounded - n * 0x1.62e4p-1f) - n * 0x1.7f7d1cp-20f;
    Floats sum = Floats{} + 1.0f / 5040.0f;
    sum = sum * r + 1.0f / 720.0f;
    sum = sum * r + 1.0f / 120.0f;
    sum = sum * r + 1.0f / 24.0f;
    sum = sum * r + 1.0f / 6.0f;
    sum = sum * r + 0.5f;
    sum = sum * r + 1.0f;
    sum = sum * r + 1.0f;
    Words bits;
    std::memcpy(&bits, &shifted, sizeof(bits));
    bits = (bits + 127u) << 23u;
    Floats power;
    std::memcpy(&power, &bits, sizeof(power));
    x = sum * power;
  }
};

/// Whether this processor, and its system, have AVX2.
[[nodiscard]] inline bool hasAvx2()
{
#if defined(__x86_64__)
  static const bool kHas = __builtin_cpu_supports("avx2") != 0;
  return kHas;
#else
  return false;
#endif
}

}  // namespace lamap
