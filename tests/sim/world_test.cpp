#include <gtest/gtest.h>
#include <lamap_sim/scanner.h>
#include <lamap_sim/trajectory.h>
#include <lamap_sim/world.h>

#include <cmath>
#include <stdexcept>

namespace lamap::sim
{
namespace
{
using Eigen::Vector3d;

TEST(World, HasTheStatedSize)
{
  const auto size = [](const char* name) { return Vector3d(makeWorld(name, 3).interior_map.sizes()); };
  EXPECT_TRUE(size("structured").isApprox(Vector3d(10, 7, 2)));
  EXPECT_TRUE(size("unstructured").isApprox(Vector3d(10, 7, 2)));
  EXPECT_TRUE(size("station").isApprox(Vector3d(10, 7, 2)));
  EXPECT_TRUE(size("corridor").isApprox(Vector3d(44, 18, 3.3)));
  EXPECT_EQ(size("flatland").head<2>(), Eigen::Vector2d(12, 9));
  EXPECT_THROW((void)makeWorld("atlantis", 1), std::invalid_argument);
}

/// All numbers that define a world.
std::vector<double> numbersOf(const World& world)
{
  std::vector<double> numbers;
  Random random(99);
  for (int i = 0; i < 500; ++i)
  {
    const Vector3d sizes = world.interior_map.sizes();
    const Vector3d share{random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)};
    const Vector3d direction = random.normal3().normalized();
    const auto hit =
        world.scene.firstHit(world.interior_map.min() + share.cwiseProduct(sizes), direction, 100);
    numbers.push_back(hit ? hit->range_m : -1);
  }
  for (const auto& corner : world.path_map) numbers.insert(numbers.end(), {corner.x(), corner.y()});
  return numbers;
}

TEST(World, FollowsFromItsSeed)
{
  for (const std::string& name : worldNames())
  {
    EXPECT_EQ(numbersOf(makeWorld(name, 7)), numbersOf(makeWorld(name, 7))) << name;
    EXPECT_NE(numbersOf(makeWorld(name, 7)), numbersOf(makeWorld(name, 8))) << name;
  }
}

// For every seed: no sensor on the world's path comes near a solid.
TEST(World, PathKeepsClearOfSolids)
{
  for (const std::string& name : worldNames())
    for (uint64_t seed = 0; seed < 25; ++seed)
    {
      SCOPED_TRACE(name + " " + std::to_string(seed));
      const World world = makeWorld(name, seed);
      for (const std::string& sensorName : sensorNames())
      {
        SensorModel sensor = makeSensor(sensorName);
        sensor.pingsPerScan = 1;
        for (const Pose& pose : makeTrajectory(world, sensor, Motion::Driving, 400))
          for (int turn = 0; turn < 8; ++turn)
          {
            const SineCosine around = sineCosine(turn * 0.785);
            const Vector3d place = pose.position_map + 0.12 * Vector3d(around.cosine, around.sine, 0);
            ASSERT_FALSE(world.scene.solidAt(place)) << sensorName << " at " << place.transpose();
          }
      }
    }
}

TEST(World, IsClosedWhereItHasWallsAllAround)
{
  const World world = makeWorld("corridor", 4);
  Random random(3);
  const Vector3d start(world.path_map[0].x(), world.path_map[0].y(), 1.0);
  for (int i = 0; i < 2000; ++i)
  {
    const auto hit = world.scene.firstHit(start, random.normal3().normalized(), 60);
    ASSERT_TRUE(hit);
  }
}

TEST(Trajectory, StopsMakeFullTurns)
{
  const World world = makeWorld("structured", 1);
  const SensorModel sensor = makeSensor("sector-laser");
  const auto poses = makeTrajectory(world, sensor, Motion::Stops, 12);
  ASSERT_EQ(poses.size(), 12U);
  for (size_t i = 0; i < 12; i += 3)
  {
    EXPECT_EQ(poses[i].position_map, poses[i + 2].position_map);
    const double turn = std::remainder(poses[i + 1].yaw_rad - poses[i].yaw_rad, 2 * M_PI);
    EXPECT_NEAR(turn, 2 * M_PI / 3, 1e-9);
    if (i > 0)
    {
      EXPECT_GT((poses[i].position_map - poses[i - 1].position_map).norm(), 1.0);
    }
  }
  EXPECT_EQ(poses.front().position_map.head<2>(), world.path_map.front());
  EXPECT_TRUE(poses.back().position_map.head<2>().isApprox(world.path_map.back()));
  EXPECT_THROW((void)makeTrajectory(world, sensor, Motion::Stops, 0), std::invalid_argument);
}

TEST(Trajectory, AStationIsOnePose)
{
  const auto poses = makeTrajectory(makeWorld("station", 3), makeSensor("sector-laser"), Motion::Stops, 60);
  ASSERT_EQ(poses.size(), 60U);
  for (const Pose& pose : poses)
  {
    EXPECT_EQ(pose.position_map, poses[0].position_map);
    EXPECT_EQ(pose.yaw_rad, poses[0].yaw_rad);
  }
}

TEST(Trajectory, DrivingGoesEqualDistancesAndLooksAhead)
{
  const World world = makeWorld("flatland", 2);
  const auto poses = makeTrajectory(world, makeSensor("planar-laser"), Motion::Driving, 200);
  for (size_t i = 1; i < poses.size(); ++i)
  {
    const Vector3d step = poses[i].position_map - poses[i - 1].position_map;
    EXPECT_LT(step.norm(), 0.15);
    EXPECT_LT(std::abs(std::remainder(poses[i].yaw_rad - poses[i - 1].yaw_rad, 2 * M_PI)), 0.6);
    const double ahead = step.x() * std::cos(poses[i].yaw_rad) + step.y() * std::sin(poses[i].yaw_rad);
    EXPECT_GT(ahead, -0.2 * step.norm());  // at the sharpest corner it moves sideways
  }
}

TEST(Trajectory, ASonarHasOnePosePerPing)
{
  const SensorModel sonar = makeSensor("sonar");
  const auto poses = makeTrajectory(makeWorld("pier", 1), sonar, Motion::Stops, 3);
  ASSERT_EQ(poses.size(), 360U);
  EXPECT_EQ(poses[0].position_map, poses[119].position_map);
  EXPECT_NE(poses[119].position_map, poses[120].position_map);
}

TEST(Pose, RotationAndQuaternionAgreeWithTurningOneAxisAfterTheOther)
{
  Pose pose;
  pose.yaw_rad = 0.7;
  pose.pitch_rad = -0.3;
  pose.roll_rad = 1.9;
  const Eigen::Matrix3d expected =
      (Eigen::AngleAxisd(0.7, Vector3d::UnitZ()) * Eigen::AngleAxisd(-0.3, Vector3d::UnitY()) *
       Eigen::AngleAxisd(1.9, Vector3d::UnitX()))
          .toRotationMatrix();
  EXPECT_TRUE(rotationOf(pose).isApprox(expected, 1e-14));
  const Quaternion q = quaternionOf(pose);
  EXPECT_TRUE(Eigen::Quaterniond(q.w, q.x, q.y, q.z).toRotationMatrix().isApprox(expected, 1e-14));
  EXPECT_GE(q.w, 0);
}
}  // namespace
}  // namespace lamap::sim
