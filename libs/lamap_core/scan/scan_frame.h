#pragma once

#include <lamap_core/grid/cell.h>
#include <lamap_core/scan/scan.h>

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <optional>

namespace lamap
{
/// The cell, along an axis, that holds a coordinate in cells. @param coordinate within ±(2^31 − 1)
[[nodiscard]] inline int32_t localCell(double coordinate)
{
  const auto truncated = static_cast<int32_t>(coordinate);
  return truncated - (coordinate < truncated ? 1 : 0);
}

/** A frame whose unit is one cell and whose origin is the lowest corner of an anchor cell near the sensor.
 *
 * Positions in it are small numbers, so that arithmetic is the same wherever on the map a scan was taken:
 * moving scan and sensor by whole cells changes no bit of them. In a planar map all positions lie in the
 * middle of the layer. */
class ScanFrame
{
 public:
  /// Cells farther than this from the anchor are outside.
  static constexpr double kReach_cells = 1 << 17;

  ScanFrame(double resolution_m, const CellIndex& anchor, bool planar)
      : resolution_m_(resolution_m), anchor_(anchor), planar_(planar)
  {
  }

  /** The frame of a scan, anchored where the rays of its first fan come from that cells can address; at cell
   * 0 if none can be.
   * @param layer of a planar map, which the anchor is in */
  [[nodiscard]] static ScanFrame around(const Scan& scan, double resolution_m, std::optional<int32_t> layer);

  [[nodiscard]] double resolution_m() const { return resolution_m_; }
  [[nodiscard]] const CellIndex& anchor() const { return anchor_; }
  [[nodiscard]] bool planar() const { return planar_; }

  /// @param point_map [m]. @return [cells]; nothing where it is outside.
  [[nodiscard]] std::optional<Eigen::Vector3d> toLocal(const Eigen::Vector3d& point_map) const
  {
    Eigen::Vector3d local;
    const std::array<int32_t, 3> anchor = {anchor_.x, anchor_.y, anchor_.z};
    const int axes = planar_ ? 2 : 3;
    for (int axis = 0; axis < axes; ++axis)
    {
      const double inCells = point_map[axis] / resolution_m_;
      if (!(std::abs(inCells) < kMostCells)) return std::nullopt;
      const int32_t cell = localCell(inCells);
      const int64_t fromAnchor = int64_t{cell} - anchor[static_cast<size_t>(axis)];
      if (std::abs(fromAnchor) >= static_cast<int64_t>(kReach_cells)) return std::nullopt;
      // Just below a cell's upper face the fraction may round to 1, which would be the next cell.
      constexpr double kBelowOne = 1.0 - 0x1p-53;
      local[axis] = static_cast<double>(fromAnchor) + std::min(inCells - cell, kBelowOne);
    }
    if (planar_) local.z() = 0.5;
    return local;
  }

  /// @param localOrigin [cells] of a ray; @param ray_map its vector [m].
  /// @return its end [cells]; nothing where it is outside.
  [[nodiscard]] std::optional<Eigen::Vector3d> endOfRay(const Eigen::Vector3d& localOrigin,
                                                        const Eigen::Vector3d& ray_map) const
  {
    Eigen::Vector3d local = localOrigin + ray_map / resolution_m_;
    if (planar_) local.z() = localOrigin.z();
    if (!(local.cwiseAbs().maxCoeff() < kReach_cells)) return std::nullopt;
    return local;
  }

 private:
  static constexpr double kMostCells = INT32_MAX;

  double resolution_m_;
  CellIndex anchor_;
  bool planar_;
};

[[nodiscard]] inline CellIndex cellOfLocal(const Eigen::Vector3d& local)
{
  return {localCell(local.x()), localCell(local.y()), localCell(local.z())};
}

}  // namespace lamap
