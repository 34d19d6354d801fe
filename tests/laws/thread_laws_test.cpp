// Laws about threads that hold for all four maps. A program of its own, which a build with ThreadSanitizer
// runs.
#include <gtest/gtest.h>
#include <support/seeds.h>
#include <tbb/global_control.h>

#include <atomic>
#include <cmath>
#include <functional>
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

/// Settings with which a map leaves different work to whoever asks it first.
template <typename Map>
std::vector<Settings> settingsThatDefer()
{
  std::vector<Settings> all{{}};
  if (std::is_same_v<Map, CGPMap>) all.push_back({{"insertOpts.nested", "true"}});
  if (std::is_same_v<Map, CHilbertMap>)
  {
    all.push_back({{"creationOpts.training", "batch"}});
    all.push_back({{"creationOpts.training", "sgd"}});
  }
  if (std::is_same_v<Map, COverlappingHilbertMap>) all.push_back({{"insertOpts.scansPerModel", "2"}});
  return all;
}

/// Everything that a map derives from its cells, each as a number.
std::vector<std::function<double(const CLearnedMap&)>> questionsAfter(const TakenScan& scan)
{
  using mrpt::math::TPoint3D;
  const TPoint3D robot(scan.robotPose_map.x(), scan.robotPose_map.y(), scan.robotPose_map.z());
  return {
      [&scan](const CLearnedMap& map)
      {
        auto& asMrptHasIt = const_cast<CLearnedMap&>(map);
        return asMrptHasIt.computeObservationLikelihood(*scan.observation, scan.robotPose_map);
      },
      [robot](const CLearnedMap& map)
      {
        TPoint3D end;
        double sum = 0;
        for (int i = 0; i < 12; ++i)
          sum += 1 + map.castRay(robot, {std::cos(0.5 * i), std::sin(0.5 * i), 0.1}, end, true, 3) + end.x;
        return sum;
      },
      [robot](const CLearnedMap& map)
      {
        double sum = 0;
        for (int i = -8; i <= 8; ++i)
          if (const auto found = map.estimateAt(robot + TPoint3D(0.1 * i, 0.05 * i, 0.03)))
            sum += found->prob;
        return sum;
      },
      [](const CLearnedMap& map)
      {
        double sum = 0;  // of whole numbers: cells come in any order
        map.visitCells([&](const CellIndex& cell, const CellEstimate& found)
                       { sum += cell.x + 3 * cell.y + static_cast<int>(found.state); });
        return sum;
      },
      [](const CLearnedMap& map) { return static_cast<double>(map.getAsSimplePointsMap()->size()); },
      [](const CLearnedMap& map) { return double{map.boundingBox().max.x}; },
      [robot](const CLearnedMap& map)
      {
        return double{map.squareDistanceToClosestCorrespondence(static_cast<float>(robot.x),
                                                                static_cast<float>(robot.y))};
      }};
}

TYPED_TEST(MapLaws, AMapMayBeAskedByManyThreadsRightAfterAnInsertion)
{
  constexpr size_t kThreads = 8;
  Random random(4);
  const std::vector<TakenScan> scans = randomScans(random, 3, 100);
  for (const Settings& settings : settingsThatDefer<TypeParam>())
  {
    SCOPED_TRACE(nameOf(settings));
    TypeParam map = made<TypeParam>(settings);
    for (const TakenScan& scan : scans)
    {
      map.insertObservation(*scan.observation, scan.robotPose_map);
      const auto questions = questionsAfter(scan);
      const TypeParam reference(map);
      std::vector<double> expected;
      for (const auto& ask : questions) expected.push_back(ask(reference));
      ASSERT_FALSE(reference.isEmpty());
      std::atomic<size_t> ready{0};
      std::atomic<size_t> wrong{0};
      std::vector<std::thread> threads;
      for (size_t i = 0; i < kThreads; ++i)
        threads.emplace_back(
            [&, i]
            {
              ++ready;
              while (ready < kThreads) std::this_thread::yield();
              // Each begins with another question.
              for (size_t k = 0; k < questions.size(); ++k)
              {
                const size_t which = (i + k) % questions.size();
                if (questions[which](map) != expected[which]) ++wrong;
              }
            });
      for (std::thread& thread : threads) thread.join();
      EXPECT_EQ(wrong, 0U);
    }
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
