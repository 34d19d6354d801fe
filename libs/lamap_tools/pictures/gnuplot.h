#pragma once

#include <string>

namespace lamap::tools
{
/// @throws std::runtime_error saying what is missing and for which file, unless gnuplot can be started.
void requireGnuplot(const std::string& forPath);

/** Draws a picture with gnuplot, which must be installed.
 * @param script  what to draw, without terminal and output
 * @param path    a .png, written beside its place and renamed when whole
 * @throws std::runtime_error naming the file, with what gnuplot said, if it fails */
void drawWithGnuplot(const std::string& script, const std::string& path, int width_px, int height_px);

/// A text in quotes, as gnuplot reads it: nothing in it is special.
[[nodiscard]] std::string gnuplotText(const std::string& text);

}  // namespace lamap::tools
