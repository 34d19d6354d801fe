#include <gtest/gtest.h>
#include <lamap_core/math/portable_math_four.h>
#include <support/seeded_scans.h>

#include <cmath>
#include <limits>

namespace lamap::test
{
namespace
{
double relative(double is, double shouldBe)
{
  return std::abs(is - shouldBe) / std::abs(shouldBe);
}

TEST(PortableMath, ExpFollowsTheLibraryWithin1e15)
{
  Random random(1);
  double worst = 0;
  for (int i = 0; i < 1000000; ++i)
  {
    const double x = i % 2 == 0 ? random.uniform(-700, 700) : random.uniform(-2, 2);
    worst = std::max(worst, relative(portableExp(x), std::exp(x)));
  }
  EXPECT_LE(worst, 1e-15);
  EXPECT_EQ(portableExp(0.0), 1.0);
  EXPECT_EQ(portableExp(-1e9), 0.0);
  EXPECT_TRUE(std::isfinite(portableExp(1e9)));
}

TEST(PortableMath, ExpInSinglePrecisionFollowsTheLibraryWithin2e7)
{
  Random random(2);
  double worst = 0;
  for (int i = 0; i < 1000000; ++i)
  {
    const auto x = static_cast<float>(i % 2 == 0 ? random.uniform(-86, 87) : random.uniform(-2, 2));
    worst = std::max(worst, relative(portableExp(x), std::exp(static_cast<double>(x))));
  }
  EXPECT_LE(worst, 2e-7);
  EXPECT_EQ(portableExp(0.0f), 1.0f);
  EXPECT_TRUE(std::isfinite(portableExp(1e30f)));
}

TEST(PortableMath, FourAtOnceEqualEachByItself)
{
  Random random(4);
  for (int i = 0; i < 100000; ++i)
  {
    Eigen::Array4f x;
    for (int k = 0; k < 4; ++k) x[k] = static_cast<float>(random.uniform(-100, 100));
    const Eigen::Array4f powers = portableExp(x), probs = logistic(x);
    for (int k = 0; k < 4; ++k)
    {
      ASSERT_EQ(powers[k], portableExp(x[k]));
      ASSERT_EQ(probs[k], logistic(x[k]));
    }
  }
}

TEST(PortableMath, LogarithmsFollowTheLibraryWithin1e14)
{
  Random random(3);
  double worst = 0;
  for (int i = 0; i < 1000000; ++i)
  {
    const double x = std::exp(random.uniform(-600, 600));
    if (std::abs(std::log(x)) > 1e-3) worst = std::max(worst, relative(portableLog(x), std::log(x)));
  }
  EXPECT_LE(worst, 1e-14);
  EXPECT_EQ(portableLog(1.0), 0.0);
}

TEST(PortableMath, LogisticHoldsAtBothEnds)
{
  for (const double f : {-800.0, -30.0, -1.0, 0.0, 1e-9, 2.0, 30.0, 800.0})
  {
    EXPECT_NEAR(logistic(f), 1 / (1 + std::exp(-f)), 1e-15) << f;
    EXPECT_NEAR(logistic(static_cast<float>(f)), 1 / (1 + std::exp(-f)), 1e-6) << f;
  }
  EXPECT_EQ(logistic(0.0), 0.5);
  EXPECT_EQ(logistic(0.0f), 0.5f);
}
}  // namespace
}  // namespace lamap::test
