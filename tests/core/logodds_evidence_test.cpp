// Two signed sums of log-odds in the unsigned numbers of evidence blocks.
#include <gtest/gtest.h>
#include <lamap_core/overlapping/logodds_evidence.h>
#include <support/seeded_scans.h>

namespace lamap::test
{
namespace
{
TEST(LogoddsEvidence, MissingAndZeroAreNotTheSame)
{
  EXPECT_EQ(LogoddsSums::encoded(std::nullopt), 0u);
  EXPECT_EQ(LogoddsSums::encoded(0), 1u);
  for (const int64_t sum :
       {int64_t{0}, int64_t{1}, int64_t{-1}, int64_t{-12345}, LogoddsSums::kLimit, -LogoddsSums::kLimit})
  {
    EXPECT_EQ(LogoddsSums::decoded(LogoddsSums::encoded(sum)), sum);
    EXPECT_EQ(LogoddsSums::encoded(sum) >> 63, 0u);
  }
}

TEST(LogoddsEvidence, SumsAreRoundedOnceAndHeldToALimit)
{
  EXPECT_EQ(logoddsUnits(1.0f, 1.0), 1 << 20);
  EXPECT_EQ(logoddsUnits(-1.5f, 0.5), -(3 << 18));
  EXPECT_EQ(logoddsUnits(1e9f, 1.0), 1000ll << 20);
  EXPECT_EQ(logoddsUnits(-1e30f, 0.5), -(500ll << 20));
}

TEST(LogoddsEvidence, AddingBeyondTheLimitIsRefused)
{
  LogoddsSums sums;
  sums.inField = LogoddsSums::kLimit;
  const Evidence most = sums.evidence();
  sums.inField = 1;
  EXPECT_THROW((void)addLogodds(most, sums.evidence()), std::overflow_error);
  sums.inField = -1;
  EXPECT_EQ(LogoddsSums::of(addLogodds(most, sums.evidence())).inField, LogoddsSums::kLimit - 1);
}

TEST(LogoddsEvidence, WhatWasSeenCountsElseTheRestWithinItsLimit)
{
  LogoddsSums sums;
  sums.outOfField = 5 << 20;
  EXPECT_DOUBLE_EQ(logoddsOf(sums.evidence(), 0.6), 0.6);
  EXPECT_DOUBLE_EQ(logoddsOf(sums.evidence(), 7), 5);
  sums.outOfField = -(5 << 20);
  EXPECT_DOUBLE_EQ(logoddsOf(sums.evidence(), 0.6), -0.6);
  sums.inField = 1 << 18;
  EXPECT_DOUBLE_EQ(logoddsOf(sums.evidence(), 0.6), 0.25);
}

TEST(LogoddsEvidenceProperty, MeansAreRoundedToTheNearestUnit)
{
  Random random(1);
  const BlockShape shape(1, false);
  for (int trial = 0; trial < 200; ++trial)
  {
    DenseBlock block(shape);
    int64_t inField = 0;
    int64_t outOfField = 0;
    for (uint32_t i = 0; i < 8; ++i)
    {
      LogoddsSums sums;
      sums.inField = random.integer(-1000, 1000);
      if (random.chance(0.5)) sums.outOfField = random.integer(-5, 5);
      inField += *sums.inField;
      outOfField += sums.outOfField.value_or(0);
      block.occupied[i] = sums.evidence().occupied;
      block.free[i] = sums.evidence().free;
      block.setObserved(i);
    }
    Evidence mean;
    ASSERT_TRUE(meanLogodds(block, 0, 8, mean));
    const LogoddsSums sums = LogoddsSums::of(mean);
    const auto rounded = [](int64_t sum)
    { return static_cast<int64_t>(std::floor(static_cast<double>(sum) / 8 + 0.5)); };
    ASSERT_EQ(sums.inField, rounded(inField));
    ASSERT_EQ(sums.outOfField.value_or(0), rounded(outOfField));
    block.occupied[3] = 0;
    ASSERT_FALSE(meanLogodds(block, 0, 8, mean));
  }
}

TEST(LogoddsEvidenceProperty, BlocksAddInAnyOrderAndSplitAgain)
{
  for (unsigned seed = 1; seed <= 20; ++seed)
  {
    Random random(seed);
    const BlockShape shape(random.integer(1, 3), random.chance(0.5));
    std::vector<std::pair<uint32_t, Evidence>> added;
    for (int i = 0; i < 60; ++i)
    {
      LogoddsSums sums;
      if (random.chance(0.7)) sums.inField = random.integer(-3, 3) * (random.chance(0.05) ? 1ll << 33 : 1);
      if (!sums.inField || random.chance(0.3)) sums.outOfField = random.integer(-3, 3);
      added.emplace_back(random.integer(0, static_cast<int>(shape.cellCount()) - 1), sums.evidence());
    }
    const auto sumOf = [&](Pruning pruning)
    {
      EvidenceBlock block;
      LogoddsAdder adder(shape);
      for (const auto& [offset, evidence] : added)
      {
        adder.clear();
        adder.set(offset, evidence);
        adder.addTo(block, {pruning, pruning == Pruning::None ? OctantMerger{} : OctantMerger{mergeEqual}});
      }
      return block;
    };
    const EvidenceBlock block = sumOf(Pruning::Lossless);
    const EvidenceBlock plain = sumOf(Pruning::None);
    random.shuffle(added);
    EXPECT_EQ(block.words(), sumOf(Pruning::Lossless).words());
    for (uint32_t offset = 0; offset < shape.cellCount(); ++offset)
    {
      LogoddsSums expected;
      for (const auto& [at, evidence] : added)
      {
        if (at != offset) continue;
        const LogoddsSums sums = LogoddsSums::of(evidence);
        if (sums.inField) expected.inField = expected.inField.value_or(0) + *sums.inField;
        if (sums.outOfField) expected.outOfField = expected.outOfField.value_or(0) + *sums.outOfField;
      }
      EXPECT_TRUE(block.at(shape, offset) == expected.evidence());
      EXPECT_TRUE(plain.at(shape, offset) == expected.evidence());
    }
  }
}

}  // namespace
}  // namespace lamap::test
