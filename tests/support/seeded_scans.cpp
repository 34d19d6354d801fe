#include <support/seeded_scans.h>

#include <cmath>
#include <limits>
#include <utility>

namespace lamap::test
{
RayFan fanOf(const Eigen::Vector3d& centre, const std::vector<Eigen::Vector3d>& returns,
             const std::vector<Eigen::Vector3d>& noReturns, double statedMin_m, double statedMax_m)
{
  RayFan fan;
  fan.centre = centre;
  for (const Eigen::Vector3d& end : returns) fan.addReturn(end);
  for (const Eigen::Vector3d& direction : noReturns) fan.add(RayEnd::NoReturn, direction);
  fan.statedRangeMin_m = statedMin_m;
  fan.statedRangeMax_m = statedMax_m;
  return fan;
}

Scan scanWith(std::vector<RayFan> fans)
{
  Scan scan;
  scan.fans = std::move(fans);
  return scan;
}

std::vector<Eigen::Vector3d> endsOf(const RayFan& fan, RayEnd meaning)
{
  std::vector<Eigen::Vector3d> ends;
  for (const Ray& ray : fan.rays)
    if (ray.meaning == meaning) ends.push_back(ray.end);
  return ends;
}

namespace
{
RayFan randomFan(Random& random, const ScanRecipe& recipe)
{
  RayFan fan;
  fan.centre = recipe.centre_map + random.inCube(0.7 * recipe.halfEdge_m);
  if (recipe.statedRanges && random.chance(0.4))
    fan.statedRangeMin_m = random.uniform(0, 0.3) * recipe.halfEdge_m;
  if (recipe.statedRanges && random.chance(0.5))
    fan.statedRangeMax_m = random.uniform(0.8, 2.0) * recipe.halfEdge_m;
  Eigen::Vector3d clusterCentre = recipe.centre_map;
  for (int i = 0; i < recipe.rays; ++i)
  {
    if (recipe.noReturns && random.chance(0.2))
    {
      fan.add(RayEnd::NoReturn, random.inCube(3.0));
      continue;
    }
    if (i % 4 == 0)
      clusterCentre = recipe.centre_map + random.inCube(recipe.halfEdge_m - recipe.clusterRadius_m);
    fan.addReturn(clusterCentre + random.inCube(recipe.clusterRadius_m));
  }
  if (recipe.unusable)
  {
    const double inf = std::numeric_limits<double>::infinity();
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const std::vector<Eigen::Vector3d> unusable{{nan, 0, 0},     {0, inf, 0}, {0, 0, -inf},
                                                {nan, nan, nan}, fan.centre,  {nan, inf, 0}};
    for (int i = 0; i < 2; ++i)
    {
      const auto at = static_cast<long>(random.integer(0, static_cast<int>(fan.rays.size())));
      fan.rays.insert(fan.rays.begin() + at, Ray{random.pick(unusable)});
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
  Eigen::Vector3d place = scan.sensorPose_map.translation();
  round(place);
  result.sensorPose_map.translation() = place;
  for (RayFan& fan : result.fans)
  {
    round(fan.centre);
    for (Ray& ray : fan.rays)
      if (ray.meaning == RayEnd::Return) round(ray.end);
  }
  return result;
}

Scan moved(const Scan& scan, const Eigen::Vector3d& by_m)
{
  Scan result = scan;
  result.sensorPose_map.translation() += by_m;
  return result;
}

}  // namespace lamap::test
