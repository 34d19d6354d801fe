// A sensor's perceptual field.
#include <gtest/gtest.h>
#include <lamap_core/scan/depth_view.h>
#include <support/seeded_scans.h>

#include <cmath>

namespace lamap::test
{
namespace
{
constexpr double kDegree = 3.141592653589793 / 180;

Eigen::Vector3d towards(double azimuth_deg, double elevation_deg, double range_m)
{
  const double a = azimuth_deg * kDegree, e = elevation_deg * kDegree;
  return range_m * Eigen::Vector3d(std::cos(a) * std::cos(e), std::sin(a) * std::cos(e), std::sin(e));
}

TEST(DepthView, HoldsOneRaysBinUpToBehindItsEnd)
{
  const Eigen::Vector3d sensor(1, 2, 3);
  DepthView view(sensor, 8.0, {}, false);
  view.addRay(towards(31, 11, 4.0));
  view.finish();
  const auto holds = [&](double azimuth, double elevation, double range)
  { return view.contains(sensor + towards(azimuth, elevation, range)); };
  EXPECT_TRUE(holds(31, 11, 4.299));
  EXPECT_FALSE(holds(31, 11, 4.301));
  EXPECT_TRUE(holds(30.1, 10.1, 1.0));
  EXPECT_TRUE(holds(32.4, 12.4, 1.0));
  for (const auto& [azimuth, elevation] : {std::pair{29.9, 11.0}, {32.6, 11.0}, {31.0, 9.9}, {31.0, 12.6}})
  {
    EXPECT_FALSE(holds(azimuth, elevation, 1.0)) << azimuth << " " << elevation;
    EXPECT_TRUE(holds(azimuth, elevation, 0.29)) << azimuth << " " << elevation;
  }
  EXPECT_TRUE(view.contains(sensor));
}

TEST(DepthView, EndsAtTheMaximumRange)
{
  DepthView view(Eigen::Vector3d::Zero(), 8.0, {}, false);
  view.addRay(towards(1, 1, 7.9));
  view.finish();
  EXPECT_TRUE(view.contains(towards(1, 1, 7.99)));
  EXPECT_FALSE(view.contains(towards(1, 1, 8.01)));
}

TEST(DepthView, WithoutRaysSeesNothingButWhatIsNear)
{
  DepthView view(Eigen::Vector3d::Zero(), 8.0, {}, false);
  view.finish();
  EXPECT_EQ(view.image().rows, 0u);
  EXPECT_EQ(view.image().columns, 0u);
  EXPECT_TRUE(view.contains(towards(1, 1, 0.29)));
  EXPECT_FALSE(view.contains(towards(1, 1, 0.31)));
}

TEST(DepthView, TakesTheLongestRayOfABin)
{
  DepthView view(Eigen::Vector3d::Zero(), 100.0, {}, false);
  for (const double range : {2.0, 5.0, 3.0}) view.addRay(towards(-100.5, -20.5, range));
  view.finish();
  EXPECT_TRUE(view.contains(towards(-101, -21, 5.2)));
  EXPECT_FALSE(view.contains(towards(-101, -21, 5.4)));
}

TEST(DepthView, IsOpenAsFarAsTheShortestRayOfABinAndOfThoseAboveAndBelow)
{
  DepthView view(Eigen::Vector3d::Zero(), 100.0, {}, false);
  for (const double range : {7.0, 5.0, 6.0}) view.addRay(towards(31, 11, range));
  view.addRay(towards(31, 8.5, 3.0));  // in the bin below
  view.addRay(towards(33.5, 11, 2.0));
  view.finish();
  const auto isOpen = [&](double azimuth, double elevation, double range)
  {
    const Eigen::Vector3d place = towards(azimuth, elevation, range);
    DepthView::Seen seen;
    view.addSeen({place, place, place, place}, seen);
    return seen.open[0];
  };
  EXPECT_TRUE(isOpen(31, 11, 2.99));
  EXPECT_FALSE(isOpen(31, 11, 3.01));
  // At the upper edge of the field, a ceiling: 2·sin 11°/sin 12.5°.
  EXPECT_TRUE(isOpen(33.5, 11, 1.75));
  EXPECT_FALSE(isOpen(33.5, 11, 1.77));
  EXPECT_TRUE(isOpen(-90, 40, 0.29));  // near the sensor
  EXPECT_FALSE(isOpen(-90, 40, 0.31));
}

TEST(DepthView, IsFlatInAPlanarMap)
{
  DepthView view(Eigen::Vector3d(0, 0, 1), 8.0, {}, true);
  view.addRay({3, 0.05, 40});
  view.finish();
  EXPECT_EQ(view.image().depths_m.size(), 1u);
  EXPECT_TRUE(view.contains({3.2, 0.05, -7}));
  EXPECT_FALSE(view.contains({3.4, 0.05, 1}));
}

bool isOpenAt(const DepthView& view, const Eigen::Vector3d& place)
{
  DepthView::Seen seen;
  view.addSeen({place, place, place, place}, seen);
  return seen.open[0];
}

TEST(DepthView, IsOpenBelowTheLowestRingOnlyAsFarAsTheFloorGoesOn)
{
  DepthView view(Eigen::Vector3d::Zero(), 100.0, {}, false);
  view.addRay(towards(31, -14, 4.0));
  view.addRay(towards(31, -11.5, 5.0));
  view.addRay(towards(61, -14, 4.0));
  view.addRay(towards(61, -11.5, 3.0));     // what comes nearer above does not tell of the floor
  view.addRay(towards(91, -15.0001, 4.0));  // the bin goes on to -17.5 degrees
  view.addRay(towards(91, -13, 4.1));       // a wall, which does not tell of the floor either
  view.finish();
  EXPECT_TRUE(isOpenAt(view, towards(31, -14, 3.72)));  // 4·sin 14°/sin 15°
  EXPECT_FALSE(isOpenAt(view, towards(31, -14, 3.75)));
  EXPECT_TRUE(isOpenAt(view, towards(61, -14, 2.98)));
  EXPECT_FALSE(isOpenAt(view, towards(61, -14, 3.02)));
  EXPECT_TRUE(isOpenAt(view, towards(91, -17, 3.42)));  // 4·sin 15°/sin 17.5°
  EXPECT_FALSE(isOpenAt(view, towards(91, -17, 3.45)));
  EXPECT_TRUE(isOpenAt(view, towards(91, -14, 3.98)));
  EXPECT_FALSE(isOpenAt(view, towards(91, -14, 4.02)));
}

TEST(DepthView, IsOpenInAPlanarMapAsFarAsTheRaysNextToAPlace)
{
  DepthView view(Eigen::Vector3d::Zero(), 100.0, {}, true);
  for (double azimuth = 30.25; azimuth < 40; azimuth += 0.5)  // in the middle of each fifth of a bin
    if (azimuth != 33.25) view.addRay(towards(azimuth, 0, azimuth == 32.75 ? 2.0 : azimuth > 35 ? 4.0 : 6.0));
  view.finish();
  EXPECT_FALSE(isOpenAt(view, towards(32.75, 0, 2.03)));
  for (const double azimuth : {32.25, 33.75, 34.75}) EXPECT_TRUE(isOpenAt(view, towards(azimuth, 0, 5.9)));
  EXPECT_TRUE(isOpenAt(view, towards(33.25, 0, 1.9)));  // between rays of 2 and 6 m
  EXPECT_FALSE(isOpenAt(view, towards(33.25, 0, 2.1)));
  EXPECT_EQ(view.image().openShares.size(), 5 * view.image().depths_m.size());
}

TEST(DepthViewProperty, BinsAreThoseOfTheAngles)
{
  Random random(1);
  const FieldRules rules{0.0, 0.1, 2.5};
  for (int i = 0; i < 2000; ++i)
  {
    const Eigen::Vector3d ray = random.inCube(1.0).normalized();
    const Eigen::Vector3d other = (ray + random.inCube(0.04)).normalized();
    const auto bin = [](const Eigen::Vector3d& d)
    {
      return std::pair{(std::atan2(d.y(), d.x()) / kDegree + 180) / 2.5,
                       (std::atan2(d.z(), std::hypot(d.x(), d.y())) / kDegree + 90) / 2.5};
    };
    const auto [ra, re] = bin(ray);
    const auto [oa, oe] = bin(other);
    const auto onEdge = [](double bins) { return std::abs(bins - std::round(bins)) < 1e-3; };
    if (onEdge(ra) || onEdge(re) || onEdge(oa) || onEdge(oe)) continue;
    DepthView view(Eigen::Vector3d::Zero(), 8.0, rules, false);
    view.addRay(2.0 * ray);
    view.finish();
    ASSERT_EQ(view.contains(other), std::floor(ra) == std::floor(oa) && std::floor(re) == std::floor(oe));
  }
}

TEST(DepthView, ComesBackFromItsImageAndRefusesOthers)
{
  DepthView view(Eigen::Vector3d(1, 0, 0), 8.0, {}, false);
  view.addRay({1, 2, 1});
  view.addRay({-1, 2, 0});
  view.finish();
  EXPECT_TRUE(DepthView::fromImage(view.image()).image() == view.image());
  const auto refused = [&](auto&& spoil)
  {
    DepthView::Image image = view.image();
    spoil(image);
    EXPECT_THROW((void)DepthView::fromImage(image), std::runtime_error);
  };
  refused([](auto& i) { i.rows += 1; });
  refused([](auto& i) { i.firstRow = 72; });
  refused([](auto& i) { i.firstColumn = 4000000000u; });
  refused([](auto& i) { i.depths_m.pop_back(); });
  refused([](auto& i) { i.depths_m.front() = -1; });
  refused([](auto& i) { i.rangeMax_m = 0; });
  refused([](auto& i) { i.rules.angle_deg = 0; });
  refused([](auto& i) { i.sensor.x() = NAN; });
}

}  // namespace
}  // namespace lamap::test
