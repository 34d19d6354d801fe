// Laws about threads that hold for all four maps. A program of its own, which a build with ThreadSanitizer
// runs.
#include <gtest/gtest.h>
#include <support/seeds.h>
#include <tbb/global_control.h>

#include <atomic>
#include <thread>

#include "law_maps.h"

namespace lamap::test
{
namespace
{
/// Lets four threads work at once, however few processors there are.
const tbb::global_control kFourThreads(tbb::global_control::max_allowed_parallelism, 4);

TYPED_TEST_SUITE(MapLaws, AllMaps);

/// More rays than one thread takes at a time.
constexpr int kManyRays = 500;

TYPED_TEST(MapLaws, TheNumberOfThreadsDoesNotMatter)
{
  for (unsigned seed = 1; seed <= seeds(20); ++seed)
  {
    Random random(seed);
    const Settings settings = randomSettingsForFiles<TypeParam>(random);
    SCOPED_TRACE("seed " + std::to_string(seed) + ": " + nameOf(settings));
    const std::vector<TakenScan> scans = randomScans(random, 2, kManyRays);
    const auto mapWith = [&](const std::vector<unsigned>& threads)
    {
      TypeParam map = made<TypeParam>(settings);
      for (size_t i = 0; i < scans.size(); ++i)
      {
        map.setThreadCount(threads[i % threads.size()]);
        map.insertObservation(*scans[i].observation, scans[i].robotPose_map);
      }
      return map;
    };
    const TypeParam reference = mapWith({1});
    ASSERT_FALSE(reference.isEmpty());
    const auto bytes = bytesOf(reference);
    const Cells cells = cellsOf(reference);
    for (const std::vector<unsigned>& threads :
         {std::vector<unsigned>{2}, {3}, {4}, {0}, {1, 4}})  // the last: it changes between scans
    {
      const TypeParam map = mapWith(threads);
      ASSERT_EQ(bytesOf(map), bytes) << threads.front() << " threads";
      ASSERT_TRUE(cellsOf(map) == cells) << threads.front() << " threads";
    }
  }
}

TYPED_TEST(MapLaws, AMapMayBeReadFromSeveralThreads)
{
  for (unsigned seed = 1; seed <= seeds(4); ++seed)
  {
    Random random(seed);
    const Settings settings = randomSettingsForFiles<TypeParam>(random);
    SCOPED_TRACE("seed " + std::to_string(seed) + ": " + nameOf(settings));
    const std::vector<TakenScan> scans = randomScans(random, 2, 100);
    const TypeParam map = mapOf<TypeParam>(settings, scans);
    // Asked first, and by this thread alone.
    const TypeParam reference = mapOf<TypeParam>(settings, scans);
    const auto bytes = bytesOf(reference);
    const Cells cells = cellsOf(reference);
    const TakenScan& scan = scans.front();
    const double likelihood =
        TypeParam(reference).computeObservationLikelihood(*scan.observation, scan.robotPose_map);
    const size_t occupied = reference.getAsSimplePointsMap()->size();
    std::atomic<size_t> wrong{0};
    std::vector<std::thread> readers;
    for (int i = 0; i < 4; ++i)
      readers.emplace_back(
          [&]
          {
            for (const auto& [index, prob, state, evidence] : cells)
            {
              const auto found = map.estimateCell({index[2], index[1], index[0]});
              if (!found || std::abs(found->prob - prob) > 1e-4) ++wrong;
            }
            if (cellsOf(map) != cells) ++wrong;
            if (bytesOf(TypeParam(map)) != bytes) ++wrong;
            if (map.getAsSimplePointsMap()->size() != occupied) ++wrong;
            auto& asMrptHasIt = const_cast<TypeParam&>(map);
            if (asMrptHasIt.computeObservationLikelihood(*scan.observation, scan.robotPose_map) != likelihood)
              ++wrong;
          });
    for (std::thread& reader : readers) reader.join();
    EXPECT_EQ(wrong, 0U);
  }
}

TYPED_TEST(MapLaws, DifferentMapsMayBeFilledFromSeveralThreads)
{
  Random random(9);
  const std::vector<TakenScan> scans = randomScans(random, 2, kManyRays);
  std::vector<TypeParam> maps(4);
  std::vector<std::thread> writers;
  for (TypeParam& map : maps)
    writers.emplace_back(
        [&]
        {
          map.setThreadCount(2);
          for (const TakenScan& scan : scans) map.insertObservation(*scan.observation, scan.robotPose_map);
        });
  for (std::thread& writer : writers) writer.join();
  for (const TypeParam& map : maps) EXPECT_EQ(bytesOf(map), bytesOf(maps[0]));
}
}  // namespace
}  // namespace lamap::test
