#include <lamap_tools/pictures/palette.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace lamap::tools
{
namespace
{
/// Red, green and blue, a byte each.
using Stops = std::array<uint32_t, 9>;

// Matplotlib's viridis at steps of an eighth.
constexpr Stops kHeight{0x440154, 0x472c7a, 0x3b518b, 0x2c718e, 0x21908d,
                        0x27ad81, 0x5cc863, 0xaadc32, 0xfde725};
// ColorBrewer's OrRd, nine classes.
constexpr Stops kVariance{0xfff7ec, 0xfee8c8, 0xfdd49e, 0xfdbb84, 0xfc8d59,
                          0xef6548, 0xd7301f, 0xb30000, 0x7f0000};

uint8_t channel(double level)
{
  return static_cast<uint8_t>(std::lround(std::clamp(level, 0.0, 255.0)));
}

mrpt::img::TColor between(const Stops& stops, double fraction)
{
  const double position = fraction * static_cast<double>(stops.size() - 1);
  const size_t below = std::min(static_cast<size_t>(position), stops.size() - 2);
  const double share = position - static_cast<double>(below);
  const auto mix = [&](unsigned shift)
  {
    const auto level = [&](uint32_t stop) { return static_cast<double>(stop >> shift & 0xFFU); };
    return channel(level(stops[below]) * (1 - share) + level(stops[below + 1]) * share);
  };
  return {mix(16), mix(8), mix(0)};
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
