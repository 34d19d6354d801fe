// The same bytes for every number of threads when models are moved; continuous queries from several threads.
#include <gtest/gtest.h>
#include <lamap_core/overlapping/map.h>
#include <support/posed_scans.h>
#include <support/seeds.h>

#include <tbb/global_control.h>

#include <thread>

namespace lamap::test
{
namespace
{
/// Lets four threads work at once, however few processors there are.
const tbb::global_control kFourThreads(tbb::global_control::max_allowed_parallelism, 4);

TEST(OverlappingMapProperty, NumberOfThreadsDoesNotMatter)
{
  for (unsigned seed = 1; seed <= seeds(5); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    OverlappingOptions options =
        presetOptions(seed % 3 == 0 ? OverlappingPreset::Thesis : OverlappingPreset::Default);
    options.structure.blockDepth = random.integer(2, 6);
    options.structure.pruning = random.pick<Pruning>({Pruning::None, Pruning::Lossless, Pruning::State});
    options.structure.planar = seed % 5 == 0;
    RoomRecipe recipe;
    // Large enough that a second thread gets its share before the first is done.
    recipe.rays = 1200;
    recipe.halfSize_m = {4, 4, 1.5};
    recipe.rangeMax_m = 5.0;
    options.inference.iterations = 5;
    options.inference.epochs = 1;
    options.structure.components = 40;
    recipe.upright = options.structure.planar;
    const std::vector<Scan> scans = roomScans(random, recipe, 2);
    const auto mapOf = [&](unsigned threads)
    {
      OverlappingHilbertMap map(options.structure);
      for (const Scan& scan : scans) map.insert(scan, options.inference, nullptr, threads);
      Eigen::Isometry3d pose(scans[0].sensorPose_map);
      pose.translation().x() += 0.3;
      map.setModelPose(0, pose, {}, threads);
      return map;
    };
    const OverlappingHilbertMap reference = mapOf(1);
    for (const unsigned threads : {2u, 4u, 0u}) ASSERT_TRUE(reference == mapOf(threads)) << threads;
  }
}

TEST(OverlappingMap, MayBeAskedFromSeveralThreads)
{
  Random random(1);
  OverlappingHilbertMap map;
  const std::vector<Scan> scans = roomScans(random, {}, 2);
  for (const Scan& scan : scans) map.insert(scan, {});
  const Eigen::Vector3d point = scans[0].inMap(endsOf(scans[0].fans.front()).front());
  const double expected = OverlappingHilbertMap(map).continuousAt(point, {})->prob;
  std::vector<std::thread> threads;
  std::vector<double> answers(4);
  for (size_t i = 0; i < answers.size(); ++i)
    threads.emplace_back([&, i] { answers[i] = map.continuousAt(point, {})->prob; });
  for (std::thread& thread : threads) thread.join();
  for (const double answer : answers) EXPECT_EQ(answer, expected);
}

}  // namespace
}  // namespace lamap::test
