// Two sums of log-odds of a cell, and how an overlapping Hilbert map reads them.
#include <gtest/gtest.h>
#include <lamap_core/overlapping/model.h>
#include <lamap_core/overlapping/reading.h>

#include <array>

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
