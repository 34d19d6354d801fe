// Invariant 2: the same bytes for every number of threads; and what may be called from several threads at
// once.
#include <gtest/gtest.h>
#include <lamap_core/bgk/map.h>
#include <support/grid_words.h>
#include <support/random_options.h>
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

Scan denseScan(Random& random, const Eigen::Vector3d& centre)
{
  ScanRecipe recipe;
  recipe.halfEdge_m = 2.5;
  recipe.rays = 400;
  recipe.centre_map = centre;
  return randomScan(random, recipe);
}

TEST(BgkMapProperty, NumberOfThreadsDoesNotMatter)
{
  for (unsigned seed = 1; seed <= 20; ++seed)
  {
    Random random(seed);
    BgkStructure structure;
    structure.blockDepth = random.integer(2, 6);
    structure.planar = random.chance(0.2);
    structure.pruning = random.pick<Pruning>({Pruning::None, Pruning::Lossless, Pruning::State});
    BgkInference inference = randomInference(random, structure.resolution);
    inference.maxRange = random.pick<double>({0.0, 2.0});
    SCOPED_TRACE("seed " + std::to_string(seed) + ": " + nameOf(inference));
    std::vector<Scan> scans;
    for (int i = 0; i < 3; ++i) scans.push_back(denseScan(random, random.inCube(1)));
    const auto mapOf = [&](unsigned threads)
    {
      BgkMap map(structure);
      for (const Scan& scan : scans) map.insert(scan, inference, threads);
      return map;
    };
    const BgkMap reference = mapOf(1);
    ASSERT_FALSE(reference.empty());
    for (const unsigned threads : {2u, 3u, 4u, 0u})
      ASSERT_EQ(differenceOf(reference.grid(), mapOf(threads).grid()), "") << threads << " threads";
  }
}

TEST(BgkMapProperty, ChangingTheNumberOfThreadsBetweenScansDoesNotMatter)
{
  for (unsigned seed = 1; seed <= 5; ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    const BgkInference inference = randomInference(random, 0.1);
    BgkMap steady, changing;
    for (unsigned i = 0; i < 6; ++i)
    {
      const Scan scan = denseScan(random, random.inCube(1));
      steady.insert(scan, inference, 1);
      changing.insert(scan, inference, 1 + (i * 3) % 4);
      ASSERT_EQ(differenceOf(steady.grid(), changing.grid()), "");
    }
  }
}

TEST(BgkMap, MayBeReadFromSeveralThreads)
{
  Random random(1);
  BgkMap map;
  map.insert(denseScan(random, {0, 0, 0}), {}, 2);
  const std::vector<CellEvidence> cells = cellsOf(map.grid());
  ASSERT_FALSE(cells.empty());
  std::atomic<size_t> wrong{0};
  std::vector<std::thread> readers;
  for (int i = 0; i < 4; ++i)
    readers.emplace_back(
        [&]
        {
          const BgkMap copy = map;
          if (!differenceOf(copy.grid(), map.grid()).empty()) ++wrong;
          for (const CellEvidence& cell : cells)
          {
            if (!map.cell(cell.cell, {})) ++wrong;
            if (!map.at(cellCentre(cell.cell, 0.1), {})) ++wrong;
          }
          size_t visited = 0;
          map.visitCells({}, [&](const CellIndex&, const CellEstimate&) { ++visited; });
          if (visited != cells.size()) ++wrong;
        });
  for (std::thread& reader : readers) reader.join();
  EXPECT_EQ(wrong, 0u);
}

TEST(BgkMap, DifferentMapsMayBeFilledFromSeveralThreads)
{
  std::vector<BgkMap> maps(4);
  std::vector<std::thread> writers;
  for (BgkMap& map : maps)
    writers.emplace_back(
        [&map]
        {
          Random random(9);
          for (int i = 0; i < 3; ++i) map.insert(denseScan(random, random.inCube(1)), {}, 2);
        });
  for (std::thread& writer : writers) writer.join();
  for (const BgkMap& map : maps) EXPECT_EQ(differenceOf(maps[0].grid(), map.grid()), "");
}
}  // namespace
}  // namespace lamap::test
