#include <gtest/gtest.h>
#include <lamap_core/bgk/evidence_table.h>

#include <random>
#include <tuple>
#include <vector>

namespace lamap
{
namespace
{
/// Masks of a block and of those around it, with gaps, whose cells are marked by chance.
class RandomNeighbourhood
{
 public:
  RandomNeighbourhood(std::mt19937& random, double share, bool planar) : masks_(27)
  {
    std::uniform_real_distribution<double> chance;
    neighbourhood_.masks.assign(27, nullptr);
    for (size_t i = 0; i < 27; ++i)
    {
      const bool isThere = chance(random) < 0.8 && (!planar || i / 9 == 1);
      if (!isThere) continue;
      for (size_t z = 0; z < kScanBlockEdge; ++z)
        for (int bit = 0; bit < 64; ++bit)
          if ((!planar || z == kLayer) && chance(random) < share) masks_[i][z] |= uint64_t{1} << bit;
      neighbourhood_.masks[i] = &masks_[i];
    }
  }
  MaskNeighbourhood& get() { return neighbourhood_; }

  static constexpr size_t kLayer = 5;  ///< of a planar map

 private:
  std::vector<CellMask> masks_;
  MaskNeighbourhood neighbourhood_;
};

class EvidenceTables : public ::testing::TestWithParam<std::tuple<double, bool>>
{
};

TEST_P(EvidenceTables, AreTheSumsOfTheStencilRounded)
{
  const auto [support, planar] = GetParam();
  const CellStencil stencil(Kernel(KernelShape::Sparse, support, 0.7), 0.5, planar);
  ASSERT_TRUE(EvidenceTable::isTabulable(stencil));
  const EvidenceTable table(stencil, planar);
  std::mt19937 random(3);
  for (const double share : {0.0, 0.01, 0.3, 0.9, 1.0})
    for (int round = 0; round < 10; ++round)
    {
      RandomNeighbourhood marked(random, share, planar);
      BlockSums sums{};
      const Layers expected = stencil.addUp(marked.get(), sums);
      EvidenceTable::BlockEvidence evidence{};
      const Layers reached = table.look(marked.get(), evidence);
      if (expected.any())
      {
        ASSERT_LE(reached.begin, expected.begin);
        ASSERT_GE(reached.end, expected.end);
      }
      for (size_t cell = 0; cell < evidence.size(); ++cell)
        ASSERT_EQ(evidence[cell], stencil.scale().evidence(sums[cell])) << cell << " of " << share;
    }
}

INSTANTIATE_TEST_SUITE_P(Stencils, EvidenceTables,
                         ::testing::Combine(::testing::Values(1.2, 1.5, 1.8, 2.0), ::testing::Bool()));

TEST(EvidenceTable, IsForStencilsThatReachOneCell)
{
  EXPECT_FALSE(EvidenceTable::isTabulable(CellStencil(Kernel(KernelShape::Sparse, 3.0, 1.0), 1, false)));
  EXPECT_FALSE(EvidenceTable::isTabulable(CellStencil(Kernel(KernelShape::Sparse, 1.0, 1.0), 1, false)));
}

}  // namespace
}  // namespace lamap
