#include <lamap_tools/cells/cell_table.h>

#include <algorithm>
#include <map>
#include <tuple>

namespace lamap::tools
{
bool inTableOrder(const CellIndex& a, const CellIndex& b)
{
  return std::tie(a.z, a.y, a.x) < std::tie(b.z, b.y, b.x);
}

namespace
{
void sortRows(std::vector<CellRow>& rows)
{
  std::sort(rows.begin(), rows.end(),
            [](const CellRow& a, const CellRow& b) { return inTableOrder(a.index, b.index); });
}
}  // namespace

void CellExtent::include(const CellIndex& cell)
{
  first = {std::min(first.x, cell.x), std::min(first.y, cell.y), std::min(first.z, cell.z)};
  last = {std::max(last.x, cell.x), std::max(last.y, cell.y), std::max(last.z, cell.z)};
}

Eigen::AlignedBox3d CellExtent::box_m(double resolution_m) const
{
  const double r = resolution_m;
  return {Eigen::Vector3d(first.x * r, first.y * r, first.z * r),
          Eigen::Vector3d((last.x + 1.0) * r, (last.y + 1.0) * r, (last.z + 1.0) * r)};
}

std::optional<CellExtent> cellExtent(const CellMap& map, const ShownCells& shown)
{
  std::optional<CellExtent> extent;
  map.visitCells(
      [&](const CellIndex& cell, const CellEstimate& estimate)
      {
        if (shown && !shown(cell, estimate)) return;
        if (!extent) extent = CellExtent{cell, cell};
        extent->include(cell);
      });
  return extent;
}

void visitCellsSorted(const CellMap& map, const std::function<void(const CellRow&)>& visitor,
                      size_t maxRowsInMemory)
{
  std::map<int32_t, size_t> cellsOfLayer;
  map.visitCells([&](const CellIndex& cell, const CellEstimate&) { ++cellsOfLayer[cell.z]; });

  std::vector<CellRow> rows;
  for (auto layer = cellsOfLayer.begin(); layer != cellsOfLayer.end();)
  {
    const int32_t firstZ = layer->first;
    int32_t lastZ = firstZ;
    size_t count = 0;
    while (layer != cellsOfLayer.end() && (count == 0 || count + layer->second <= maxRowsInMemory))
    {
      count += layer->second;
      lastZ = layer->first;
      ++layer;
    }
    rows.clear();
    rows.reserve(count);
    map.visitCells(
        [&](const CellIndex& cell, const CellEstimate& estimate)
        {
          if (cell.z >= firstZ && cell.z <= lastZ) rows.push_back({cell, estimate});
        });
    sortRows(rows);
    for (const CellRow& row : rows) visitor(row);
  }
}

}  // namespace lamap::tools
