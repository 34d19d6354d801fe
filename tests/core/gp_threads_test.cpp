// Invariant 2: the same bytes for every number of threads; and what may be called from several threads at
// once.
#include <gtest/gtest.h>
#include <lamap_core/gp/map.h>
#include <support/grid_words.h>
#include <support/random_gp_options.h>
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

Scan denseScan(Random& random)
{
  ScanRecipe recipe;
  recipe.halfEdge_m = 1.8;
  recipe.rays = 200;
  recipe.centre_map = random.inCube(1);
  return randomScan(random, recipe);
}

TEST(GpMapProperty, NumberOfThreadsDoesNotMatter)
{
  for (unsigned seed = 1; seed <= 12; ++seed)
  {
    Random random(seed);
    GpStructure structure = randomGpStructure(random);
    structure.pruning = random.pick<Pruning>({Pruning::None, Pruning::Lossless, Pruning::State});
    structure.fusion = random.chance(0.3) ? GpFusion::Bayes : GpFusion::Bcm;
    GpInference inference = randomGpInference(random, structure.resolution);
    inference.maxPoints = 60;
    SCOPED_TRACE("seed " + std::to_string(seed) + ": " + nameOf(structure, inference));
    std::vector<Scan> scans;
    for (int i = 0; i < 2; ++i) scans.push_back(denseScan(random));
    const auto mapOf = [&](unsigned threads)
    {
      GpMap map(structure);
      for (const Scan& scan : scans) map.insert(scan, inference, threads);
      return map;
    };
    const GpMap reference = mapOf(1);
    ASSERT_FALSE(reference.empty());
    for (const unsigned threads : {2u, 4u, 0u})
      ASSERT_EQ(differenceOf(reference.grid(), mapOf(threads).grid()), "") << threads << " threads";
  }
}

TEST(GpMap, MayBeReadFromSeveralThreads)
{
  Random random(1);
  GpMap map;
  map.insert(denseScan(random), {}, 2);
  const std::vector<CellEvidence> cells = cellsOf(map.grid());
  ASSERT_FALSE(cells.empty());
  std::atomic<size_t> wrong{0};
  std::vector<std::thread> readers;
  for (int i = 0; i < 4; ++i)
    readers.emplace_back(
        [&]
        {
          const GpMap copy = map;
          if (!differenceOf(copy.grid(), map.grid()).empty()) ++wrong;
          for (const CellEvidence& cell : cells)
            if (!map.cell(cell.cell, {}) || !map.at(cellCentre(cell.cell, 0.1), {})) ++wrong;
        });
  for (std::thread& reader : readers) reader.join();
  EXPECT_EQ(wrong, 0u);
}

}  // namespace
}  // namespace lamap::test
