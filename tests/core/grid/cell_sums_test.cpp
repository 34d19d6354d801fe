// Two signed sums in the unsigned numbers of evidence blocks.
#include <gtest/gtest.h>
#include <lamap_core/grid/cell_sums.h>
#include <lamap_core/grid/evidence_change.h>
#include <support/seeded_scans.h>

#include <limits>
#include <stdexcept>

namespace lamap::test
{
namespace
{
TEST(CellSums, MissingAndZeroAreNotTheSame)
{
  EXPECT_EQ(SignedSums::encoded(std::nullopt), 0u);
  EXPECT_EQ(SignedSums::encoded(0), 1u);
  for (const int64_t sum :
       {int64_t{0}, int64_t{1}, int64_t{-1}, int64_t{-12345}, kMostSignedSum, -kMostSignedSum})
  {
    EXPECT_EQ(SignedSums::decoded(SignedSums::encoded(sum)), sum);
    EXPECT_EQ(SignedSums::encoded(sum) >> 63, 0u);
  }
}

TEST(CellSums, NumbersAreRoundedToTheNearestUnit)
{
  EXPECT_EQ(inEvidenceUnits(1.0), 1 << 20);
  EXPECT_EQ(inEvidenceUnits(-0.75), -(3 << 18));
  EXPECT_EQ(inEvidenceUnits(0.49 * kEvidenceUnit), 0);
  EXPECT_EQ(inEvidenceUnits(0.5 * kEvidenceUnit), 1);
  EXPECT_EQ(inEvidenceUnits(-0.51 * kEvidenceUnit), -1);
  EXPECT_EQ(inEvidenceUnits(0x1p41), kMostSignedSum);
  EXPECT_EQ(inEvidenceUnits(1e300), kMostSignedSum);
  EXPECT_EQ(inEvidenceUnits(-1e300), -kMostSignedSum);
}

TEST(CellSums, AddingBeyondTheLimitIsRefused)
{
  const CellSums most = SignedSums{kMostSignedSum, std::nullopt}.coded();
  const auto plus = [&](int64_t added) {
    return addSums(SumKind::Signed, most, SignedSums{added, std::nullopt}.coded());
  };
  EXPECT_THROW((void)plus(1), std::overflow_error);
  EXPECT_EQ(SignedSums::of(plus(-1)).first, kMostSignedSum - 1);
  constexpr uint64_t kMost = (uint64_t{1} << 63) - 1;
  EXPECT_TRUE(addSums(SumKind::Counts, {kMost - 1, 5}, {1, kMost - 5}) == (CellSums{kMost, kMost}));
  EXPECT_THROW((void)addSums(SumKind::Counts, {kMost, 5}, {1, 0}), std::overflow_error);
  EXPECT_THROW((void)addSums(SumKind::Counts, {5, kMost}, {0, 1}), std::overflow_error);
}

TEST(CellSumsProperty, MeansAreRoundedToTheNearestUnit)
{
  Random random(1);
  for (int trial = 0; trial < 200; ++trial)
  {
    std::array<CellSums, 8> cells;
    int64_t first = 0;
    int64_t second = 0;
    for (CellSums& cell : cells)
    {
      SignedSums sums;
      sums.first = random.integer(-1000, 1000);
      if (random.chance(0.5)) sums.second = random.integer(-5, 5);
      first += *sums.first;
      second += sums.second.value_or(0);
      cell = sums.coded();
    }
    const SignedSums mean = SignedSums::of(meanSums(SumKind::Signed, cells.data(), 8));
    const auto rounded = [](int64_t sum)
    { return static_cast<int64_t>(std::floor(static_cast<double>(sum) / 8 + 0.5)); };
    ASSERT_EQ(mean.first, rounded(first));
    ASSERT_EQ(mean.second.value_or(0), rounded(second));
  }
}

TEST(CellSumsProperty, MeansOfCountsAreRoundedAndNeverVanish)
{
  EXPECT_TRUE(meanSums(SumKind::Counts, std::array<CellSums, 4>{{{1, 0}, {0, 0}, {0, 0}, {0, 0}}}.data(),
                       4) == (CellSums{1, 0}));
  EXPECT_TRUE(meanSums(SumKind::Counts, std::array<CellSums, 4>{{{0, 1}, {0, 0}, {0, 0}, {0, 0}}}.data(),
                       4) == (CellSums{0, 1}));
  constexpr uint64_t kMost = (uint64_t{1} << 63) - 1;
  EXPECT_TRUE(meanSums(SumKind::Counts, std::array<CellSums, 2>{{{kMost, 7}, {kMost, 8}}}.data(), 2) ==
              (CellSums{kMost, 8}));
}

TEST(CellSumsProperty, BlocksAddInAnyOrderAndSplitAgain)
{
  const Workers workers(1);
  for (unsigned seed = 1; seed <= 20; ++seed)
  {
    Random random(seed);
    const BlockShape shape(random.integer(1, 3), random.chance(0.5));
    std::vector<std::pair<uint32_t, CellSums>> added;
    for (int i = 0; i < 60; ++i)
    {
      SignedSums sums;
      if (random.chance(0.7)) sums.first = random.integer(-3, 3) * (random.chance(0.05) ? 1ll << 33 : 1);
      if (!sums.first || random.chance(0.3)) sums.second = random.integer(-3, 3);
      added.emplace_back(random.integer(0, static_cast<int>(shape.cellCount()) - 1), sums.coded());
    }
    const auto sumOf = [&](Pruning pruning)
    {
      const auto ruleFor = [pruning](const BlockIndex&) {
        return OctantRule{pruning, pruning == Pruning::None ? OctantMerger{} : OctantMerger{mergeEqual}};
      };
      Evidence sum(shape, SumKind::Signed);
      DenseBlock dense(shape);
      for (const auto& [offset, sums] : added)
      {
        Evidence one(shape, SumKind::Signed);
        dense.clear();
        dense.set(offset, sums);
        one.findOrCreate({}).pack(shape, dense, {});
        EvidenceChange::addition(sum, std::move(one), ruleFor, workers).commit();
      }
      return *sum.find({});
    };
    const EvidenceBlock block = sumOf(Pruning::Lossless);
    const EvidenceBlock plain = sumOf(Pruning::None);
    random.shuffle(added);
    EXPECT_EQ(block.words(shape), sumOf(Pruning::Lossless).words(shape));
    for (uint32_t offset = 0; offset < shape.cellCount(); ++offset)
    {
      SignedSums expected;
      for (const auto& [at, cell] : added)
      {
        if (at != offset) continue;
        const SignedSums sums = SignedSums::of(cell);
        if (sums.first) expected.first = expected.first.value_or(0) + *sums.first;
        if (sums.second) expected.second = expected.second.value_or(0) + *sums.second;
      }
      EXPECT_TRUE(block.at(shape, offset) == expected.coded());
      EXPECT_TRUE(plain.at(shape, offset) == expected.coded());
    }
  }
}

}  // namespace
}  // namespace lamap::test
