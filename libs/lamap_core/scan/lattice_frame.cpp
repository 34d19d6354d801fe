#include <lamap_core/scan/lattice_frame.h>

#include <cmath>

namespace lamap
{
std::optional<HilbertFrame> HilbertFrame::inMap(const Eigen::Vector3d& near_map, double resolution_m,
                                                double spacing_m, std::optional<int32_t> layer)
{
  auto cell = cellAt(near_map, resolution_m);
  if (!cell) return std::nullopt;
  if (layer) cell->z = *layer;
  return atCell(*cell, resolution_m, spacing_m, layer.has_value());
}

std::optional<HilbertFrame> HilbertFrame::atCell(const CellIndex& cell, double resolution_m, double spacing_m,
                                                 bool planar)
{
  const std::array<int32_t, 3> cells = {cell.x, cell.y, cell.z};
  std::array<int32_t, 3> sites{};
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  for (size_t axis = 0; axis < (planar ? 2 : 3); ++axis)
  {
    const double corner = cells[axis] * resolution_m;
    // A corner of a cell on a corner of a site is there, however the product was rounded.
    const double site = std::floor(corner / spacing_m + 1e-6);
    constexpr double kLastSite = 1 << 30;
    if (!(std::abs(site) < kLastSite)) return std::nullopt;
    sites[axis] = static_cast<int32_t>(site);
    origin[static_cast<int>(axis)] = corner - site * spacing_m;
  }
  return HilbertFrame{
      ScanFrame(resolution_m, cell, planar), {sites[0], sites[1], sites[2]}, origin, spacing_m};
}

HilbertFrame HilbertFrame::ofModel(double resolution_m, double spacing_m, bool planar)
{
  return {ScanFrame(resolution_m, {}, planar), {}, Eigen::Vector3d::Zero(), spacing_m};
}

}  // namespace lamap
