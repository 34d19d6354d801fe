#pragma once

#include <lamap_tools/cells/truth.h>
#include <lamap_tools/commands/compare.h>
#include <lamap_tools/report/text_table.h>

#include <string>

namespace lamap::tools
{
enum class ForWhom
{
  People,   ///< few digits, units that are easily read
  Programs  ///< all digits, one number per field
};

/// The one table of a comparison: a head, and a row per map.
[[nodiscard]] TextTable comparisonTable(const Comparison& comparison, ForWhom forWhom);

/** Writes a page that holds all it shows: the table, and each map (and the truth, where there is one) from
 * above and in 3D, all framed alike. What cannot be drawn is said in its place.
 * @param truth  may be null. @throws std::runtime_error naming the file if it cannot be written */
void writeComparisonPage(const Comparison& comparison, const Truth* truth, const std::string& path);

}  // namespace lamap::tools
