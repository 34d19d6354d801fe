// How far beams are from their neighbours: hand-made patterns, whose spacing is known.
#include <gtest/gtest.h>
#include <lamap_core/scan/beam_spacing.h>
#include <support/seeded_scans.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace lamap::test
{
namespace
{
/// A grid of beams within ±45° × ±15°, at equal angles.
RayFan grid(double along_deg, double across_deg)
{
  RayFan fan;
  const int rows = static_cast<int>(std::lround(30 / across_deg));
  const int columns = static_cast<int>(std::lround(90 / along_deg));
  for (int row = 0; row <= rows; ++row)
    for (int column = 0; column <= columns; ++column)
      fan.addReturn(5 * towards(along_deg * column - 45, across_deg * row - 15));
  return fan;
}

std::vector<double> spacingOf(const RayFan& fan)
{
  std::vector<double> spacing_deg;
  for (const float angle : beamSpacing(fan)) spacing_deg.push_back(angle * 180 / M_PI);
  return spacing_deg;
}

void expectAll(const RayFan& fan, double least_deg, double most_deg)
{
  const std::vector<double> spacing_deg = spacingOf(fan);
  ASSERT_EQ(spacing_deg.size(), fan.rays.size());
  const auto [least, most] = std::minmax_element(spacing_deg.begin(), spacing_deg.end());
  EXPECT_GE(*least, least_deg);
  EXPECT_LE(*most, most_deg);
}

TEST(BeamSpacing, OfASquareGridIsItsAngle)
{
  for (const double angle : {2.0, 3.0, 5.0}) expectAll(grid(angle, angle), 0.94 * angle, 1.01 * angle);
}

TEST(BeamSpacing, OfRingsIsADistanceOfRingsAndAQuarterHoweverDenseTheyAre)
{
  for (const double along : {0.1, 0.2}) expectAll(grid(along, 2.0), 2.49, 2.51);
  expectAll(grid(0.3, 5.0), 6.24, 6.26);
}

TEST(BeamSpacing, OfOneRowIsItsAngleAndAQuarter)
{
  RayFan row;
  for (int azimuth = -90; azimuth <= 90; ++azimuth) row.addReturn(3 * towards(azimuth, 0));
  expectAll(row, 1.24, 1.26);
}

// Of length zero, where a number was too small for it, or too far away to be a number.
TEST(BeamSpacing, OfARayWithoutDirectionIsNone)
{
  RayFan row;
  for (int azimuth = -90; azimuth <= 90; ++azimuth) row.addReturn(3 * towards(azimuth, 0));
  const std::vector<double> alone = spacingOf(row);
  row.add(RayEnd::NoReturn, {0, 0, 0});
  row.add(RayEnd::Return, row.centre);
  row.add(RayEnd::Cut, {std::nan(""), 0, 0});
  std::vector<double> spacing_deg = spacingOf(row);
  ASSERT_EQ(spacing_deg.size(), alone.size() + 3);
  for (size_t i = alone.size(); i < spacing_deg.size(); ++i) EXPECT_EQ(spacing_deg[i], 0);
  spacing_deg.resize(alone.size());
  EXPECT_EQ(spacing_deg, alone);
  RayFan none;
  none.add(RayEnd::NoReturn, {0, 0, 0});
  none.add(RayEnd::NoReturn, {0, 0, 0});
  EXPECT_EQ(spacingOf(none), std::vector<double>(2, 0.0));
}

TEST(BeamSpacing, OfDenseBeamsIsBelowABin)
{
  expectAll(grid(0.2, 0.2), 0.05, 0.5);
}

TEST(BeamSpacing, IsNoLargerBesideAnOpening)
{
  RayFan fan = grid(3, 3);
  const auto inOpening = [](const Ray& ray) { return ray.end.y() > 0 && ray.end.z() > 0; };
  fan.rays.erase(std::remove_if(fan.rays.begin(), fan.rays.end(), inOpening), fan.rays.end());
  expectAll(fan, 2.8, 3.2);
}

TEST(BeamSpacing, RaysWithoutAReturnAreBeamsToo)
{
  RayFan fan = grid(3, 3);
  for (size_t i = 0; i < fan.rays.size(); i += 3) fan.rays[i].meaning = RayEnd::NoReturn;
  expectAll(fan, 2.8, 3.2);
}

TEST(BeamSpacing, DoesNotDependOnTheOrderOfRaysOrOnTheirRanges)
{
  const RayFan fan = grid(2, 4);
  const std::vector<double> inOrder = spacingOf(fan);
  std::vector<size_t> order(fan.rays.size());
  std::iota(order.begin(), order.end(), size_t{0});
  Random random(5);
  for (size_t i = order.size() - 1; i > 0; --i)
    std::swap(order[i], order[static_cast<size_t>(random.integer(0, static_cast<int>(i)))]);
  RayFan shuffled;
  for (const size_t i : order) shuffled.addReturn(random.uniform(0.1, 50) * fan.rays[i].end);
  const std::vector<double> spacing = spacingOf(shuffled);
  for (size_t i = 0; i < order.size(); ++i) EXPECT_EQ(spacing[i], inOrder[order[i]]);
}

TEST(BeamSpacing, GoesRoundTheCircle)
{
  RayFan fan;
  for (int azimuth = 0; azimuth < 360; azimuth += 4) fan.addReturn(towards(azimuth, 0));
  expectAll(fan, 4.99, 5.01);
}

TEST(BeamSpacing, OfARayThatIsAloneIsZero)
{
  RayFan fan;
  EXPECT_TRUE(beamSpacing(fan).empty());
  fan.addReturn(towards(0, 0));
  EXPECT_EQ(beamSpacing(fan), std::vector<float>{0.0F});
  fan.addReturn(towards(90, 0));
  EXPECT_EQ(beamSpacing(fan), (std::vector<float>{0.0F, 0.0F}));
}

}  // namespace
}  // namespace lamap::test
