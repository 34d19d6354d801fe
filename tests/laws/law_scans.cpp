#include "law_scans.h"

#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationPointCloud.h>

#include <cmath>
#include <limits>

namespace lamap::test
{
namespace
{
using mrpt::obs::CObservation2DRangeScan;
using mrpt::obs::CObservationPointCloud;

mrpt::poses::CPose3D randomPose(Random& random)
{
  const Eigen::Vector3d place = random.inCube(0.5);
  return {place.x(),
          place.y(),
          place.z(),
          random.uniform(-3.1, 3.1),
          random.uniform(-0.7, 0.7),
          random.uniform(-0.7, 0.7)};
}

TakenScan cloudOf(const std::vector<Eigen::Vector3f>& points, const mrpt::poses::CPose3D& robotPose_map)
{
  auto cloud = std::make_shared<CObservationPointCloud>();
  auto map = mrpt::maps::CSimplePointsMap::Create();
  for (const Eigen::Vector3f& point : points) map->insertPoint(point.x(), point.y(), point.z());
  cloud->pointcloud = map;
  return {cloud, robotPose_map};
}

std::vector<Eigen::Vector3f> clusters(Random& random, int count)
{
  std::vector<Eigen::Vector3f> points;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (int i = 0; i < count; ++i)
  {
    if (i % 4 == 0) centre = random.inCube(0.8);
    points.push_back((centre + random.inCube(0.1)).cast<float>());
  }
  return points;
}

double roundNumber(double number)
{
  return std::ldexp(std::nearbyint(std::ldexp(number, 20)), -20);
}
}  // namespace

TakenScan randomCloud(Random& random, int points)
{
  return cloudOf(clusters(random, points), randomPose(random));
}

TakenScan randomLaserScan(Random& random, int rays)
{
  auto scan = std::make_shared<CObservation2DRangeScan>();
  scan->aperture = 5.0F;
  scan->maxRange = 1.6F;
  scan->resizeScan(static_cast<size_t>(rays));
  for (size_t i = 0; i < static_cast<size_t>(rays); ++i)
  {
    const bool returned = !random.chance(0.2);
    scan->setScanRange(i, returned ? static_cast<float>(random.uniform(0.1, 1.5)) : 1.6F);
    scan->setScanRangeValidity(i, returned);
  }
  return {scan, randomPose(random)};
}

std::vector<TakenScan> randomScans(Random& random, int count, int rays)
{
  std::vector<TakenScan> scans;
  for (int i = 0; i < count; ++i)
    scans.push_back(random.chance(0.5) ? randomCloud(random, rays) : randomLaserScan(random, rays));
  return scans;
}

TakenScan roundCloud(Random& random)
{
  std::vector<Eigen::Vector3f> points = clusters(random, 40);
  for (Eigen::Vector3f& point : points)
    for (int axis = 0; axis < 3; ++axis) point[axis] = static_cast<float>(roundNumber(point[axis]));
  const Eigen::Vector3d place = random.inCube(0.5);
  return cloudOf(points,
                 {roundNumber(place.x()), roundNumber(place.y()), roundNumber(place.z()), 0.0, 0.0, 0.0});
}

TakenScan moved(const TakenScan& scan, double x_m, double y_m, double z_m)
{
  TakenScan result = scan;
  result.robotPose_map.x_incr(x_m);
  result.robotPose_map.y_incr(y_m);
  result.robotPose_map.z_incr(z_m);
  return result;
}

TakenScan spoilt(Random& random, const TakenScan& cloud, size_t& added)
{
  const auto& good = *std::dynamic_pointer_cast<CObservationPointCloud>(cloud.observation)->pointcloud;
  std::vector<Eigen::Vector3f> points(good.size());
  for (size_t i = 0; i < points.size(); ++i) good.getPoint(i, points[i].x(), points[i].y(), points[i].z());
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInf = std::numeric_limits<float>::infinity();
  const std::vector<Eigen::Vector3f> bad = {
      {kNan, 0, 0}, {0, kInf, 0}, {0, 0, -kInf}, {kNan, kNan, kInf}, {0, 0, 0}};
  for (const Eigen::Vector3f& point : bad)
    points.insert(points.begin() + random.integer(0, static_cast<int>(points.size())), point);
  added = bad.size();
  return cloudOf(points, cloud.robotPose_map);
}

}  // namespace lamap::test
