#pragma once

#include <lamap_core/scan/scan.h>
#include <support/seeded_scans.h>

#include <Eigen/Geometry>
#include <vector>

namespace lamap::test
{
/// A rotation about a random axis; about the vertical if `upright`.
Eigen::Matrix3d randomRotation(Random& random, bool upright);

/// What a sensor in a box-shaped room sees.
struct RoomRecipe
{
  Eigen::Vector3d centre_map = Eigen::Vector3d::Zero();
  Eigen::Vector3d halfSize_m = {1.6, 1.2, 0.9};
  int rays = 120;
  double rangeMax_m = 1.7;  ///< stated; farther walls are rays without return
  bool upright = false;     ///< sensors turn about the vertical only, rays stay level
};

/// A scan of the room from a random place, with one fan or two.
Scan roomScan(Random& random, const RoomRecipe& recipe);
std::vector<Scan> roomScans(Random& random, const RoomRecipe& recipe, int count);

/// Sensor and scene, moved as a whole.
Scan moved(const Scan& scan, const Eigen::Isometry3d& by);

}  // namespace lamap::test
