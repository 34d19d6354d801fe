#include <gtest/gtest.h>
#include <lamap_sim/scanner.h>

#include <cmath>
#include <stdexcept>

namespace lamap::sim
{
namespace
{
using Eigen::Vector3d;

/// A hall of 10 × 10 × 4 m around the origin, without a ceiling.
World hall()
{
  World world;
  world.name = "hall";
  world.interior_map = {Vector3d(-5, -5, 0), Vector3d(5, 5, 4)};
  world.scene = Scene({HalfSpace{Vector3d::UnitZ(), 0}, HalfSpace{Vector3d::UnitX(), -5},
                       HalfSpace{-Vector3d::UnitX(), -5}, HalfSpace{Vector3d::UnitY(), -5},
                       HalfSpace{-Vector3d::UnitY(), -5}});
  world.path_map = {{0, 0}, {1, 0}};
  return world;
}

Pose standing(double x, double y, double z, double yaw = 0.3)
{
  Pose pose;
  pose.position_map = {x, y, z};
  pose.yaw_rad = yaw;
  return pose;
}

/// Distance to the hall's nearest surface.
double offSurface(const Vector3d& p)
{
  return std::min({std::abs(p.z()), std::abs(5 - std::abs(p.x())), std::abs(5 - std::abs(p.y()))});
}

TEST(Sensors, HaveTheStatedNumbersOfBeams)
{
  EXPECT_EQ(makeSensor("sector-laser").beams.size(), 3500U);
  EXPECT_EQ(makeSensor("pan-tilt-laser").beams.size(), 89000U);
  EXPECT_EQ(makeSensor("lidar16").beams.size(), 28800U);
  EXPECT_EQ(makeSensor("planar-laser").beams.size(), 361U);
  EXPECT_THROW((void)makeSensor("radar"), std::invalid_argument);
  for (const std::string& name : sensorNames())
    for (const Vector3d& beam : makeSensor(name).beams) ASSERT_NEAR(beam.norm(), 1, 1e-14) << name;
  const SensorModel sector = makeSensor("sector-laser");
  for (const Vector3d& beam : sector.beams) EXPECT_LT(std::abs(std::atan2(beam.y(), beam.x())), M_PI / 3);
  const SensorModel planar = makeSensor("planar-laser");
  EXPECT_NEAR(std::atan2(planar.beams[0].y(), planar.beams[0].x()), -M_PI / 2, 1e-12);
  EXPECT_NEAR(std::atan2(planar.beams[360].y(), planar.beams[360].x()), M_PI / 2, 1e-12);
}

TEST(Scanner, ExactReadingsEndOnSurfaces)
{
  const Scanner scanner(hall(), makeSensor("sector-laser"), {}, 1);
  const Pose pose = standing(-2, -2.5, 1.5, 0.8);
  int returns = 0;
  for (const BeamReading& reading : scanner.scan(pose, 0))
  {
    if (reading.range_m)
    {
      ++returns;
      EXPECT_LT(offSurface(rotationOf(pose) * reading.point_sensor + pose.position_map), 1e-12);
      EXPECT_NEAR(reading.point_sensor.norm(), *reading.range_m, 1e-12);
      EXPECT_LT(*reading.range_m, 8);
    }
    else
      EXPECT_NEAR(reading.point_sensor.norm(), 12, 1e-12);  // 1.5 times 8 m
  }
  EXPECT_GT(returns, 2000);
  EXPECT_LT(returns, 3500);  // the corners are farther away than 8 m
}

double deviation(const std::vector<double>& errors)
{
  double squares = 0;
  for (const double error : errors) squares += error * error;
  return std::sqrt(squares / static_cast<double>(errors.size()));
}

TEST(Scanner, EachNoiseHasItsStatedSize)
{
  const SensorModel sensor = makeSensor("sector-laser");
  const Pose pose = standing(0, 0, 1.5, 0);
  const auto exact = Scanner(hall(), sensor, {}, 1).scan(pose, 0);
  const auto errorsWith = [&](const NoiseOptions& noise, const auto& errorOf)
  {
    std::vector<double> errors;
    const auto noisy = Scanner(hall(), sensor, noise, 1).scan(pose, 0);
    for (size_t i = 0; i < exact.size(); ++i)
      if (exact[i].range_m && noisy[i].range_m && *exact[i].range_m < 7)
        errors.push_back(errorOf(exact[i], noisy[i]));
    return deviation(errors);
  };
  NoiseOptions range;
  range.range_m = 0.03;
  EXPECT_NEAR(
      errorsWith(range, [](const BeamReading& a, const BeamReading& b) { return *b.range_m - *a.range_m; }),
      0.03, 0.002);
  NoiseOptions point;
  point.point_m = 0.02;
  EXPECT_NEAR(errorsWith(point, [](const BeamReading& a, const BeamReading& b)
                         { return b.point_sensor.y() - a.point_sensor.y(); }),
              0.02, 0.0015);
  // A wall crosses the view at 5 m: straight ahead, an error of the angle changes the range only in second
  // order; at 45°, by 5·√2 m · angle.
  NoiseOptions angle;
  angle.angle_rad = 0.01;
  const auto noisy = Scanner(hall(), sensor, angle, 1).scan(pose, 0);
  std::vector<double> slanted;
  for (size_t i = 0; i < exact.size(); ++i)
  {
    const Vector3d& beam = sensor.beams[i];
    const double azimuth = std::atan2(beam.y(), beam.x());
    if (exact[i].range_m && noisy[i].range_m && std::abs(beam.z()) < 0.05 && azimuth > 0.6 && azimuth < 0.7)
      slanted.push_back((*noisy[i].range_m - *exact[i].range_m) * std::pow(std::cos(azimuth), 2) / 5 /
                        std::sin(azimuth));
  }
  EXPECT_GT(slanted.size(), 10U);
  EXPECT_NEAR(deviation(slanted), 0.01, 0.005);
}

TEST(Scanner, LosesTheStatedShareOfReturns)
{
  NoiseOptions noise;
  noise.missing = 0.25;
  const SensorModel sensor = makeSensor("planar-laser");
  int lost = 0;
  for (uint64_t i = 0; i < 20; ++i)
    for (const BeamReading& reading : Scanner(hall(), sensor, noise, 1).scan(standing(0, 0, 1), i))
      lost += reading.range_m ? 0 : 1;
  EXPECT_NEAR(lost / (20 * 361.0), 0.25, 0.02);
}

TEST(Scanner, BurstsAreAsLongAndAsFrequentAsAskedFor)
{
  const SensorModel sensor = makeSensor("planar-laser");
  for (const auto& [share, longest] : {std::pair{0.25, 12}, {0.5, 2}, {0.05, 60}})
  {
    SCOPED_TRACE(longest);
    NoiseOptions noise;
    noise.missing = share;
    noise.longestBurst = longest;
    const Scanner scanner(hall(), sensor, noise, 1);
    int lost = 0;
    int longestRun = 0;
    constexpr int kScans = 400;
    for (uint64_t i = 0; i < kScans; ++i)
    {
      int run = 0;
      for (const BeamReading& reading : scanner.scan(standing(0, 0, 1), i))
      {
        ASSERT_NE(reading.range_m.has_value(), reading.lost_m.has_value()) << "every beam meets a wall";
        run = reading.lost_m ? run + 1 : 0;
        lost += reading.lost_m ? 1 : 0;
        longestRun = std::max(longestRun, run);
      }
    }
    EXPECT_EQ(longestRun, longest);
    EXPECT_NEAR(lost / (kScans * 361.0), share, 0.05 * share);
  }
}

TEST(Scanner, ALostReturnTellsWhatItWouldHaveRead)
{
  const SensorModel sensor = makeSensor("planar-laser");
  NoiseOptions noise;
  noise.range_m = 0.02;
  const auto whole = Scanner(hall(), sensor, noise, 5).scan(standing(0, 0, 1), 3);
  noise.missing = 0.3;
  const auto holed = Scanner(hall(), sensor, noise, 5).scan(standing(0, 0, 1), 3);
  int lost = 0;
  for (size_t i = 0; i < whole.size(); ++i)
  {
    lost += holed[i].lost_m ? 1 : 0;
    EXPECT_EQ(holed[i].lost_m ? holed[i].lost_m : holed[i].range_m, whole[i].range_m);
  }
  EXPECT_GT(lost, 80);
}

TEST(Scanner, ChangingOneNoiseDoesNotChangeTheOthers)
{
  const SensorModel sensor = makeSensor("planar-laser");
  NoiseOptions missing;
  missing.missing = 0.3;
  NoiseOptions both = missing;
  both.range_m = 0.1;
  const auto first = Scanner(hall(), sensor, missing, 5).scan(standing(0, 0, 1), 3);
  const auto second = Scanner(hall(), sensor, both, 5).scan(standing(0, 0, 1), 3);
  for (size_t i = 0; i < first.size(); ++i)
    EXPECT_EQ(first[i].range_m.has_value(), second[i].range_m.has_value());
  // Another scan or seed has other noise.
  const auto other = Scanner(hall(), sensor, both, 5).scan(standing(0, 0, 1), 4);
  EXPECT_NE(*other[180].range_m, second[180].range_m.value_or(0));
}

TEST(Scanner, APlanarSensorStaysInItsPlane)
{
  NoiseOptions noise;
  noise.angle_rad = 0.05;
  noise.position_m = 0.2;
  noise.turn_rad = 0.1;
  const Scanner scanner(hall(), makeSensor("planar-laser"), noise, 2);
  for (const BeamReading& reading : scanner.scan(standing(0, 0, 0.01), 0))
    EXPECT_TRUE(reading.range_m && *reading.range_m > 4.9);  // with a tilt it would meet the floor
  const Pose reported = scanner.reportedPose(standing(0, 0, 1), 0);
  EXPECT_EQ(reported.position_map.z(), 1);
  EXPECT_EQ(reported.pitch_rad, 0);
  EXPECT_NE(reported.yaw_rad, 0.3);
}

TEST(Scanner, RefusesImpossibleSettings)
{
  const World world = hall();
  const SensorModel laser = makeSensor("sector-laser");
  const Scanner scanner(world, laser, {}, 1);
  EXPECT_NO_THROW(scanner.requireOpen({0, 0, 1}));
  EXPECT_THROW(scanner.requireOpen({0, 0, -0.1}), std::invalid_argument);
  EXPECT_THROW(scanner.requireOpen({5.2, 0, 1}), std::invalid_argument);
  EXPECT_THROW(scanner.requireOpen({0, 0, 4.5}), std::invalid_argument);  // above the world
  EXPECT_THROW(scanner.requireOpen({0, NAN, 1}), std::invalid_argument);
  NoiseOptions noise;
  noise.missing = 1.5;
  EXPECT_THROW(Scanner(world, laser, noise, 1), std::invalid_argument);
  noise.missing = 0.5;
  for (const int longest : {0, -1, 2000000})
  {
    noise.longestBurst = longest;
    EXPECT_THROW(Scanner(world, laser, noise, 1), std::invalid_argument) << longest;
  }
  noise.longestBurst = 3;  // 2 beams on average, of 3
  EXPECT_THROW(Scanner(world, makeSensor("sonar"), noise, 1), std::invalid_argument);
  noise.missing = 0.66;
  EXPECT_NO_THROW(Scanner(world, laser, noise, 1));
  noise.missing = 0.67;
  EXPECT_THROW(Scanner(world, laser, noise, 1), std::invalid_argument);
  noise.longestBurst = 1;
  noise.missing = 0;
  noise.range_m = NAN;
  EXPECT_THROW(Scanner(world, laser, noise, 1), std::invalid_argument);
  noise.range_m = 0;
  noise.point_m = 0.1;
  EXPECT_NO_THROW(Scanner(world, laser, noise, 1));
  EXPECT_THROW(Scanner(world, makeSensor("planar-laser"), noise, 1), std::invalid_argument);
}

TEST(Sonar, HearsEverySurfaceInItsBeamTheNearestFirst)
{
  World world = hall();
  std::vector<Shape> shapes = world.scene.shapes();
  shapes.emplace_back(Cylinder{{2, 0.05}, 0.1, 0, 4});  // narrower than the beam
  shapes.emplace_back(Cylinder{{3.5, -0.2}, 0.1, 0, 4});
  world.scene = Scene(shapes);
  const Pose ahead = standing(0, 0, 2, 0);
  const auto echoes = Scanner(world, makeSensor("sonar"), {}, 1).ping(ahead, {}, 0);
  ASSERT_EQ(echoes.size(), 3U);
  EXPECT_NEAR(echoes[0].range_m, 1.9, 0.02);
  EXPECT_NEAR(echoes[1].range_m, 3.4, 0.02);
  EXPECT_NEAR(echoes[2].range_m, 5.0, 0.02);
  for (const Echo& echo : echoes)
  {
    EXPECT_GE(echo.intensity, 1);
    EXPECT_LE(echo.intensity, 255);
  }
  EXPECT_GT(echoes[2].intensity, echoes[1].intensity);  // the wall fills more of the beam
  const auto first = Scanner(world, makeSensor("sonar-range"), {}, 1).ping(ahead, {}, 0);
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(first[0].range_m, echoes[0].range_m);
  // Only the wall is behind it.
  EXPECT_EQ(Scanner(world, makeSensor("sonar"), {}, 1).ping(standing(0, 0, 2, 0), {M_PI, 0}, 0).size(), 1U);
}

TEST(Sonar, HeadTurnsAllAroundAndDown)
{
  const SensorModel sonar = makeSensor("sonar");
  EXPECT_NEAR(headTurn(sonar, 60).yaw_rad, 0, 1e-12);
  EXPECT_NEAR(headTurn(sonar, 61).yaw_rad, M_PI / 60, 1e-12);
  EXPECT_EQ(headTurn(sonar, 119).pitch_rad, 0);
  EXPECT_NEAR(headTurn(sonar, 120).pitch_rad, M_PI / 9, 1e-12);
  // Pointing straight down from 2 m, it hears the floor.
  const auto echoes = Scanner(hall(), sonar, {}, 1).ping(standing(1, 1, 2), {0.4, M_PI / 2}, 0);
  ASSERT_FALSE(echoes.empty());
  EXPECT_NEAR(echoes[0].range_m, 2, 1e-9);
}

TEST(Sonar, HearsNothingBeyondItsRange)
{
  SensorModel sonar = makeSensor("sonar");
  sonar.rangeMax_m = 4;
  EXPECT_TRUE(Scanner(hall(), sonar, {}, 1).ping(standing(0, 0, 2, 0), {}, 0).empty());
}
}  // namespace
}  // namespace lamap::sim
