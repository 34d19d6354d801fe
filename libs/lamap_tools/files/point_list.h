#pragma once

#include <mrpt/math/TPoint3D.h>

#include <iosfwd>
#include <string>
#include <vector>

namespace lamap::tools
{
/// One point from "x,y,z" [m]. @throws UsageError naming the text and what is wrong.
[[nodiscard]] mrpt::math::TPoint3D parsePoint(const std::string& text);

/** Points [m, map frame] from a text: one per line, x y z separated by commas, semicolons or blanks; empty
 * lines and lines that begin with # are left out. The first line may be a header; then x, y and z are taken
 * from the columns of that name and other columns are left out, so that a map's or a truth's CSV can be read.
 * @param name  of the text, for messages
 * @throws std::runtime_error naming the text, the number of the line and what is wrong with it */
[[nodiscard]] std::vector<mrpt::math::TPoint3D> readPoints(std::istream& in, const std::string& name);

/// readPoints of a file, or of the standard input if the path is "-". @throws also if it cannot be opened.
[[nodiscard]] std::vector<mrpt::math::TPoint3D> readPointsFile(const std::string& path);

}  // namespace lamap::tools
