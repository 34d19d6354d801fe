// The same bytes for every number of threads; and what may be called from several threads at once.
#include <gtest/gtest.h>
#include <lamap_core/hilbert/map.h>
#include <support/hilbert_states.h>
#include <support/seeded_scans.h>

#include <tbb/global_control.h>

#include <atomic>
#include <thread>

namespace lamap::test
{
namespace
{
/// Lets four threads work at once, however few processors there are.
const tbb::global_control kFourThreads(tbb::global_control::max_allowed_parallelism, 4);

HilbertInference inference()
{
  HilbertInference inference;
  inference.maxRange = 3.0;
  inference.trainingPoints = HilbertPoints::Points;  // many, so that there are several chunks
  return inference;
}

TEST(HilbertMapProperty, NumberOfThreadsDoesNotMatter)
{
  for (const HilbertStructure& structure : allHilbertStructures())
  {
    SCOPED_TRACE(nameOf(structure));
    Random random(1);
    std::vector<Scan> scans;
    for (int i = 0; i < 2; ++i) scans.push_back(roomScan(random, random.inCube(0.7), 900));
    const auto mapOf = [&](unsigned threads)
    {
      HilbertMap map(structure);
      for (const Scan& scan : scans) map.insert(scan, inference(), nullptr, threads);
      map.train(threads);
      return map;
    };
    const HilbertMap reference = mapOf(1);
    ASSERT_FALSE(reference.empty());
    for (const unsigned threads : {2u, 3u, 4u, 0u})
    {
      const HilbertMap map = mapOf(threads);
      ASSERT_EQ(differenceOf(reference.state(), map.state()), "") << threads << " threads";
      std::vector<double> one, many;
      reference.visitCells([&](const CellIndex&, double f) { one.push_back(f); }, 1);
      map.visitCells([&](const CellIndex&, double f) { many.push_back(f); }, threads);
      ASSERT_EQ(one, many);
    }
  }
}

TEST(HilbertMap, MayBeAskedFromSeveralThreads)
{
  for (const HilbertStructure& structure : allHilbertStructures())
  {
    SCOPED_TRACE(nameOf(structure));
    Random random(2);
    const Scan scan = roomScan(random, {0, 0, 0}, 200);
    HilbertMap map(structure), reference(structure);
    map.insert(scan, inference(), nullptr, 1);
    reference.insert(scan, inference(), nullptr, 1);
    reference.train(1);
    std::atomic<size_t> wrong{0};
    std::vector<std::thread> readers;
    for (unsigned i = 0; i < 4; ++i)
      readers.emplace_back(
          [&, i]
          {
            Random own(i);
            for (int k = 0; k < 50; ++k)
            {
              const Eigen::Vector3d point = own.inCube(1.4);
              if (map.logoddsAt(point) != reference.logoddsAt(point)) ++wrong;
            }
            std::vector<ReachedLogodds> answers;
            map.logoddsOf({-4, -4, -4}, {8, 8, 8}, answers);
            if (answers.size() != 512) ++wrong;
            const HilbertMap copy = map;
            if (!differenceOf(copy.state(), reference.state()).empty()) ++wrong;
          });
    for (std::thread& reader : readers) reader.join();
    EXPECT_EQ(wrong, 0u);
  }
}
}  // namespace
}  // namespace lamap::test
