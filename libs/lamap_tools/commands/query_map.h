#pragma once

#include <lamap_tools/cells/cell_map.h>
#include <lamap_tools/cells/truth.h>
#include <lamap_tools/report/json.h>
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

/** Points on surfaces, for the distances of MapGeometry. @throws as readPointsFile(), and for a file without
 * points */
void readSurface(const std::string& path, Truth& truth);

/** A line for each point, after a header: x,y,z,prob,variance,state and the map's evidence. Where the map
 * says nothing the state is "unobserved" and the numbers are empty. */
void writeAnswersCsv(const CellMap& map, const std::vector<mrpt::math::TPoint3D>& points, std::ostream& out);

/// The same as an array of objects; null where there is no number.
[[nodiscard]] Json answersJson(const CellMap& map, const std::vector<mrpt::math::TPoint3D>& points);

}  // namespace lamap::tools
