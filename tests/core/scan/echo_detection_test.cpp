#include <gtest/gtest.h>
#include <lamap_core/scan/echo_detection.h>
#include <support/seeded_scans.h>
#include <support/seeds.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace lamap::test
{
namespace
{
using Echoes = std::vector<DetectedEcho>;

/// Of bins that are a metre long, without a dead zone.
EchoRules rulesOf(double threshold, double separation_m = 0.5)
{
  EchoRules rules;
  rules.nearThreshold = rules.farThreshold = threshold;
  rules.deadZone_m = 0;
  rules.separation_m = separation_m;
  return rules;
}

Echoes found(const std::vector<double>& intensities, const EchoRules& rules)
{
  return findEchoes(intensities, static_cast<double>(intensities.size()), rules);
}

TEST(EchoDetection, ByHand)
{
  //                     0   1  2  3   4   5  6   7   8  9
  const std::vector<double> ping{0, 10, 5, 5, 80, 30, 0, 60, 60, 0};
  EXPECT_EQ(found(ping, rulesOf(20)), (Echoes{{4.5, 80}, {7.5, 60}})) << "of a plateau the nearest bin";
  EXPECT_EQ(found(ping, rulesOf(5)), (Echoes{{1.5, 10}, {4.5, 80}, {7.5, 60}}));
  EXPECT_EQ(found(ping, rulesOf(80)), (Echoes{{4.5, 80}})) << "as high as the threshold";
  EXPECT_EQ(found(ping, rulesOf(81)), Echoes{});
}

TEST(EchoDetection, AStepUpIsNoPeakBeforeItsTop)
{
  EXPECT_EQ(found({1, 2, 2, 3, 3, 1}, rulesOf(1)), (Echoes{{3.5, 3}}));
  EXPECT_EQ(found({3, 2, 1}, rulesOf(1)), (Echoes{{0.5, 3}})) << "at the first bin";
  EXPECT_EQ(found({1, 2, 3}, rulesOf(1)), (Echoes{{2.5, 3}})) << "at the last bin";
  EXPECT_EQ(found({4}, rulesOf(1)), (Echoes{{0.5, 4}}));
  EXPECT_EQ(found({}, rulesOf(1)), Echoes{});
}

TEST(EchoDetection, TheThresholdMayFallWithRange)
{
  EchoRules rules = rulesOf(0);
  rules.nearThreshold = 100;
  rules.farThreshold = 0;
  // At 2.5 of 10 m it is 75, at 7.5 m 25.
  EXPECT_EQ(found({0, 0, 74, 0, 0, 0, 0, 26, 0, 0}, rules), (Echoes{{7.5, 26}}));
  EXPECT_EQ(found({0, 0, 75, 0, 0, 0, 0, 24, 0, 0}, rules), (Echoes{{2.5, 75}}));
}

TEST(EchoDetection, NothingInTheDeadZoneIsAnEcho)
{
  EchoRules rules = rulesOf(10);
  rules.deadZone_m = 2;
  EXPECT_EQ(found({90, 0, 50, 0}, rules), (Echoes{{2.5, 50}}));
  rules.deadZone_m = 2.6;
  EXPECT_EQ(found({90, 0, 50, 0}, rules), Echoes{});
}

TEST(EchoDetection, OfCloseEchoesTheStrongestCounts)
{
  const std::vector<double> ping{0, 30, 0, 50, 0, 40, 0, 20, 0};
  EXPECT_EQ(found(ping, rulesOf(10, 2.5)), (Echoes{{3.5, 50}, {7.5, 20}}));
  EXPECT_EQ(found(ping, rulesOf(10, 2)), (Echoes{{1.5, 30}, {3.5, 50}, {5.5, 40}}))
      << "as far apart as the separation";
}

TEST(EchoDetection, KeepsTheNearest)
{
  EchoRules rules = rulesOf(10);
  rules.mostEchoes = 1;
  EXPECT_EQ(found({0, 20, 0, 90, 0}, rules), (Echoes{{1.5, 20}}));
}

TEST(EchoDetection, NaNIsBelowAnyThreshold)
{
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(found({nan, 20, nan, nan, 30, 10}, rulesOf(10)), (Echoes{{1.5, 20}, {4.5, 30}}));
}

TEST(EchoDetection, EchoesAreOrderedApartAndHighEnough)
{
  for (unsigned seed = 1; seed <= seeds(20); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    std::vector<double> ping(200);
    for (double& intensity : ping) intensity = random.integer(0, 40);
    EchoRules rules = rulesOf(random.uniform(0, 40), random.uniform(0, 8));
    rules.mostEchoes = static_cast<size_t>(random.integer(1, 8));
    rules.deadZone_m = random.uniform(0, 20);
    const Echoes echoes = findEchoes(ping, 50, rules);
    EXPECT_LE(echoes.size(), rules.mostEchoes);
    for (const DetectedEcho& echo : echoes)
    {
      EXPECT_GE(echo.range_m, rules.deadZone_m);
      EXPECT_GE(echo.intensity, rules.nearThreshold);
    }
    for (size_t i = 1; i < echoes.size(); ++i)
      EXPECT_GE(echoes[i].range_m - echoes[i - 1].range_m, rules.separation_m - 1e-12);
  }
}

TEST(EchoDetection, RefusesIllegalRules)
{
  EXPECT_NO_THROW(EchoRules().validate());
  const auto refused = [](const auto& change)
  {
    EchoRules rules;
    change(rules);
    EXPECT_THROW(rules.validate(), std::invalid_argument);
  };
  refused([](EchoRules& rules) { rules.deadZone_m = -1; });
  refused([](EchoRules& rules) { rules.separation_m = std::nan(""); });
  refused([](EchoRules& rules) { rules.nearThreshold = std::nan(""); });
  refused([](EchoRules& rules) { rules.farThreshold = std::numeric_limits<double>::infinity(); });
  refused([](EchoRules& rules) { rules.mostEchoes = 0; });
}

}  // namespace
}  // namespace lamap::test
