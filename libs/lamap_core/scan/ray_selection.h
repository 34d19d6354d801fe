#pragma once

#include <lamap_core/grid/cell.h>
#include <lamap_core/scan/scan.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace lamap
{
/// Which rays of a scan are used, and how far. Lengths in metres.
struct RangeLimits
{
  double min_m = 0;  ///< returns nearer than this are left out; also what the observation states
  double max_m = 0;  ///< 0: what the observation states, unlimited where it states none
  bool noReturnIsFree = true;
  uint32_t decimation =
      1;  ///< every so many-th ray, counted through the scan: returns, then no-returns, fan by fan

  /// @throws std::invalid_argument naming the option (minRange, maxRange, rayDecimation), its value and what
  /// is legal.
  void validate() const;
};

/// What became of the rays of a scan.
struct RayCounts
{
  size_t hits = 0;       ///< used, with their end
  size_t freeOnly = 0;   ///< used as free space only: without return, or cut at the maximum range
  size_t decimated = 0;  ///< not looked at
  size_t notFinite = 0;  ///< NaN or infinite: left out
  size_t tooNear = 0;    ///< nearer than the minimum range, or of length zero: left out
  size_t unbounded =
      0;  ///< without return and without a maximum range to end at, or not wanted as free space: left out
  size_t outside = 0;  ///< beyond what cell indices can address: left out

  [[nodiscard]] size_t used() const { return hits + freeOnly; }
  [[nodiscard]] size_t leftOut() const { return notFinite + tooNear + unbounded + outside; }
  RayCounts& operator+=(const RayCounts& other);
};

/// The usable rays of a fan. Points in metres in the map frame.
struct SelectedFan
{
  Eigen::Vector3d origin_map = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> hitEnds_map;
  /// Vectors from the origin to ends without a hit: free space up to and including the end. No points, for
  /// those would be rounded far from the map's origin.
  std::vector<Eigen::Vector3d> freeRays_map;
};

struct SelectedRays
{
  std::vector<SelectedFan> fans;
  RayCounts counts;
};

/** Selects and cuts the rays of a scan.
 *
 * A ray longer than the maximum range is free up to that range and has no hit; a ray without a return
 * likewise.
 * @throws std::invalid_argument if the limits are not finite, negative or the decimation is 0. */
[[nodiscard]] SelectedRays selectRays(const Scan& scan, const RangeLimits& limits);

/// The cell that holds the first origin that cells can address; the one at zero if there is none.
[[nodiscard]] CellIndex anchorOf(const SelectedRays& rays, double resolution_m);

}  // namespace lamap
