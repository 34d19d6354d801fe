#include <gtest/gtest.h>
#include <lamap_core/bgk/kernel.h>
#include <support/bgk_oracle.h>
#include <support/seeded_scans.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace lamap::test
{
namespace
{
const std::vector<KernelShape> kShapes{KernelShape::Sparse, KernelShape::SparseMatern32,
                                       KernelShape::WendlandC2};

void expectRefused(double support, double scale, const std::string& name, const std::string& printed)
{
  try
  {
    (void)Kernel(KernelShape::Sparse, support, scale);
    ADD_FAILURE() << name << " = " << printed << " is taken";
  }
  catch (const std::invalid_argument& error)
  {
    const std::string message = error.what();
    EXPECT_NE(message.find(name), std::string::npos) << message;
    EXPECT_NE(message.find(printed), std::string::npos) << message;
    EXPECT_NE(message.find("> 0"), std::string::npos) << message;
  }
}

// By hand at r = 1/4: (2 + 0)(3/4)/3 + 1/(2π).
TEST(SparseKernel, MatchesHandComputedQuarterPoint)
{
  EXPECT_NEAR(Kernel(KernelShape::Sparse, 2.0, 1.0)(0.5), 0.659154943091895, 1e-12);
  EXPECT_NEAR(Kernel(KernelShape::Sparse, 2.0, 3.0)(0.5), 3 * 0.659154943091895, 3e-12);
}

// By hand at r = 1/2: (2 − 1)(1/2)/3 + 0.
TEST(SparseKernel, MatchesHandComputedMidpoint)
{
  EXPECT_NEAR(Kernel(KernelShape::Sparse, 0.2, 1.0)(0.1), 1.0 / 6.0, 1e-12);
}

// By hand at r = 1/2: (1/2)⁴ · 3.
TEST(WendlandKernel, MatchesHandComputedMidpoint)
{
  EXPECT_NEAR(Kernel(KernelShape::WendlandC2, 1.0, 1.0)(0.5), 0.1875, 1e-12);
}

// By hand at r = 1/2: 1/6 · (1 + √3/2) · exp(−√3/2) = 1/6 · 1.8660254037844386 · 0.4206202439…
TEST(SparseMaternKernel, MatchesHandComputedMidpoint)
{
  EXPECT_NEAR(Kernel(KernelShape::SparseMatern32, 1.0, 1.0)(0.5),
              1.8660254037844386 / 6.0 * std::exp(-0.8660254037844386), 1e-12);
}

TEST(KernelProperty, FollowsItsFormulaWithin1e11)
{
  double worst = 0;
  for (const KernelShape shape : kShapes)
  {
    SCOPED_TRACE(static_cast<int>(shape));
    const Kernel kernel(shape, 1.0, 1.0);
    for (int i = 0; i < 200000; ++i)
    {
      const double r = i / 200000.0;
      worst = std::max(worst, std::abs(kernel(r) - oracleKernel(shape, r, 1.0, 1.0)));
    }
    Random random(7);
    for (int i = 0; i < 20000; ++i)
    {
      const double support = std::exp(random.uniform(-7, 7)), scale = std::exp(random.uniform(-5, 5));
      const double distance = random.uniform(0, 1.1) * support;
      const double expected = oracleKernel(shape, distance, support, scale);
      ASSERT_NEAR(Kernel(shape, support, scale)(distance), expected, 1e-11 * scale) << distance / support;
      ASSERT_NEAR(Kernel(shape, support, scale).atSquaredDistance(distance * distance), expected,
                  1e-11 * scale);
    }
  }
  EXPECT_LE(worst, 1e-11);
  RecordProperty("worst_deviation", std::to_string(worst * 1e15) + "e-15");
}

TEST(KernelProperty, IsTheScaleAtZeroAndNothingAtAndBeyondTheSupport)
{
  for (const KernelShape shape : kShapes)
    for (const double support : {0.05, 0.1, 0.2, 0.3, 1.0, 7.0, 1e-6, 1e6})
    {
      SCOPED_TRACE(support);
      const Kernel kernel(shape, support, 2.5);
      EXPECT_NEAR(kernel(0.0), 2.5, 1e-14);
      EXPECT_LE(kernel(0.0), 2.5);
      EXPECT_EQ(kernel(support), 0.0);
      EXPECT_EQ(kernel(std::nextafter(support, 1e9)), 0.0);
      EXPECT_EQ(kernel(1e3 * support), 0.0);
      EXPECT_EQ(kernel(std::numeric_limits<double>::infinity()), 0.0);
      EXPECT_EQ(kernel.atSquaredDistance(support * support), 0.0);
      EXPECT_EQ(kernel.support(), support);
      EXPECT_EQ(kernel.scale(), 2.5);
    }
}

TEST(KernelProperty, IsNeverNegativeAndNeverIncreases)
{
  for (const KernelShape shape : kShapes)
  {
    SCOPED_TRACE(static_cast<int>(shape));
    const Kernel kernel(shape, 1.0, 1.0);
    double last = 1.0;
    for (int i = 0; i <= 1000000; ++i)
    {
      const double weight = kernel(i / 1000000.0);
      ASSERT_GE(weight, 0.0) << i;
      // Neighbouring values differ by less than rounding at both flat ends.
      ASSERT_LE(weight, last + 1e-15) << i;
      last = weight;
    }
  }
}

TEST(Kernel, RefusesBadArgumentsByNameValueAndRange)
{
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  expectRefused(0.0, 1.0, "kernelSupport", "0");
  expectRefused(-0.25, 1.0, "kernelSupport", "-0.25");
  expectRefused(nan, 1.0, "kernelSupport", "nan");
  expectRefused(inf, 1.0, "kernelSupport", "inf");
  expectRefused(1.0, 0.0, "kernelScale", "0");
  expectRefused(1.0, -3.5, "kernelScale", "-3.5");
  expectRefused(1.0, nan, "kernelScale", "nan");
  expectRefused(1.0, inf, "kernelScale", "inf");
}
}  // namespace
}  // namespace lamap::test
