#pragma once

#include <lamap_core/math/registers.h>

#include <cstdint>
#include <cstring>
#include <utility>

namespace lamap
{
/// What e^x is made of, in the precision of Number.
template <typename Number>
struct Exponential;

template <>
struct Exponential<float>
{
  using Word = uint32_t;
  static constexpr float kLowest = -87.0f;
  static constexpr float kHighest = 88.0f;
  static constexpr float kRounder = 0x1.8p23f;
  static constexpr float kPowersOfTwo = 0x1.715476p+0f;  // log2 e
  static constexpr float kLn2High = 0x1.62e4p-1f;
  static constexpr float kLn2Low = 0x1.7f7d1cp-20f;
  static constexpr Word kBias = 127;
  static constexpr int kFractionBits = 23;
  static constexpr float kTaylor[] = {1.0f / 5040.0f, 1.0f / 720.0f, 1.0f / 120.0f, 1.0f / 24.0f,
                                      1.0f / 6.0f,    0.5f,          1.0f,          1.0f};
};

template <>
struct Exponential<double>
{
  using Word = uint64_t;
  static constexpr double kLowest = -708.0;
  static constexpr double kHighest = 709.0;
  static constexpr double kRounder = 0x1.8p52;
  static constexpr double kPowersOfTwo = 0x1.71547652b82fep+0;
  static constexpr double kLn2High = 0x1.62e42feep-1;
  static constexpr double kLn2Low = 0x1.a39ef35793c76p-33;
  static constexpr Word kBias = 1023;
  static constexpr int kFractionBits = 52;
  static constexpr double kTaylor[] = {1.0 / 6227020800.0,
                                       1.0 / 479001600.0,
                                       1.0 / 39916800.0,
                                       1.0 / 3628800.0,
                                       1.0 / 362880.0,
                                       1.0 / 40320.0,
                                       1.0 / 5040.0,
                                       1.0 / 720.0,
                                       1.0 / 120.0,
                                       1.0 / 24.0,
                                       1.0 / 6.0,
                                       0.5,
                                       1.0,
                                       1.0};
};

/// The words that hold the bits of a number, or of several in a vector.
template <typename Number, typename Lanes>
struct BitsOf
{
  using Words = typename Vector<typename Exponential<Number>::Word, sizeof(Lanes) / sizeof(Number)>::Numbers;
};
template <typename Number>
struct BitsOf<Number, Number>
{
  using Words = typename Exponential<Number>::Word;
};

namespace exponential
{
template <typename Number, typename Lanes, size_t... kTerms>
LAMAP_INLINED void sumTaylor(const Lanes& r, Lanes& sum, std::index_sequence<kTerms...> /*terms*/)
{
  ((sum = sum * r + Exponential<Number>::kTaylor[kTerms + 1]), ...);
}
}  // namespace exponential

/** Replaces numbers x by e^x, from additions and multiplications alone: the same bits on every processor, for
 * one number and for several at once. Relative errors: below 2e-7 in float, 1e-15 in double.
 * @tparam Number float or double
 * @tparam Lanes Number, or a vector of several
 * @param x from Exponential<Number>::kLowest to kHighest. By reference: vectors as arguments would depend on
 * the instruction set. */
template <typename Number, typename Lanes>
LAMAP_INLINED void replaceByExp(Lanes& x)
{
  using E = Exponential<Number>;
  // Adding 1.5·2^23 (2^52 in double) rounds to a whole number and leaves it in the low bits.
  const Lanes shifted = x * E::kPowersOfTwo + E::kRounder;
  const Lanes n = shifted - E::kRounder;
  const Lanes r = (x - n * E::kLn2High) - n * E::kLn2Low;
  // Taylor's series on |r| ≤ ln 2 / 2.
  constexpr size_t kTerms = sizeof(E::kTaylor) / sizeof(Number);
  Lanes sum = Lanes{} + E::kTaylor[0];
  exponential::sumTaylor<Number>(r, sum, std::make_index_sequence<kTerms - 1>{});
  typename BitsOf<Number, Lanes>::Words bits;
  std::memcpy(&bits, &shifted, sizeof(bits));
  bits = (bits + E::kBias) << E::kFractionBits;
  Lanes power;
  std::memcpy(&power, &bits, sizeof(power));
  x = sum * power;
}

/// Replaces numbers by the nearest from Exponential<Number>::kLowest to kHighest.
template <typename Number, typename Lanes>
LAMAP_INLINED void bound(Lanes& x)
{
  // Written in this order, each is one instruction, and what is not a number stays so.
  const Lanes lowest = Lanes{} + Exponential<Number>::kLowest;
  const Lanes highest = Lanes{} + Exponential<Number>::kHighest;
  x = lowest > x ? lowest : x;
  x = highest < x ? highest : x;
}

}  // namespace lamap
