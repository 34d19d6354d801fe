// Two sums of log-odds of a cell, and how an overlapping Hilbert map reads them.
#include <gtest/gtest.h>
#include <lamap_core/math/portable_math.h>
#include <lamap_core/overlapping/model.h>
#include <lamap_core/overlapping/reading.h>

#include <array>
#include <cmath>

namespace lamap::test
{
namespace
{
TEST(LogoddsReading, SumsAreRoundedOnceAndHeldToALimit)
{
  EXPECT_EQ(logoddsUnits(1.0f, 1.0), 1 << 20);
  EXPECT_EQ(logoddsUnits(-1.5f, 0.5), -(3 << 18));
  EXPECT_EQ(logoddsUnits(1e9f, 1.0), 1000ll << 20);
  EXPECT_EQ(logoddsUnits(-1e30f, 0.5), -(500ll << 20));
}

TEST(LogoddsReading, WhatWasSeenCountsElseTheRestWithinItsLimit)
{
  SignedSums sums;
  sums.second = 5 << 20;
  EXPECT_DOUBLE_EQ(logoddsOf(sums.coded(), 0.6), 0.6);
  EXPECT_DOUBLE_EQ(logoddsOf(sums.coded(), 7), 5);
  sums.second = -(5 << 20);
  EXPECT_DOUBLE_EQ(logoddsOf(sums.coded(), 0.6), -0.6);
  sums.first = 1 << 18;
  EXPECT_DOUBLE_EQ(logoddsOf(sums.coded(), 0.6), 0.25);
}

TEST(LogoddsReading, LogoddsInTheFieldTendToTheirLimitInTheSameOrder)
{
  EXPECT_DOUBLE_EQ(saturated(6, 6), 6 / std::pow(2, 0.25));
  EXPECT_DOUBLE_EQ(saturated(-3, 6), -3 / std::pow(1 + 1.0 / 16, 0.25));
  EXPECT_NEAR(saturated(0.8, 6), 0.8, 1e-4);
  double before = saturated(-1000, 6);
  EXPECT_GE(before, -6);
  for (int i = -999; i <= 1000; ++i)
  {
    const double now = saturated(i, 6);
    ASSERT_GT(logistic(now), logistic(before)) << i;  // not even the surest cells are alike
    before = now;
  }
  EXPECT_LE(before, 6);
  EXPECT_EQ(saturated(1e300, 6), 6);

  OverlappingStructure structure;
  structure.fieldLimit = 2;
  structure.outOfFieldLimit = 3;
  const OverlappingReading reading{structure};
  const auto read = [&](const SignedSums& sums) { return reading.read({}, sums.coded(), {}); };
  const SignedSums many{-(50 << 20), std::nullopt};
  EXPECT_NEAR(read(many).prob, 1 / (1 + std::exp(2.0)), 1e-6);
  EXPECT_DOUBLE_EQ(read(many).evidence[0], -50);
  EXPECT_DOUBLE_EQ(read({1 << 20, std::nullopt}).prob, 1 / (1 + std::exp(-1 / std::pow(17.0 / 16, 0.25))));
  EXPECT_DOUBLE_EQ(read({std::nullopt, 50 << 20}).prob, 1 / (1 + std::exp(-3.0)));  // has a limit of its own
  structure.fieldLimit = 0;
  EXPECT_LT(OverlappingReading{structure}.read({}, many.coded(), {}).prob, 1e-20);
}

TEST(LogoddsReading, HasNoMeanOfCellsInsideAndOutsideOfAField)
{
  const OverlappingReading reading{OverlappingStructure{}};
  std::array<CellSums, 8> cells;
  cells.fill(SignedSums{4, 2}.coded());
  CellSums mean;
  ASSERT_TRUE(reading.mean(cells.data(), 8, mean));
  EXPECT_TRUE(mean == (SignedSums{4, 2}.coded()));
  cells[3] = SignedSums{std::nullopt, 2}.coded();
  EXPECT_FALSE(reading.mean(cells.data(), 8, mean));
}

}  // namespace
}  // namespace lamap::test
