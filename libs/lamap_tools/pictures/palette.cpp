#include <lamap_tools/pictures/palette.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace lamap::tools
{
namespace
{
using Stops = std::array<std::array<double, 3>, 9>;

// Matplotlib's viridis at steps of an eighth.
constexpr Stops kHeight = {{{68, 1, 84},
                            {71, 44, 122},
                            {59, 81, 139},
                            {44, 113, 142},
                            {33, 144, 141},
                            {39, 173, 129},
                            {92, 200, 99},
                            {170, 220, 50},
                            {253, 231, 37}}};
// ColorBrewer's OrRd, nine classes.
constexpr Stops kVariance = {{{255, 247, 236},
                              {254, 232, 200},
                              {253, 212, 158},
                              {253, 187, 132},
                              {252, 141, 89},
                              {239, 101, 72},
                              {215, 48, 31},
                              {179, 0, 0},
                              {127, 0, 0}}};

uint8_t channel(double level)
{
  return static_cast<uint8_t>(std::lround(std::clamp(level, 0.0, 255.0)));
}

mrpt::img::TColor between(const Stops& stops, double fraction)
{
  const double position = fraction * static_cast<double>(stops.size() - 1);
  const size_t below = std::min(static_cast<size_t>(position), stops.size() - 2);
  const double share = position - static_cast<double>(below);
  const auto mix = [&](size_t i)
  { return channel(stops[below][i] * (1 - share) + stops[below + 1][i] * share); };
  return {mix(0), mix(1), mix(2)};
}
}  // namespace

mrpt::img::TColor paletteColor(Palette palette, double fraction)
{
  const double inRange = std::isfinite(fraction) ? std::clamp(fraction, 0.0, 1.0) : 0.0;
  if (palette == Palette::Height) return between(kHeight, inRange);
  if (palette == Palette::Variance) return between(kVariance, inRange);
  const uint8_t grey = channel(255.0 * (1 - inRange));
  return {grey, grey, grey};
}

mrpt::img::TColor darkened(const mrpt::img::TColor& color, double factor)
{
  return {channel(color.R * factor), channel(color.G * factor), channel(color.B * factor), color.A};
}

}  // namespace lamap::tools
