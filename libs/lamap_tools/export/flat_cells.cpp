#include <lamap_tools/export/flat_cells.h>
#include <lamap_tools/files/file_output.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>

namespace lamap::tools
{
namespace
{
bool selected(const CellIndex& cell, double resolution_m, const ExportOptions& options)
{
  const double z_m = (cell.z + 0.5) * resolution_m;
  if (options.z_m) return cell.z == std::floor(*options.z_m / resolution_m);
  return (!options.zMin_m || z_m >= *options.zMin_m) && (!options.zMax_m || z_m <= *options.zMax_m);
}

void include(const CellEstimate& estimate, FlatCell& flat)
{
  if (estimate.state == CellState::Unknown) return;
  const auto prob = static_cast<float>(estimate.prob);
  if (flat.state == estimate.state)
    flat.prob = std::max(flat.prob, prob);
  else if (flat.state == CellState::Unknown || estimate.state == CellState::Occupied)
    flat = {estimate.state, prob};
}
}  // namespace

FlatCells flatCellsOf(const CellMap& map, const std::string& path, const ExportOptions& options)
{
  FlatCells flat;
  const auto extent = cellExtent(map, [&](const CellIndex& cell, const CellEstimate&)
                                 { return selected(cell, map.resolution(), options); });
  if (!extent)
  {
    const auto all = cellExtent(map);
    if (!all) throw std::runtime_error(path + ": the map is empty, there is no cell to write");
    throw std::runtime_error(path + ": the map has no cell at the heights asked for; it has cells from z = " +
                             shortest(all->first.z * map.resolution()) + " to " +
                             shortest((all->last.z + 1.0) * map.resolution()) + " m");
  }
  flat.extent = *extent;
  const CellIndex& first = flat.extent.first;
  const CellIndex& last = flat.extent.last;
  flat.width = static_cast<size_t>(int64_t{last.x} - first.x + 1);
  const size_t height = static_cast<size_t>(int64_t{last.y} - first.y + 1);
  constexpr size_t kMostCells = size_t{1} << 31U;
  if (flat.width > kMostCells / height)
    throw std::runtime_error(path + ": it would have " + std::to_string(flat.width) + " x " +
                             std::to_string(height) + " cells, more than 2^31");
  flat.cells.assign(flat.width * height, FlatCell{});
  map.visitCells(
      [&](const CellIndex& cell, const CellEstimate& estimate)
      {
        if (!selected(cell, map.resolution(), options)) return;
        include(estimate, flat.cells[static_cast<size_t>(int64_t{cell.y} - first.y) * flat.width +
                                     static_cast<size_t>(int64_t{cell.x} - first.x)]);
      });
  return flat;
}

}  // namespace lamap::tools
