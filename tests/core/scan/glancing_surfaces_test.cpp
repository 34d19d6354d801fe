#include <gtest/gtest.h>
#include <lamap_core/scan/glancing_surfaces.h>
#include <lamap_core/scan/scan.h>
#include <support/seeded_scans.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace lamap::test
{
namespace
{
/// Rings of a lidar 1 m above a floor, every degree all round.
RayFan ringsOnFloor(const std::vector<double>& elevations_deg, const Eigen::Vector3d& centre)
{
  RayFan fan;
  fan.centre = centre;
  for (const double elevation : elevations_deg)
    for (int azimuth = -180; azimuth < 180; ++azimuth)
    {
      const Eigen::Vector3d direction = towards(azimuth, elevation);
      fan.addReturn(centre + direction / -direction.z());
    }
  return fan;
}

/// A planar laser, a ray every degree, that looks along a wall at y = 1 m.
RayFan laserAlongWall(double from_deg, double to_deg)
{
  RayFan fan;
  for (double azimuth = from_deg; azimuth <= to_deg; ++azimuth)
  {
    const Eigen::Vector3d direction = towards(azimuth, 0);
    fan.addReturn(direction / direction.y());
  }
  return fan;
}

std::vector<GlancingSurfaces::Piece> piecesOf(const RayFan& fan)
{
  GlancingSurfaces surfaces;
  return surfaces.of(fan);
}

TEST(GlancingSurfaces, AreTheFloorBetweenTheRingsOfALidar)
{
  const Eigen::Vector3d centre(3, -2, 1);
  const auto pieces = piecesOf(ringsOnFloor({-12, -10, -8}, centre));
  ASSERT_EQ(pieces.size(), 720U);
  for (const auto& piece : pieces)
  {
    EXPECT_NEAR(piece.begin.z(), 0, 1e-9);
    EXPECT_NEAR(piece.end.z(), 0, 1e-9);
    EXPECT_GT((piece.end - piece.begin).norm(), 0.9);
  }
  EXPECT_TRUE(piecesOf(ringsOnFloor({-60, -58, -56}, centre)).empty());  // from above
  EXPECT_TRUE(piecesOf(ringsOnFloor({-12, -10}, centre)).empty());       // does not go on
  EXPECT_TRUE(piecesOf(ringsOnFloor({-18, -14, -10}, centre)).empty());  // too far apart
}

TEST(GlancingSurfaces, AreTheFarPartOfAWall)
{
  // The farther ray of a piece meets the wall at its own angle: 3 degrees are glancing, 2 are too few.
  const auto pieces = piecesOf(laserAlongWall(1, 29));
  EXPECT_EQ(pieces.size(), 26U);
  EXPECT_TRUE(piecesOf(laserAlongWall(32, 90)).empty());
  for (const auto& piece : pieces) EXPECT_NEAR(piece.begin.y(), 1, 1e-9);
}

TEST(GlancingSurfaces, AreNotWhatLiesBetweenTwoThings)
{
  RayFan fan;
  for (int azimuth = 0; azimuth < 20; ++azimuth)
    fan.addReturn((azimuth < 10 ? 2.0 : 2.3) * towards(azimuth, 0));
  EXPECT_TRUE(piecesOf(fan).empty());
}

TEST(GlancingSurfaces, EndWhereARayHasNoReturn)
{
  RayFan fan = laserAlongWall(5, 15);
  const size_t whole = piecesOf(fan).size();
  EXPECT_EQ(whole, 10U);
  fan.rays.erase(fan.rays.begin() + 5);
  fan.add(RayEnd::NoReturn, towards(10, 0));
  EXPECT_EQ(piecesOf(fan).size(), whole - 2);
  EXPECT_TRUE(piecesOf({}).empty());
}

TEST(GlancingSurfaces, GoRoundBehindTheSensor)
{
  RayFan fan;
  for (int azimuth = 171; azimuth < 191; ++azimuth)
  {
    const Eigen::Vector3d direction = towards(azimuth, 0);
    fan.addReturn(direction / -(0.3 * direction.x() + direction.y() * 0.95));
  }
  RayFan turned;
  for (const Ray& ray : fan.rays) turned.addReturn({-ray.end.y(), ray.end.x(), ray.end.z()});
  EXPECT_GT(piecesOf(fan).size(), 3U);
  EXPECT_EQ(piecesOf(fan).size(), piecesOf(turned).size());
}

TEST(GlancingSurfaces, DoNotDependOnTheOrderOfRays)
{
  RayFan fan = ringsOnFloor({-12, -11.8, -10, -8}, {0.3, 0.1, 1});
  for (int azimuth = 3; azimuth < 40; ++azimuth) fan.add(RayEnd::NoReturn, towards(azimuth, -10));
  const auto pieces = piecesOf(fan);
  EXPECT_GT(pieces.size(), 500U);
  std::mt19937 generator(5);
  std::shuffle(fan.rays.begin(), fan.rays.end(), generator);
  const auto again = piecesOf(fan);
  ASSERT_EQ(again.size(), pieces.size());
  for (size_t i = 0; i < pieces.size(); ++i)
  {
    EXPECT_EQ(again[i].begin, pieces[i].begin);
    EXPECT_EQ(again[i].end, pieces[i].end);
  }
}

}  // namespace
}  // namespace lamap::test
