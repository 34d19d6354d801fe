#pragma once

#include <lamap_tools/cells/cell_table.h>

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

namespace lamap::test
{
/// All finest cells of a map in memory, sorted by z, y, x: for lookups.
struct CellTable
{
  std::string className;                   ///< of the map it was read from
  double resolution_m = 0;                 ///< edge of a cell [m]
  std::vector<std::string> evidenceNames;  ///< of CellEstimate::evidence
  std::vector<tools::CellRow> rows;        ///< in table order, each cell once

  /// The row of a cell; nullptr where the map has no evidence.
  [[nodiscard]] const tools::CellRow* find(const CellIndex& cell) const
  {
    const auto row = std::lower_bound(rows.begin(), rows.end(), cell,
                                      [](const tools::CellRow& a, const CellIndex& b)
                                      { return tools::inTableOrder(a.index, b); });
    return row != rows.end() && row->index == cell ? &*row : nullptr;
  }
};

[[nodiscard]] inline CellTable readCellTable(const tools::CellMap& map)
{
  CellTable table{map.className(), map.resolution(), map.evidenceNames(), {}};
  tools::visitCellsSorted(
      map, [&](const tools::CellRow& row) { table.rows.push_back(row); }, std::numeric_limits<size_t>::max());
  return table;
}
/// @throws as openCellMap.
[[nodiscard]] inline CellTable readCellTable(const std::string& path)
{
  return readCellTable(*tools::openCellMap(path));
}

}  // namespace lamap::test
