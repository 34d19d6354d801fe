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

RayFan roomFan(Random& random, const RoomRecipe& recipe, const Eigen::Vector3d& from)
{
  RayFan fan;
  fan.origin_map = from;
  fan.statedRangeMax_m = recipe.rangeMax_m;
  for (int i = 0; i < recipe.rays; ++i)
  {
    Eigen::Vector3d direction = random.inCube(1.0);
    if (recipe.upright) direction.z() = 0;
    direction.normalize();
    const double range = rangeToWalls(recipe, from, direction);
    if (range > recipe.rangeMax_m)
      fan.noReturnDirections_map.push_back(direction);
    else
      fan.returns_map.push_back(from + (range + random.uniform(-0.01, 0.01)) * direction);
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

PosedScan roomScan(Random& random, const RoomRecipe& recipe)
{
  PosedScan posed;
  const auto inside = [&]
  {
    const Eigen::Vector3d place = random.inCube(0.7);
    return Eigen::Vector3d(recipe.centre_map + place.cwiseProduct(recipe.halfSize_m));
  };
  posed.pose.translation() = inside();
  posed.pose.linear() = randomRotation(random, recipe.upright);
  posed.scan.fans.push_back(roomFan(random, recipe, posed.pose.translation()));
  if (random.chance(0.3)) posed.scan.fans.push_back(roomFan(random, recipe, inside()));
  return posed;
}

std::vector<PosedScan> roomScans(Random& random, const RoomRecipe& recipe, int count)
{
  std::vector<PosedScan> scans;
  for (int i = 0; i < count; ++i) scans.push_back(roomScan(random, recipe));
  return scans;
}

PosedScan moved(const PosedScan& posed, const Eigen::Isometry3d& by)
{
  PosedScan result = posed;
  result.pose = by * posed.pose;
  for (RayFan& fan : result.scan.fans)
  {
    fan.origin_map = by * fan.origin_map;
    for (Eigen::Vector3d& end : fan.returns_map) end = by * end;
    for (Eigen::Vector3d& direction : fan.noReturnDirections_map) direction = by.linear() * direction;
  }
  return result;
}

}  // namespace lamap::test
