#include "benchmark_scans.h"

#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationPointCloud.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace lamap::test
{
namespace
{
constexpr double kPi = 3.14159265358979323846;

struct Box
{
  Eigen::Vector3d low;
  Eigen::Vector3d high;
};

/// A hall seen from inside, with boxes in it.
struct World
{
  Box hall;
  std::vector<Box> boxes;

  /// Distance to the first surface along a unit direction.
  [[nodiscard]] double range(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const
  {
    double nearest = crossing(hall, origin, direction).second;
    for (const Box& box : boxes)
    {
      const auto [enter, leave] = crossing(box, origin, direction);
      if (enter > 0 && enter <= leave) nearest = std::min(nearest, enter);
    }
    return nearest;
  }

  [[nodiscard]] bool solidAt(const Eigen::Vector3d& point) const
  {
    return !contains(hall, point) ||
           std::any_of(boxes.begin(), boxes.end(), [&](const Box& box) { return contains(box, point); });
  }

 private:
  static bool contains(const Box& box, const Eigen::Vector3d& point)
  {
    return (point.array() > box.low.array()).all() && (point.array() < box.high.array()).all();
  }

  static std::pair<double, double> crossing(const Box& box, const Eigen::Vector3d& origin,
                                            const Eigen::Vector3d& direction)
  {
    double enter = -std::numeric_limits<double>::infinity();
    double leave = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis)
    {
      const double a = (box.low[axis] - origin[axis]) / direction[axis];
      const double b = (box.high[axis] - origin[axis]) / direction[axis];
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    return {enter, leave};
  }
};

// Surfaces are not on the faces of cells, as in reality.
const Eigen::Vector3d kOffset(0.037, 0.041, 0.043);

World room()
{
  World world{{kOffset, kOffset + Eigen::Vector3d(10, 7, 2)}, {}};
  const auto add = [&](double x, double y, double dx, double dy, double dz)
  {
    world.boxes.push_back(
        {kOffset + Eigen::Vector3d(x, y, 0), kOffset + Eigen::Vector3d(x + dx, y + dy, dz)});
  };
  add(4.9, 0, 0.2, 3, 2);
  add(7, 4, 1, 1, 1.2);
  add(2, 5, 2, 0.5, 0.8);
  add(8, 1, 0.4, 0.4, 2);
  return world;
}

World corridor()
{
  World world{{kOffset, kOffset + Eigen::Vector3d(44, 18, 3.3)}, {}};
  const auto add = [&](double x, double y, double dx, double dy, double dz)
  {
    world.boxes.push_back(
        {kOffset + Eigen::Vector3d(x, y, 0), kOffset + Eigen::Vector3d(x + dx, y + dy, dz)});
  };
  for (int i = 0; i < 5; ++i)
  {
    add(8.0 * i + 7.9, 0, 0.2, 7, 3.3);
    add(8.0 * i + 7.9, 10, 0.2, 8, 3.3);
  }
  for (int i = 0; i < 6; ++i)
  {
    add(8.0 * i + 1, 6.9, 6, 0.2, 3.3);
    add(8.0 * i + 1, 9.9, 6, 0.2, 3.3);
  }
  std::mt19937 generator(7);
  const auto uniform = [&](double high)
  { return high * static_cast<double>(generator()) / static_cast<double>(std::mt19937::max()); };
  for (int i = 0; i < 60; ++i)
  {
    const double x = uniform(43);
    const double y = uniform(17);
    if (y < 6 || y > 10.5) add(x, y, 0.3 + uniform(0.7), 0.3 + uniform(0.7), 0.4 + uniform(1.5));
  }
  return world;
}

/// A cloud in the sensor's frame; the robot's pose is at the optical centre.
PosedObservation cloudScan(const World& world, const Eigen::Vector3d& origin, double yaw,
                           const std::vector<Eigen::Vector3d>& directions)
{
  auto cloud = mrpt::obs::CObservationPointCloud::Create();
  cloud->pointcloud = mrpt::maps::CSimplePointsMap::Create();
  const Eigen::Matrix3d rotation = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  for (const Eigen::Vector3d& direction : directions)
  {
    const Eigen::Vector3d point = direction * world.range(origin, rotation * direction);
    cloud->pointcloud->insertPoint(static_cast<float>(point.x()), static_cast<float>(point.y()),
                                   static_cast<float>(point.z()));
  }
  return {cloud, mrpt::poses::CPose3D(origin.x(), origin.y(), origin.z(), yaw, 0, 0)};
}

/// Directions on a grid of angles [rad].
std::vector<Eigen::Vector3d> directionGrid(int azimuths, double azimuthSpan, int elevations,
                                           double elevationSpan)
{
  std::vector<Eigen::Vector3d> directions;
  for (int i = 0; i < azimuths; ++i)
  {
    for (int j = 0; j < elevations; ++j)
    {
      const double azimuth = azimuthSpan * ((i + 0.5) / azimuths - 0.5);
      const double elevation = elevationSpan * ((j + 0.5) / elevations - 0.5);
      directions.emplace_back(std::cos(elevation) * std::cos(azimuth),
                              std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
    }
  }
  return directions;
}

/// Labels the cells of 0.1 m by their corners and centres; all edges of the worlds are longer than a cell.
std::vector<TrueCell> truthOf(const World& world)
{
  constexpr double kResolution_m = 0.1;
  std::vector<TrueCell> cells;
  const Eigen::Array3i low = (world.hall.low.array() / kResolution_m).floor().cast<int>() - 1;
  const Eigen::Array3i high = (world.hall.high.array() / kResolution_m).floor().cast<int>() + 1;
  for (int z = low.z(); z <= high.z(); ++z)
  {
    for (int y = low.y(); y <= high.y(); ++y)
    {
      for (int x = low.x(); x <= high.x(); ++x)
      {
        int solidCorners = 0;
        for (int corner = 0; corner < 8; ++corner)
        {
          const Eigen::Vector3d point((x + (corner & 1)), (y + (corner >> 1 & 1)), (z + (corner >> 2)));
          solidCorners += world.solidAt(point * kResolution_m) ? 1 : 0;
        }
        if (solidCorners < 8)
          cells.push_back({Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5) * kResolution_m, solidCorners > 0});
      }
    }
  }
  return cells;
}

}  // namespace

ScanSeries sectorLaserSeries()
{
  ScanSeries series{"sector laser, 12 scans of 3,500 points, 8 m", 8.0, false, {}, {}};
  const World world = room();
  series.truth = truthOf(world);
  const auto directions = directionGrid(100, 2 * kPi / 3, 35, kPi / 4);
  for (int i = 0; i < 12; ++i)
  {
    const Eigen::Vector3d origin(1.1 + 2.6 * (i / 3), i % 2 == 0 ? 2.1 : 3.6, 0.5);
    series.scans.push_back(cloudScan(world, origin, 2 * kPi / 3 * (i % 3), directions));
  }
  return series;
}

ScanSeries panTiltSeries()
{
  ScanSeries series{"pan-tilt laser, 10 scans of 89,000 points, 30 m", 30.0, false, {}, {}};
  const World world = corridor();
  series.truth = truthOf(world);
  const auto directions = directionGrid(500, 2 * kPi, 178, 0.9 * kPi);
  for (int i = 0; i < 10; ++i)
    series.scans.push_back(cloudScan(world, {2.1 + 4.3 * i, 8.4, 1.2}, 0.3 * i, directions));
  return series;
}

ScanSeries planarLaserSeries()
{
  ScanSeries series{"planar laser, 60 scans of 361 beams, 30 m", 30.0, true, {}, {}};
  const World world = corridor();
  constexpr size_t kBeams = 361;
  for (int i = 0; i < 60; ++i)
  {
    auto scan = mrpt::obs::CObservation2DRangeScan::Create();
    scan->aperture = static_cast<float>(kPi);
    scan->maxRange = 30.0f;
    scan->resizeScan(kBeams);
    const Eigen::Vector3d origin(1.6 + 0.7 * i, 8.4, 1.2);
    const double yaw = 0.2 * i;
    for (size_t beam = 0; beam < kBeams; ++beam)
    {
      const double angle = yaw + kPi * (static_cast<double>(beam) / (kBeams - 1) - 0.5);
      const double range = world.range(origin, {std::cos(angle), std::sin(angle), 0.0});
      scan->setScanRange(beam, static_cast<float>(range));
      scan->setScanRangeValidity(beam, range < 30.0);
    }
    series.scans.push_back({scan, mrpt::poses::CPose3D(origin.x(), origin.y(), origin.z(), yaw, 0, 0)});
  }
  return series;
}

}  // namespace lamap::test
