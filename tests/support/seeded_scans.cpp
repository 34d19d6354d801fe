#include <support/seeded_scans.h>

#include <cmath>
#include <limits>

namespace lamap::test
{
namespace
{
RayFan randomFan(Random& random, const ScanRecipe& recipe)
{
  RayFan fan;
  fan.origin_map = recipe.centre_map + random.inCube(0.7 * recipe.halfEdge_m);
  if (recipe.statedRanges && random.chance(0.4))
    fan.statedRangeMin_m = random.uniform(0, 0.3) * recipe.halfEdge_m;
  if (recipe.statedRanges && random.chance(0.5))
    fan.statedRangeMax_m = random.uniform(0.8, 2.0) * recipe.halfEdge_m;
  Eigen::Vector3d clusterCentre = recipe.centre_map;
  for (int i = 0; i < recipe.rays; ++i)
  {
    if (recipe.noReturns && random.chance(0.2))
    {
      fan.noReturnDirections_map.push_back(random.inCube(3.0));
      continue;
    }
    if (i % 4 == 0)
      clusterCentre = recipe.centre_map + random.inCube(recipe.halfEdge_m - recipe.clusterRadius_m);
    fan.returns_map.push_back(clusterCentre + random.inCube(recipe.clusterRadius_m));
  }
  if (recipe.unusable)
  {
    const double inf = std::numeric_limits<double>::infinity();
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const std::vector<Eigen::Vector3d> unusable{{nan, 0, 0},     {0, inf, 0},    {0, 0, -inf},
                                                {nan, nan, nan}, fan.origin_map, {nan, inf, 0}};
    for (int i = 0; i < 2; ++i)
    {
      const auto at = static_cast<long>(random.integer(0, static_cast<int>(fan.returns_map.size())));
      fan.returns_map.insert(fan.returns_map.begin() + at, random.pick(unusable));
    }
  }
  return fan;
}
}  // namespace

Scan randomScan(Random& random, const ScanRecipe& recipe)
{
  Scan scan;
  const int fans = random.integer(1, recipe.fans);
  for (int i = 0; i < fans; ++i) scan.fans.push_back(randomFan(random, recipe));
  return scan;
}

Scan quantized(const Scan& scan, int bits)
{
  const auto round = [bits](Eigen::Vector3d& point)
  {
    for (int axis = 0; axis < 3; ++axis)
      point[axis] = std::ldexp(std::nearbyint(std::ldexp(point[axis], bits)), -bits);
  };
  Scan result = scan;
  for (RayFan& fan : result.fans)
  {
    round(fan.origin_map);
    for (Eigen::Vector3d& end : fan.returns_map) round(end);
  }
  return result;
}

Scan moved(const Scan& scan, const Eigen::Vector3d& by_m)
{
  Scan result = scan;
  for (RayFan& fan : result.fans)
  {
    fan.origin_map += by_m;
    for (Eigen::Vector3d& end : fan.returns_map) end += by_m;
  }
  return result;
}

}  // namespace lamap::test
