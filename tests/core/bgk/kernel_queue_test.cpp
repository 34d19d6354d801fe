#include <gtest/gtest.h>
#include <lamap_core/bgk/kernel_queue.h>
#include <support/seeded_scans.h>

#include <cmath>
#include <memory>
#include <vector>

namespace lamap::test
{
namespace
{
// Bits of maps depend on it: what is evaluated together is what is evaluated one by one.
TEST(KernelQueue, AddsTheWeightsOfTheKernelToTheLastBit)
{
  for (const KernelShape shape : {KernelShape::Sparse, KernelShape::SparseMatern32, KernelShape::WendlandC2})
    for (const double support : {0.6, 3.0, 5.5})
    {
      const Kernel kernel(shape, support, 1.7);
      const WeightScale scale(2.0, 1000);
      Random random(static_cast<uint64_t>(support * 10));
      for (const int count : {0, 1, 7, 15, 16, 17, 255, 256, 257, 1000})
      {
        SCOPED_TRACE(testing::Message() << static_cast<int>(shape) << " " << support << " " << count);
        const auto sums = std::make_unique<BlockSums>();
        const auto expected = std::make_unique<BlockSums>();
        bool anyWithin = false;
        {
          KernelQueue queue(kernel, scale, *sums);
          for (int i = 0; i < count; ++i)
          {
            // Up to the support and beyond, and the centre and the last distance before the support.
            double squared = std::pow(support * random.uniform(0, 1.1), 2);
            if (i % 50 == 7) squared = 0;
            if (i % 50 == 8) squared = std::nextafter(support * support, 0.0);
            const bool isWithin = squared < support * support;
            const double factor = random.uniform(0.01, 1.9);
            const auto cell = static_cast<size_t>(random.integer(0, kScanBlockCells - 1));
            queue.reserve(1);
            queue.push(squared, isWithin, factor, cell);
            if (isWithin) (*expected)[cell] += scale.quantized(factor * kernel.atSquaredDistance(squared));
            anyWithin = anyWithin || isWithin;
          }
          EXPECT_EQ(queue.any(), anyWithin);
        }
        EXPECT_TRUE(*sums == *expected);
      }
    }
}

}  // namespace
}  // namespace lamap::test
