#include <gtest/gtest.h>
#include <lamap_sim/random.h>

#include <cmath>
#include <vector>

namespace lamap::sim
{
namespace
{
TEST(SineCosine, AgreesWithTheLibraryWithinRounding)
{
  Random random(1);
  for (int i = 0; i < 20000; ++i)
  {
    const double angle = random.uniform(-400, 400);
    const SineCosine both = sineCosine(angle);
    EXPECT_NEAR(both.sine, std::sin(angle), 1e-15) << angle;
    EXPECT_NEAR(both.cosine, std::cos(angle), 1e-15) << angle;
  }
}

// Values from an independent program (Mersenne twister and splitmix64, written from their definitions).
TEST(Random, GivesTheSameNumbersEverywhere)
{
  Random random(7, 3);
  EXPECT_EQ(random.uniform(0, 1), 0x1.9c9323c4938a6p-2);
  EXPECT_EQ(random.integer(-5, 5), -4);
  EXPECT_EQ(random.normal(), -0x1.71f1107c1214ap+0);
}

TEST(Random, StreamsAndSeedsDiffer)
{
  std::vector<double> first;
  for (const uint64_t seed : {1ULL, 2ULL, 3ULL})
    for (const uint64_t stream : {0ULL, 1ULL, 2ULL}) first.push_back(Random(seed, stream).uniform(0, 1));
  for (size_t i = 0; i < first.size(); ++i)
    for (size_t j = 0; j < i; ++j) EXPECT_NE(first[i], first[j]);
}

TEST(Random, NormalNumbersHaveTheMomentsOfAGaussian)
{
  Random random(5);
  constexpr int kCount = 200000;
  double sum = 0;
  double squares = 0;
  double fourth = 0;
  int beyondTwo = 0;
  for (int i = 0; i < kCount; ++i)
  {
    const double x = random.normal();
    sum += x;
    squares += x * x;
    fourth += x * x * x * x;
    beyondTwo += std::abs(x) > 2 ? 1 : 0;
  }
  EXPECT_NEAR(sum / kCount, 0, 0.01);
  EXPECT_NEAR(squares / kCount, 1, 0.02);
  EXPECT_NEAR(fourth / kCount, 3, 0.1);
  EXPECT_NEAR(static_cast<double>(beyondTwo) / kCount, 0.0455, 0.002);
}
}  // namespace
}  // namespace lamap::sim
