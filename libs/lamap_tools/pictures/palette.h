#pragma once

#include <mrpt/img/TColor.h>

namespace lamap::tools
{
/// Colours that keep their order of brightness; fraction in [0, 1], anything else is clamped.
enum class Palette
{
  Height,    ///< dark blue, green, yellow: viridis
  Variance,  ///< white to dark red
  Prob       ///< white to black
};

[[nodiscard]] mrpt::img::TColor paletteColor(Palette palette, double fraction);

/// The colour with every channel times a factor in [0, 1].
[[nodiscard]] mrpt::img::TColor darkened(const mrpt::img::TColor& color, double factor);

}  // namespace lamap::tools
