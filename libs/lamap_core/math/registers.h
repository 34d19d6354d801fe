#pragma once

#include <cstring>

/// A function that is to be part of its caller, compiled for the instructions that this one has.
#define LAMAP_INLINED inline __attribute__((always_inline))
/// The same for a lambda, after its parameters.
#define LAMAP_INLINED_LAMBDA __attribute__((always_inline))
#if defined(__x86_64__)
/// A function that only a processor with AVX2 can run.
#define LAMAP_FOR_AVX2 __attribute__((target("avx2")))
#endif

namespace lamap
{
/** Several numbers that are worked on at once.
 *
 * They are aligned to their size. Numbers in memory, aligned each by itself, are loaded and stored, never
 * pointed at: clang drops what a typedef says of a smaller alignment where the type is a template's argument.
 */
template <typename Number, int kLanes>
struct Vector
{
  typedef Number Numbers __attribute__((vector_size(kLanes * sizeof(Number))));

  // By reference: vectors as arguments would depend on the instruction set.
  static LAMAP_INLINED void load(const Number* from, Numbers& to) { std::memcpy(&to, from, sizeof(to)); }
  static LAMAP_INLINED void store(const Numbers& from, Number* to) { std::memcpy(to, &from, sizeof(from)); }
};

/// The registers of a processor: how many numbers can be worked on at once.
template <int kBytes>
struct Registers
{
  static constexpr int kFloats = kBytes / 4;
  static constexpr int kDoubles = kBytes / 8;
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

#ifdef LAMAP_FOR_AVX2
template <typename Body>
LAMAP_FOR_AVX2 auto withAvx2(const Body& body)
{
  return body(Registers<32>{});
}
#endif

/** Runs body(Registers<16>{}), compiled for the architecture's baseline, or body(Registers<32>{}), compiled
 * for AVX2, where the processor has it: the choice is made when the program runs.
 *
 * @param body a generic lambda, marked LAMAP_INLINED_LAMBDA, that calls a LAMAP_INLINED template. Where each
 * number goes through operations of its own, each rounded by itself, the two give the same bits.
 * @param wide as hasAvx2() */
template <typename Body>
auto withRegisters(const Body& body, [[maybe_unused]] bool wide = hasAvx2())
{
#ifdef LAMAP_FOR_AVX2
  if (wide) return withAvx2(body);
#endif
  return body(Registers<16>{});
}

}  // namespace lamap
