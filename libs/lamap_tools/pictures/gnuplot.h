#pragma once

#include <string>

namespace lamap::tools
{
/// @throws std::runtime_error naming what is missing and for which file, if gnuplot cannot be started.
void requireGnuplot(const std::string& forPath);

/** Draws a picture with gnuplot, which must be installed.
 * @param script  what to draw, without terminal and output
 * @param path    a .png, written to a temporary file and renamed when complete
 * @throws std::runtime_error naming the file, with gnuplot's output, if it fails */
void drawWithGnuplot(const std::string& script, const std::string& path, int width_px, int height_px);

/// A string quoted for gnuplot: no character in it is special.
[[nodiscard]] std::string gnuplotText(const std::string& text);

}  // namespace lamap::tools
