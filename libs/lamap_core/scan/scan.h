#pragma once

#include <Eigen/Core>
#include <vector>

namespace lamap
{
/** All rays of one observation that leave the same optical centre, in the map frame [m].
 *
 * A ray with a return ends on a surface. A ray without one says only that nothing was met along its direction
 * up to the sensor's range.
 */
struct RayFan
{
  Eigen::Vector3d origin_map = Eigen::Vector3d::Zero();
  /// End points of the rays with a return, whatever their range. May hold NaN or infinite points: they are
  /// counted and left out by whoever selects rays.
  std::vector<Eigen::Vector3d> returns_map;
  /// Directions (any length > 0) of the rays without a return.
  std::vector<Eigen::Vector3d> noReturnDirections_map;
  /// Nearest and farthest range [m] that the observation states; 0: it states none.
  double statedRangeMin_m = 0;
  double statedRangeMax_m = 0;
};

/// One observation as rays. Several fans where its rays leave from different places.
struct Scan
{
  std::vector<RayFan> fans;
};

}  // namespace lamap
