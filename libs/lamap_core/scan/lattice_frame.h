#pragma once

#include <lamap_core/scan/scan_frame.h>

#include <Eigen/Core>
#include <optional>

namespace lamap
{
/** Position of a scan's cells relative to a lattice of features.
 *
 * Site j of a lattice covers [j·h, (j+1)·h) along each axis and has its feature at its centre (j + 1/2)·h,
 * with h the spacing. Positions are in metres from the lowest corner of an anchor site near the sensor, so
 * moving scan and sensor by whole cells that are whole sites too changes no bit of them. In a planar map all
 * positions and all features lie in one plane. */
struct HilbertFrame
{
  ScanFrame cells;               ///< of the scan's cells
  CellIndex anchorSite;          ///< in the lattice's own indices
  Eigen::Vector3d cellOrigin_m;  ///< lowest corner of the anchor cell
  double spacing_m;              ///< h

  /** The frame for a sensor in a map whose lattice is fixed to the map.
   * @param near_map [m]; @param layer of cells, if the map is planar
   * @return nothing where cells or sites cannot be addressed. */
  static std::optional<HilbertFrame> inMap(const Eigen::Vector3d& near_map, double resolution_m,
                                           double spacing_m, std::optional<int32_t> layer);

  /// The frame whose anchor is this cell. @return nothing where sites cannot be addressed.
  static std::optional<HilbertFrame> atCell(const CellIndex& cell, double resolution_m, double spacing_m,
                                            bool planar);

  /// The frame of a model that has its own cells and lattice: both start at the origin. Positions given to
  /// `cells` are to be in that frame [m].
  static HilbertFrame ofModel(double resolution_m, double spacing_m, bool planar);

  /// @param local [cells], from `cells`. @return [m] from the anchor site's corner.
  [[nodiscard]] Eigen::Vector3d position(const Eigen::Vector3d& local) const
  {
    Eigen::Vector3d place = cellOrigin_m + local * cells.resolution_m();
    if (cells.planar()) place.z() = 0.5 * spacing_m;
    return place;
  }
};

}  // namespace lamap
