#include <lamap_core/math/portable_math.h>
#include <lamap_sim/random.h>

#include <cmath>

namespace lamap::sim
{
namespace
{
/// Scrambles the bits of a number (splitmix64), so that seeds 1, 2, 3 give unrelated sequences.
uint64_t scrambled(uint64_t bits)
{
  bits += 0x9E3779B97F4A7C15ULL;
  bits = (bits ^ (bits >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  bits = (bits ^ (bits >> 27U)) * 0x94D049BB133111EBULL;
  return bits ^ (bits >> 31U);
}
}  // namespace

SineCosine sineCosine(double angle_rad)
{
  // Reduced to [-π/4, π/4]; π/2 is split into two parts, the first with few enough bits that its product with
  // k is exact.
  constexpr double kHalfPiHigh = 1.5707963267341256;
  constexpr double kHalfPiLow = 6.0771005065061922e-11;
  const double k = std::nearbyint(angle_rad * 0.63661977236758134);
  const double x = (angle_rad - k * kHalfPiHigh) - k * kHalfPiLow;
  double sine = 0;
  double cosine = 0;
  for (int n = 17; n >= 3; n -= 2) sine = (1 + sine) * (-x * x / (n * (n - 1)));
  for (int n = 18; n >= 2; n -= 2) cosine = (1 + cosine) * (-x * x / (n * (n - 1)));
  sine = x * (1 + sine);
  cosine = 1 + cosine;
  switch (static_cast<int64_t>(k) & 3)
  {
    case 0:
      return {sine, cosine};
    case 1:
      return {cosine, -sine};
    case 2:
      return {-sine, -cosine};
    default:
      return {-cosine, sine};
  }
}

Random::Random(uint64_t seed, uint64_t stream) : engine_(scrambled(seed ^ scrambled(stream))) {}

double Random::uniform(double low, double high)
{
  return low + (high - low) * (static_cast<double>(engine_() >> 11U) * 0x1p-53);
}

int Random::integer(int low, int high)
{
  const auto count = static_cast<uint64_t>(int64_t{high} - low) + 1;
  return static_cast<int>(low + static_cast<int64_t>(engine_() % count));
}

double Random::normal()
{
  constexpr double kTwoPi = 6.283185307179586;
  const double aboveZero = 1 - uniform(0, 1);
  const double length = std::sqrt(-2 * portableLog(aboveZero));
  return length * sineCosine(kTwoPi * uniform(0, 1)).cosine;
}

Eigen::Vector3d Random::normal3()
{
  const double x = normal();
  const double y = normal();
  return {x, y, normal()};
}

}  // namespace lamap::sim
