#pragma once

#include <lamap_tools/cells/cell_map.h>
#include <lamap_tools/report/json.h>
#include <mrpt/math/TPoint3D.h>

#include <iosfwd>
#include <vector>

namespace lamap::tools
{
/** A line for each point, after a header: x,y,z,prob,variance,state and the map's evidence. Where the map
 * says nothing the state is "unobserved" and the numbers are empty. */
void writeAnswersCsv(const CellMap& map, const std::vector<mrpt::math::TPoint3D>& points, std::ostream& out);

/// The same as an array of objects; null where there is no number.
[[nodiscard]] Json answersJson(const CellMap& map, const std::vector<mrpt::math::TPoint3D>& points);

}  // namespace lamap::tools
