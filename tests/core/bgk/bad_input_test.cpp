// Invariant 8: NaN, infinite and zero-length rays are counted and left out; P stays in [0, 1].
#include <gtest/gtest.h>
#include <lamap_core/bgk/map.h>
#include <support/grid_words.h>
#include <support/random_options.h>
#include <support/seeded_scans.h>
#include <support/seeds.h>

#include <limits>

namespace lamap::test
{
namespace
{
const double kNan = std::numeric_limits<double>::quiet_NaN();
const double kInf = std::numeric_limits<double>::infinity();
const double kDenormal = std::numeric_limits<double>::denorm_min();
const double kHuge = std::numeric_limits<double>::max();

void expectProbabilities(const BgkMap& map)
{
  map.visitCells({},
                 [](const CellIndex&, const CellEstimate& estimate)
                 {
                   ASSERT_GE(estimate.prob, 0.0);
                   ASSERT_LE(estimate.prob, 1.0);
                   ASSERT_GE(*estimate.variance, 0.0);
                   ASSERT_LE(*estimate.variance, 0.25);
                   ASSERT_TRUE(std::isfinite(estimate.evidence[0]) && std::isfinite(estimate.evidence[1]));
                 });
}

TEST(BgkMapProperty, UnusableRaysChangeNothing)
{
  for (unsigned seed = 1; seed <= seeds(20); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    BgkStructure structure;
    structure.planar = random.chance(0.3);
    BgkInference inference = randomInference(random, structure.resolution);
    inference.rayDecimation = 1;
    ScanRecipe recipe;
    recipe.unusable = false;
    const Scan good = randomScan(random, recipe);
    Scan spoilt = good;
    size_t added = 0;
    for (RayFan& fan : spoilt.fans)
    {
      for (const Eigen::Vector3d& bad :
           {Eigen::Vector3d(kNan, 0, 0), Eigen::Vector3d(0, kInf, 0), Eigen::Vector3d(0, 0, -kInf),
            Eigen::Vector3d(kNan, kNan, kInf), fan.centre})
      {
        const auto at = static_cast<long>(random.integer(0, static_cast<int>(fan.rays.size())));
        fan.rays.insert(fan.rays.begin() + at, Ray{bad});
        ++added;
      }
      for (const Eigen::Vector3d& bad :
           {Eigen::Vector3d(kNan, 1, 0), Eigen::Vector3d(1, kInf, 0), Eigen::Vector3d(0, 0, 0)})
      {
        fan.add(RayEnd::NoReturn, bad);
        ++added;
      }
    }
    spoilt.fans.push_back(fanOf({kNan, 0, 0}, {{1, 1, 1}}, {{1, 0, 0}}));
    spoilt.fans.push_back(fanOf({0, kInf, 0}, {{1, 1, 1}}, {{1, 0, 0}}));
    spoilt.fans.push_back(fanOf({0, 0, 0}, {}));
    added += 4;
    BgkMap a(structure), b(structure);
    const RayCounts goodCounts = a.insert(good, inference, 1), spoiltCounts = b.insert(spoilt, inference, 1);
    EXPECT_EQ(differenceOf(a.evidence(), b.evidence()), "");
    EXPECT_EQ(spoiltCounts.hits, goodCounts.hits);
    EXPECT_EQ(spoiltCounts.freeOnly, goodCounts.freeOnly);
    EXPECT_EQ(spoiltCounts.leftOut(), goodCounts.leftOut() + added);
    EXPECT_GE(spoiltCounts.notFinite, goodCounts.notFinite + 4 * good.fans.size() + 2);
    expectProbabilities(b);
  }
}

TEST(BgkMap, StaysEmptyWithoutOneUsableRay)
{
  for (const FreeSpace freeSpace : kAllFreeSpaces)
    for (const TrainingPoints trainingPoints : kAllTrainingPoints)
    {
      BgkInference inference;
      inference.freeSpace = freeSpace;
      inference.trainingPoints = trainingPoints;
      BgkMap map;
      EXPECT_EQ(map.insert({}, inference).used(), 0u);
      EXPECT_EQ(map.insert(scanWith({{}}), inference).used(), 0u);
      EXPECT_EQ(
          map.insert(scanWith({fanOf({1, 1, 1}, {{1, 1, 1}, {kNan, 1, 1}}, {{1, 0, 0}})}), inference).used(),
          0u);
      EXPECT_TRUE(map.empty());
      EXPECT_EQ(map.evidence().blockCount(), 0u);
    }
}

TEST(BgkMapProperty, CoordinatesOfEverySizeReachNoCellAsNonsense)
{
  const std::vector<double> coordinates{0.0,   -0.0,   kDenormal, -kDenormal, 1e-300, 1e-160, 1e-12, 0.3,
                                        -0.7,  1.0,    1e3,       2.2e8,      1e9,    1e12,   1e13,  1e19,
                                        1e160, -1e200, kHuge,     -kHuge,     kInf,   kNan};
  for (const bool planar : {false, true})
    for (const FreeSpace freeSpace : kAllFreeSpaces)
      for (const TrainingPoints trainingPoints : kAllTrainingPoints)
        for (unsigned seed = 1; seed <= seeds(20); ++seed)
        {
          Random random(seed);
          BgkStructure structure;
          structure.planar = planar;
          BgkInference inference;
          inference.freeSpace = freeSpace;
          inference.trainingPoints = trainingPoints;
          inference.maxRange = 2.0;
          inference.beamWidth = BeamWidth::None;
          inference.freeMargin = random.pick<double>({0.0, 0.1});
          SCOPED_TRACE("seed " + std::to_string(seed) + ": " + nameOf(inference));
          RayFan fan;
          if (random.chance(0.5)) fan.centre = {random.pick(coordinates), random.pick(coordinates), 0.0};
          for (int i = 0; i < 40; ++i)
          {
            fan.addReturn({random.pick(coordinates), random.pick(coordinates), random.pick(coordinates)});
            fan.add(RayEnd::NoReturn,
                    {random.pick(coordinates), random.pick(coordinates), random.pick(coordinates)});
          }
          BgkMap map(structure);
          const RayCounts counts = map.insert(scanWith({fan}), inference, 1);
          EXPECT_EQ(counts.used() + counts.leftOut(), 80u);
          expectProbabilities(map);
          // Nothing is farther from the origin than the range and the support.
          for (const CellEvidence& cell : cellsOf(map.evidence()))
          {
            Eigen::Vector3d offset = cellCentre(cell.cell, structure.resolution) - fan.centre;
            if (planar) offset.z() = 0;
            ASSERT_LE(offset.norm(), 2.0 + 0.2 + 0.18 + 1e-6);
          }
        }
}

TEST(BgkMap, LeavesOutWhatNoCellIndexReaches)
{
  BgkInference inference;
  inference.freeSpace = FreeSpace::None;
  for (const TrainingPoints trainingPoints : kAllTrainingPoints)
  {
    inference.trainingPoints = trainingPoints;
    BgkMap map;
    RayCounts counts = map.insert(
        scanWith({fanOf({0, 0, 0}, {{3e8, 0, 0}, {0, -1e15, 0}, {0, 0, 1e200}, {1, 0, 0}})}), inference);
    EXPECT_EQ(counts.tooLong, 1u);
    EXPECT_EQ(counts.outside, 2u);
    EXPECT_EQ(counts.hits, 1u);
    counts = map.insert(scanWith({fanOf({3e8, 0, 0}, {{3e8, 1, 0}})}), inference);
    EXPECT_EQ(counts.outside, 1u);
    for (const CellEvidence& cell : cellsOf(map.evidence()))
    {
      EXPECT_LE(std::abs(cell.cell.x - 10), 2);
      EXPECT_LE(std::abs(cell.cell.y), 2);
    }
  }
}

TEST(BgkMap, TakesRaysShorterThanACell)
{
  for (const FreeSpace freeSpace : kAllFreeSpaces)
    for (const TrainingPoints trainingPoints : kAllTrainingPoints)
      for (const double length : {1e-3, 1e-9, 1e-15})
      {
        BgkInference inference;
        inference.freeSpace = freeSpace;
        inference.trainingPoints = trainingPoints;
        BgkMap map;
        const RayCounts counts =
            map.insert(scanWith({fanOf({0.04, 0.04, 0.04}, {{0.04 + length, 0.04, 0.04}})}), inference);
        EXPECT_EQ(counts.hits, 1u);
        EXPECT_GT(map.cell({0, 0, 0}, {})->prob, 0.9);
        EXPECT_EQ(map.evidence().at({0, 0, 0}).second, 0u);  // all within the margin
        expectProbabilities(map);
      }
}

// A mean of ends that falls on the origin gives a ray without direction.
TEST(BgkMap, TakesEndsWhoseMeanIsTheOrigin)
{
  for (const FreeSpace freeSpace : kAllFreeSpaces)
    for (const TrainingPoints trainingPoints : kAllTrainingPoints)
      for (const double margin : {0.0, 0.1})
      {
        BgkInference inference;
        inference.freeSpace = freeSpace;
        inference.trainingPoints = trainingPoints;
        inference.freeMargin = margin;
        inference.maxRange = 0.03125;
        BgkMap map;
        const RayCounts counts = map.insert(
            scanWith({fanOf({0.0625, 0.0625, 0.0625}, {{0.03125, 0.0625, 0.0625}, {0.09375, 0.0625, 0.0625}},
                            {{0, 1, 0}, {0, -1, 0}})}),
            inference);
        EXPECT_EQ(counts.hits, 2u);
        EXPECT_EQ(counts.freeOnly, freeSpace == FreeSpace::None ? 0u : 2u);
        EXPECT_TRUE(map.cell({0, 0, 0}, {}).has_value());
        expectProbabilities(map);
      }
}
}  // namespace
}  // namespace lamap::test
