#include <gtest/gtest.h>
#include <lamap_tools/inputs/cloud_frame_watch.h>
#include <support/pcd_points.h>

#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace
{
using namespace lamap::tools;
using Points = std::vector<Eigen::Vector3d>;

Eigen::Isometry3d poseAt(const Eigen::Vector3d& place, double yaw)
{
  Eigen::Isometry3d pose(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
  pose.translation() = place;
  return pose;
}

/// A scan in the map's frame, and where it was made.
struct PosedCloud
{
  Eigen::Isometry3d pose_map;
  Points points_map;
};

/// What is said of clouds that are in one frame and taken to be in one.
std::string saidOf(const std::vector<PosedCloud>& clouds, CloudFrame actual, CloudFrame taken)
{
  CloudFrameWatch watch(taken);
  for (const PosedCloud& cloud : clouds)
  {
    Points points = cloud.points_map;
    if (actual == CloudFrame::Sensor)
      for (Eigen::Vector3d& point : points) point = cloud.pose_map.inverse() * point;
    watch.add(cloud.pose_map, Eigen::Vector3d::Zero(), points);
  }
  return watch.suspicion().value_or("");
}

void expectBothMistakesAreFound(const std::vector<PosedCloud>& clouds)
{
  EXPECT_EQ(saidOf(clouds, CloudFrame::Map, CloudFrame::Map), "");
  EXPECT_EQ(saidOf(clouds, CloudFrame::Sensor, CloudFrame::Sensor), "");
  EXPECT_NE(saidOf(clouds, CloudFrame::Sensor, CloudFrame::Map).find("give --cloud-frame sensor"),
            std::string::npos);
  EXPECT_NE(saidOf(clouds, CloudFrame::Map, CloudFrame::Sensor).find("leave out --cloud-frame sensor"),
            std::string::npos);
}

/// Of the simulation of the thesis. @param turned  whether the poses turn with the sensor
std::vector<PosedCloud> structuredClouds(const std::string& folder, const std::string& name, int count,
                                         bool turned)
{
  std::vector<PosedCloud> clouds;
  for (const lamap::Scan& scan : lamap::test::readStructuredScans(folder, name, count))
  {
    const double yaw = turned ? 2 * M_PI / 3 * static_cast<double>(clouds.size() % 3) : 0;
    PosedCloud cloud{poseAt(scan.fans.at(0).centre, yaw), {}};
    for (const lamap::Ray& ray : scan.fans[0].rays) cloud.points_map.push_back(ray.end);
    clouds.push_back(cloud);
  }
  return clouds;
}

// A sector laser that looks into three directions in turn: no scan is centred on its sensor.
TEST(CloudFrameWatch, FindsBothMistakesInScansOfASectorLaser)
{
  const auto folder = lamap::test::dataFolder();
  if (!folder) GTEST_SKIP() << "LAMAP_DATA does not name the folder of measuring data";
  for (const bool turned : {false, true})
  {
    SCOPED_TRACE(turned ? "poses with rotations" : "poses without rotations");
    expectBothMistakesAreFound(structuredClouds(*folder, "sim_structured", 12, turned));
  }
}

TEST(CloudFrameWatch, SaysNothingOfASensorThatStands)
{
  const auto folder = lamap::test::dataFolder();
  if (!folder) GTEST_SKIP() << "LAMAP_DATA does not name the folder of measuring data";
  const auto clouds = structuredClouds(*folder, "sim_structured_long_term", 60, false);
  for (const CloudFrame actual : {CloudFrame::Map, CloudFrame::Sensor})
    for (const CloudFrame taken : {CloudFrame::Map, CloudFrame::Sensor})
      EXPECT_EQ(saidOf(clouds, actual, taken), "");
}

/// Rays of a fan of directions in a box, each to its wall. @param half  of its edges
Points boxSeenFrom(const Eigen::Vector3d& place, const Eigen::Vector3d& half, double yaw, double halfWidth,
                   double pitch = 0)
{
  Points points;
  for (double azimuth = -halfWidth; azimuth < halfWidth; azimuth += M_PI / 90)
    for (double elevation = -0.3; elevation <= 0.3; elevation += 0.05)
    {
      const double e = elevation + pitch;
      const Eigen::Vector3d ray(std::cos(e) * std::cos(yaw + azimuth), std::cos(e) * std::sin(yaw + azimuth),
                                std::sin(e));
      double length = 1e3;
      for (int axis = 0; axis < 3; ++axis)
        if (std::abs(ray[axis]) > 1e-9)
          length = std::min(length, (std::copysign(half[axis], ray[axis]) - place[axis]) / ray[axis]);
      points.push_back(place + length * ray);
    }
  return points;
}

const Eigen::Vector3d kRoom(6, 4, 1.5);

/// A drive around the room's centre.
std::vector<PosedCloud> driven(int count,
                               const std::function<Points(const Eigen::Vector3d&, double)>& cloudOf)
{
  std::vector<PosedCloud> clouds;
  for (int i = 0; i < count; ++i)
  {
    const double angle = 0.21 * i;
    const Eigen::Vector3d place(4 * std::cos(angle), 2.5 * std::sin(angle), -0.5);
    clouds.push_back({poseAt(place, angle + M_PI / 2), cloudOf(place, angle + M_PI / 2)});
  }
  return clouds;
}

TEST(CloudFrameWatch, FindsBothMistakesInARoom)
{
  constexpr double kCamera_rad = 0.5;
  const std::vector<std::pair<double, int>> cases{{M_PI, 3},        {M_PI, 30},        {M_PI, 300},
                                                  {kCamera_rad, 8}, {kCamera_rad, 30}, {kCamera_rad, 300}};
  for (const auto& [halfWidth, count] : cases)
  {
    SCOPED_TRACE(std::to_string(count) + " scans, half width " + std::to_string(halfWidth));
    expectBothMistakesAreFound(driven(count, [width = halfWidth](const auto& place, double yaw)
                                      { return boxSeenFrom(place, kRoom, yaw, width); }));
  }
}

// Nothing but the ends tells one place of a corridor from another.
TEST(CloudFrameWatch, FindsBothMistakesInACorridor)
{
  std::vector<PosedCloud> clouds;
  for (int i = 0; i < 100; ++i)
  {
    const Eigen::Vector3d place(0.3 * i, 0.1 * std::sin(i), 0);
    clouds.push_back({poseAt(place, 0), boxSeenFrom(place, {50, 1.5, 1.5}, 0, M_PI)});
  }
  expectBothMistakesAreFound(clouds);
}

TEST(CloudFrameWatch, SaysNothingFarFromTheOriginOfCloudsThatAreWhereTheyAreTakenToBe)
{
  auto clouds = driven(20, [](const auto& place, double yaw) { return boxSeenFrom(place, kRoom, yaw, 0.5); });
  const Eigen::Vector3d utm(448123.4, 5412345.6, 310.2);
  for (PosedCloud& cloud : clouds)
  {
    cloud.pose_map.pretranslate(utm);
    for (Eigen::Vector3d& point : cloud.points_map) point += utm;
  }
  EXPECT_EQ(saidOf(clouds, CloudFrame::Map, CloudFrame::Map), "");
  EXPECT_EQ(saidOf(clouds, CloudFrame::Sensor, CloudFrame::Sensor), "");
}

// The centres of the cells that the room's walls are in: no cloud shows where its sensor was.
TEST(CloudFrameWatch, SaysNothingOfThinnedOutCloudsThatAreWhereTheyAreTakenToBe)
{
  std::vector<PosedCloud> clouds;
  for (const Eigen::Vector3d& place : Points{{-5, -3, 0}, {5, -3, 0}, {5, 3, 0}, {-5, 3, 0}})
  {
    std::map<std::array<double, 3>, Eigen::Vector3d> cells;
    for (const auto& point : boxSeenFrom(place, kRoom, 0, M_PI))
    {
      const Eigen::Vector3d cell = (point / 0.5).array().floor();
      cells[{cell.x(), cell.y(), cell.z()}] = 0.5 * (cell.array() + 0.5);
    }
    clouds.push_back({poseAt(place, 0), {}});
    for (const auto& entry : cells) clouds.back().points_map.push_back(entry.second);
  }
  EXPECT_EQ(saidOf(clouds, CloudFrame::Map, CloudFrame::Map), "");
  EXPECT_EQ(saidOf(clouds, CloudFrame::Sensor, CloudFrame::Sensor), "");
}

// A pan-tilt head: each scan looks somewhere else.
TEST(CloudFrameWatch, SaysNothingOfScansInManyDirectionsThatAreWhereTheyAreTakenToBe)
{
  std::vector<PosedCloud> clouds;
  for (int i = 0; i < 12; ++i)
  {
    const double pan = 2.4 * i;
    const Eigen::Vector3d place(0.3 * i - 2, 0.2 * i - 1, 0);
    clouds.push_back({poseAt(place, 0), boxSeenFrom(place, kRoom, pan, 0.4, 0.4 * std::sin(i))});
  }
  EXPECT_EQ(saidOf(clouds, CloudFrame::Map, CloudFrame::Map), "");
  EXPECT_EQ(saidOf(clouds, CloudFrame::Sensor, CloudFrame::Sensor), "");
}
}  // namespace
