#include <support/posed_scans.h>

#include <cmath>
#include <limits>

namespace lamap::test
{
namespace
{
/// Distance to the walls from inside.
double rangeToWalls(const RoomRecipe& recipe, const Eigen::Vector3d& from, const Eigen::Vector3d& direction)
{
  double range = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < (recipe.upright ? 2 : 3); ++axis)
  {
    if (direction[axis] == 0) continue;
    const double wall = recipe.centre_map[axis] + std::copysign(recipe.halfSize_m[axis], direction[axis]);
    range = std::min(range, (wall - from[axis]) / direction[axis]);
  }
  return range;
}

RayFan roomFan(Random& random, const RoomRecipe& recipe, const Eigen::Isometry3d& pose,
               const Eigen::Vector3d& from_map)
{
  const Eigen::Isometry3d sensorFromMap = pose.inverse();
  RayFan fan;
  if (from_map != pose.translation()) fan.centre = sensorFromMap * from_map;
  fan.statedRangeMax_m = recipe.rangeMax_m;
  for (int i = 0; i < recipe.rays; ++i)
  {
    Eigen::Vector3d direction = random.inCube(1.0);
    if (recipe.upright) direction.z() = 0;
    direction.normalize();
    const double range = rangeToWalls(recipe, from_map, direction);
    const Eigen::Vector3d direction_sensor = sensorFromMap.linear() * direction;
    if (range > recipe.rangeMax_m)
      fan.add(RayEnd::NoReturn, direction_sensor);
    else
      fan.addReturn(fan.centre + (range + random.uniform(-0.01, 0.01)) * direction_sensor);
  }
  return fan;
}
}  // namespace

Eigen::Matrix3d randomRotation(Random& random, bool upright)
{
  const double angle = random.uniform(-3.1, 3.1);
  const Eigen::Vector3d axis =
      upright ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d(random.inCube(1.0).normalized());
  return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}

Scan roomScan(Random& random, const RoomRecipe& recipe)
{
  const auto inside = [&]
  {
    const Eigen::Vector3d place = random.inCube(0.7);
    return Eigen::Vector3d(recipe.centre_map + place.cwiseProduct(recipe.halfSize_m));
  };
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = inside();
  pose.linear() = randomRotation(random, recipe.upright);
  Scan scan;
  scan.sensorPose_map = pose;
  scan.fans.push_back(roomFan(random, recipe, pose, pose.translation()));
  if (random.chance(0.3)) scan.fans.push_back(roomFan(random, recipe, pose, inside()));
  return scan;
}

std::vector<Scan> roomScans(Random& random, const RoomRecipe& recipe, int count)
{
  std::vector<Scan> scans;
  for (int i = 0; i < count; ++i) scans.push_back(roomScan(random, recipe));
  return scans;
}

Scan moved(const Scan& scan, const Eigen::Isometry3d& by)
{
  Scan result = scan;
  result.sensorPose_map = by * Eigen::Isometry3d(scan.sensorPose_map);
  return result;
}

}  // namespace lamap::test
