#pragma once

#include <mrpt/img/TColor.h>

namespace lamap::tools
{
/// Colours of monotonic brightness; the fraction is clamped to [0, 1].
enum class Palette
{
  Height,    ///< dark blue, green, yellow: viridis
  Variance,  ///< white to dark red
  Prob       ///< white to black
};

[[nodiscard]] mrpt::img::TColor paletteColor(Palette palette, double fraction);

/// The colour with each channel multiplied by a factor in [0, 1].
[[nodiscard]] mrpt::img::TColor darkened(const mrpt::img::TColor& color, double factor);

}  // namespace lamap::tools
