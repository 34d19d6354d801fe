// GP maps at the corners of their options.
#include <gtest/gtest.h>
#include <lamap_core/gp/map.h>
#include <lamap_core/grid/evidence_block.h>

namespace lamap::test
{
namespace
{
TEST(GpLimits, EvidenceOfExtremeOptionsFitsItsSums)
{
  for (const GpFusion fusion : {GpFusion::Bayes, GpFusion::Bcm})
    for (const double gain : {1.0, 1e3, 1e6})
      for (const double noise : {1e-6, 1e-2, 1e3})
        for (const double minVariance : {1e-3, 1e3})
        {
          SCOPED_TRACE(testing::Message() << gain << " " << noise << " " << minVariance);
          GpStructure structure;
          structure.fusion = fusion;
          structure.squashGain = gain;
          structure.noiseVariance = noise;
          structure.minVariance = minVariance;
          GpMap map(structure);
          for (int i = 0; i < 3; ++i)
          {
            map.addObservation({1, 1, 1}, true, {});
            map.addObservation({5, 5, 5}, false, {});
          }
          ASSERT_TRUE(map.cell({1, 1, 1}, {}));
          EXPECT_GT(map.cell({1, 1, 1}, {})->prob, 0.5);
          EXPECT_LT(map.cell({5, 5, 5}, {})->prob, 0.5);
          Scan scan;
          RayFan& fan = scan.fans.emplace_back();
          fan.centre = {0.03, 0.02, 0.05};
          for (int i = -2; i <= 2; ++i) fan.addReturn({0.52, 0.11 * i + 0.013, 0.07});
          EXPECT_NO_THROW((void)map.insert(scan, {}, 1));
          const Evidence& evidence = map.evidence();
          for (const BlockIndex& index : evidence.sortedBlocks())
          {
            const EvidenceBlock& block = *evidence.find(index);
            EXPECT_NO_THROW((void)EvidenceBlock::fromWords(evidence.shape(), evidence.kind(), block.wide(),
                                                           block.pruned(), block.words(evidence.shape())));
          }
        }
}
}  // namespace
}  // namespace lamap::test
