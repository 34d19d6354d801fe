#include <gtest/gtest.h>
#include <lamap_core/scan/beam_cone.h>
#include <support/seeded_scans.h>
#include <support/seeds.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace lamap::test
{
namespace
{
using Rays = std::vector<Eigen::Vector3d>;

constexpr double kDegree = M_PI / 180;

/// @param width_deg and height_deg edge to edge
Beam beamOf(double width_deg, double height_deg)
{
  Beam beam;
  beam.halfWidth_rad = 0.5 * width_deg * kDegree;
  beam.halfHeight_rad = 0.5 * height_deg * kDegree;
  return beam;
}

Rays spreadOf(const BeamCone& cone, const Eigen::Vector3d& ray, double spacing)
{
  Rays rays;
  cone.spread(ray, spacing, rays);
  return rays;
}

double angleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b)
{
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

double largestAngle(const Rays& rays, const Eigen::Vector3d& from)
{
  double largest = 0;
  for (const Eigen::Vector3d& ray : rays) largest = std::max(largest, angleBetween(ray, from));
  return largest;
}

// By hand: a section of 60°, 10 m long. In the projection its half is 2 sin 15° = 0.5176, at 10 m 5.176 m;
// strips of at most 2 m: five of 2.0706 m would be too wide, so seven of 1.479 m; the outermost middle is 3
// strips off.
TEST(BeamCone, OfAPlanarMapByHand)
{
  const BeamCone cone(beamOf(60, 10), Eigen::Vector3d::UnitZ());
  const Rays rays = spreadOf(cone, {10, 0, 0}, 2);
  ASSERT_EQ(rays.size(), 7U);
  const double strip = 2 * std::sin(15 * kDegree) / 3.5;
  for (int i = -3; i <= 3; ++i)
  {
    const double angle = 2 * std::asin(i * strip / 2);
    const Eigen::Vector3d expected(10 * std::cos(angle), 10 * std::sin(angle), 0);
    EXPECT_LT((rays[static_cast<size_t>(i + 3)] - expected).norm(), 1e-12) << i;
  }
  EXPECT_NEAR(cone.footprint({10, 0, 0}, 2), 2 * 5.176380902 / 2, 1e-8);
}

TEST(BeamCone, WithoutAWidthIsItsAxis)
{
  const Eigen::Vector3d ray(1, 2, 3);
  EXPECT_FALSE(BeamCone().any());
  EXPECT_EQ(spreadOf({}, ray, 0.1), Rays{ray});
  EXPECT_EQ(spreadOf({beamOf(0.1, 0.1), std::nullopt}, ray, 0.1), Rays{ray}) << "narrower than the spacing";
}

TEST(BeamCone, AnAngleThatIsNoneIsNoWidth)
{
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double aperture_deg : {0.0, -10.0, nan, 180.0, 360.0, std::numeric_limits<double>::infinity()})
  {
    EXPECT_EQ(halfApertureOf(aperture_deg * kDegree), 0) << aperture_deg;
    EXPECT_FALSE(BeamCone(beamOf(aperture_deg, aperture_deg), std::nullopt).any()) << aperture_deg;
  }
  EXPECT_DOUBLE_EQ(halfApertureOf(179 * kDegree), 89.5 * kDegree);
  // The other angle still counts.
  const Rays rays = spreadOf({beamOf(20, nan), std::nullopt}, {10, 0, 0}, 0.1);
  EXPECT_GT(rays.size(), 30U);
  for (const Eigen::Vector3d& ray : rays) EXPECT_NEAR(ray.z(), 0, 1e-12);
}

TEST(BeamCone, RaysLieInTheConeAndReachItsEdge)
{
  Random random(1);
  for (const double aperture_deg : {3.0, 15.0, 60.0, 170.0})
    for (int i = 0; i < 5; ++i)
    {
      const Eigen::Vector3d axis = 7 * random.inCube(1).normalized();
      Beam beam = beamOf(aperture_deg, aperture_deg);
      beam.up = random.inCube(1).normalized();
      const Rays rays = spreadOf({beam, std::nullopt}, axis, 0.3);
      for (const Eigen::Vector3d& ray : rays) ASSERT_NEAR(ray.norm(), 7, 1e-9);
      const double half = 0.5 * aperture_deg * kDegree;
      EXPECT_LE(largestAngle(rays, axis), half + 1e-9);
      EXPECT_GE(largestAngle(rays, axis), half - 1.5 * 0.3 / 7) << aperture_deg;
      EXPECT_TRUE(std::any_of(rays.begin(), rays.end(),
                              [&](const Eigen::Vector3d& ray) { return (ray - axis).norm() < 1e-12; }));
    }
}

// Within the angle θ of the axis are (1 − cos θ) / (1 − cos θ_max) of the solid angle, and of the rays.
TEST(BeamCone, RaysStandForEqualSolidAngles)
{
  for (const double aperture_deg : {20.0, 120.0})
  {
    const Rays rays = spreadOf({beamOf(aperture_deg, aperture_deg), std::nullopt}, {0, 10, 0}, 0.1);
    const double half = 0.5 * aperture_deg * kDegree;
    for (const double share : {0.3, 0.5, 0.8})
    {
      const auto within = std::count_if(rays.begin(), rays.end(),
                                        [&](const Eigen::Vector3d& ray) {
                                          return angleBetween(ray, Eigen::Vector3d::UnitY()) < share * half;
                                        });
      EXPECT_NEAR(static_cast<double>(within) / static_cast<double>(rays.size()),
                  (1 - std::cos(share * half)) / (1 - std::cos(half)), 0.05)
          << aperture_deg << "°, " << share;
    }
  }
}

TEST(BeamCone, LeavesNoGapWiderThanTheSpacing)
{
  Random random(2);
  const double half = 7.5 * kDegree;
  const Eigen::Vector3d axis(9, 0, 0);
  const Rays rays = spreadOf({beamOf(15, 15), std::nullopt}, axis, 0.1);
  for (int i = 0; i < 300; ++i)
  {
    const Eigen::Vector3d place = 9 * (Eigen::Vector3d::UnitX() + random.inCube(std::tan(half))).normalized();
    if (angleBetween(place, axis) > half) continue;
    double nearest = 1e9;
    for (const Eigen::Vector3d& ray : rays) nearest = std::min(nearest, (ray - place).norm());
    ASSERT_LT(nearest, 0.11);
  }
}

TEST(BeamCone, IsAsWideAboutTheUprightAxisAsItsBeam)
{
  Beam beam = beamOf(40, 4);
  const Rays level = spreadOf({beam, std::nullopt}, {10, 0, 0}, 0.02);
  const auto reachOf = [](const Rays& rays, int axis)
  {
    double reach = 0;
    for (const Eigen::Vector3d& ray : rays) reach = std::max(reach, std::abs(ray[axis]));
    return reach;
  };
  EXPECT_NEAR(reachOf(level, 1), 10 * std::sin(20 * kDegree), 0.1);
  EXPECT_NEAR(reachOf(level, 2), 10 * std::sin(2 * kDegree), 0.1);
  beam.up = Eigen::Vector3d::UnitY();
  const Rays rolled = spreadOf({beam, std::nullopt}, {10, 0, 0}, 0.02);
  EXPECT_NEAR(reachOf(rolled, 2), 10 * std::sin(20 * kDegree), 0.1);
  EXPECT_NEAR(reachOf(rolled, 1), 10 * std::sin(2 * kDegree), 0.1);
}

TEST(BeamCone, APlanarMapUsesTheSectionInItsPlane)
{
  // Rolled by 90°, the beam's height is what lies in the plane.
  Beam beam = beamOf(40, 4);
  beam.up = Eigen::Vector3d::UnitY();
  const Rays rays = spreadOf({beam, Eigen::Vector3d::UnitZ()}, {10, 0, 0}, 0.01);
  for (const Eigen::Vector3d& ray : rays) ASSERT_NEAR(ray.z(), 0, 1e-12);
  EXPECT_NEAR(largestAngle(rays, Eigen::Vector3d::UnitX()), 2 * kDegree, 0.002);
  // By 45°: (cos² 45°/20² + sin² 45°/2²)^(-1/2) = 2.814°.
  beam.up = Eigen::Vector3d(0, 1, 1).normalized();
  const Rays turned = spreadOf({beam, Eigen::Vector3d::UnitZ()}, {10, 0, 0}, 0.01);
  EXPECT_NEAR(largestAngle(turned, Eigen::Vector3d::UnitX()), 2.814 * kDegree, 0.002);
  // A beam with a height alone has none there.
  EXPECT_EQ(spreadOf({beamOf(0, 40), Eigen::Vector3d::UnitZ()}, {10, 0, 0}, 0.01).size(), 1U);
}

TEST(BeamCone, HasSomeThousandRaysAtMost)
{
  const BeamCone cone(beamOf(120, 120), std::nullopt);
  EXPECT_LT(spreadOf(cone, {1000, 0, 0}, 0.01).size(), 5000U);
  EXPECT_GT(spreadOf(cone, {1000, 0, 0}, 0.01).size(), 3000U);
  EXPECT_LT(spreadOf({beamOf(120, 0), std::nullopt}, {1000, 0, 0}, 0.01).size(), 5000U);
}

TEST(BeamCone, ABeamAlongItsUprightAxisIsNoExceptionToAnything)
{
  const Rays rays = spreadOf({beamOf(20, 20), std::nullopt}, {0, 0, -5}, 0.1);
  EXPECT_GT(rays.size(), 100U);
  EXPECT_NEAR(largestAngle(rays, -Eigen::Vector3d::UnitZ()), 10 * kDegree, 0.02);
}

}  // namespace
}  // namespace lamap::test
