// Invariant 8, and data that matrices do not like: every map is finite, P stays in [0, 1].
#include <gtest/gtest.h>
#include <lamap_core/gp/map.h>
#include <support/grid_words.h>
#include <support/random_gp_options.h>
#include <support/seeded_scans.h>
#include <support/seeds.h>

#include <cmath>
#include <functional>
#include <limits>

namespace lamap::test
{
namespace
{
const double kNan = std::numeric_limits<double>::quiet_NaN();
const double kInf = std::numeric_limits<double>::infinity();

/// @return how many cells there are
size_t expectFinite(const GpMap& map, const GpInference& inference)
{
  size_t cells = 0;
  map.visitCells(inference.thresholds,
                 [&](const CellIndex&, const CellEstimate& estimate)
                 {
                   ++cells;
                   ASSERT_TRUE(estimate.prob >= 0 && estimate.prob <= 1) << estimate.prob;
                   ASSERT_TRUE(std::isfinite(estimate.evidence[0]) && std::isfinite(estimate.evidence[1]));
                   if (map.structure().fusion == GpFusion::Bayes) return;
                   ASSERT_GT(*estimate.variance, 0.0);
                   ASSERT_LE(*estimate.variance, map.structure().signalVariance);
                 });
  return cells;
}

Scan scanOf(const std::vector<Eigen::Vector3d>& ends)
{
  return scanWith({fanOf({0.05, 0.05, 0.05}, ends)});
}

TEST(GpMapProperty, UnusableRaysChangeNothing)
{
  for (unsigned seed = 1; seed <= seeds(20); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    const GpStructure structure = randomGpStructure(random);
    GpInference inference = randomGpInference(random, structure.resolution);
    inference.rayDecimation = 1;
    ScanRecipe recipe;
    recipe.unusable = false;
    const Scan good = randomScan(random, recipe);
    Scan spoilt = good;
    size_t added = 0;
    for (RayFan& fan : spoilt.fans)
    {
      for (const Eigen::Vector3d& bad : {Eigen::Vector3d(kNan, 0, 0), Eigen::Vector3d(0, kInf, 0),
                                         Eigen::Vector3d(kNan, kNan, -kInf), fan.centre})
      {
        fan.rays.insert(fan.rays.begin(), Ray{bad});
        ++added;
      }
      for (const Eigen::Vector3d& bad : {Eigen::Vector3d(kNan, 1, 0), Eigen::Vector3d(0, 0, 0)})
      {
        fan.add(RayEnd::NoReturn, bad);
        ++added;
      }
    }
    GpMap expected(structure), map(structure);
    const RayCounts before = expected.insert(good, inference, 1);
    const RayCounts after = map.insert(spoilt, inference, 1);
    EXPECT_EQ(differenceOf(expected.evidence(), map.evidence()), "");
    EXPECT_EQ(after.leftOut(), before.leftOut() + added);
    expectFinite(map, inference);
  }
}

TEST(GpMap, ScansThatMatricesDoNotLikeGiveFiniteMaps)
{
  const Eigen::Vector3d here(0.82, 0.31, 0.07);
  std::vector<std::pair<std::string, Scan>> scans;
  scans.emplace_back("a single point", scanOf({here}));
  scans.emplace_back("coincident points", scanOf(std::vector<Eigen::Vector3d>(700, here)));
  std::vector<Eigen::Vector3d> line;
  for (int i = 0; i < 300; ++i) line.push_back(here + Eigen::Vector3d(1e-12 * i, 0, 0));
  scans.emplace_back("points on a line too short to tell them apart", scanOf(line));
  Scan contradictory = scanOf({here});
  contradictory.fans.push_back(contradictory.fans[0]);
  contradictory.fans[1].rays = {Ray{here + 3 * (here - contradictory.fans[0].centre)}};
  scans.emplace_back("contradictory labels", contradictory);
  for (const auto& [name, scan] : scans)
    for (const bool nested : {false, true})
      for (const TrainingPoints points : {TrainingPoints::Cells, TrainingPoints::Centroids})
        for (const GpFreeSpace freeSpace : {GpFreeSpace::Samples, GpFreeSpace::None})
          for (const double noise : {1e-6, 0.01, 100.0})
          {
            SCOPED_TRACE(name + (nested ? ", nested, " : ", ") + std::to_string(noise));
            GpInference inference;
            inference.nested = nested;
            inference.trainingPoints = points;
            inference.freeSpace = freeSpace;
            inference.hitDownsampling = 0.0;
            inference.freeResolution = 0.05;
            inference.protectHits = 0;
            for (const GpFusion fusion : {GpFusion::Bcm, GpFusion::Bayes})
            {
              GpStructure structure;
              structure.fusion = fusion;
              structure.noiseVariance = noise;
              GpMap map(structure);
              map.insert(scan, inference, 1);
              EXPECT_GT(expectFinite(map, inference), 0u);
            }
          }
}

TEST(GpMap, OneClassOnlyIsNeverTurnedIntoTheOther)
{
  GpInference inference;
  inference.freeSpace = GpFreeSpace::None;
  GpMap hits;
  hits.insert(scanOf({{0.82, 0.31, 0.07}, {0.75, 0.42, 0.11}}), inference, 1);
  hits.visitCells(inference.thresholds,
                  [](const CellIndex&, const CellEstimate& cell) { EXPECT_GT(cell.prob, 0.5); });
  EXPECT_EQ(hits.at({0.82, 0.31, 0.07}, inference.thresholds)->state, CellState::Occupied);

  const Scan scan = scanWith({fanOf({0.05, 0.05, 0.05}, {}, {{1, 0, 0}, {0, 1, 0.2}}, 0, 1.5)});
  GpMap frees;
  frees.insert(scan, {}, 1);
  EXPECT_GT(expectFinite(frees, {}), 0u);
  frees.visitCells({}, [](const CellIndex&, const CellEstimate& cell) { EXPECT_LT(cell.prob, 0.5); });
}

TEST(GpMap, AScanWithoutAUsableRayChangesNothing)
{
  GpMap map;
  EXPECT_EQ(map.insert({}, {}).used(), 0u);
  EXPECT_EQ(map.insert(scanOf({}), {}).used(), 0u);
  EXPECT_EQ(map.insert(scanOf({{kNan, 0, 0}}), {}).used(), 0u);
  EXPECT_TRUE(map.empty());
}

TEST(GpMap, SumsThatWouldOverflowAreRefused)
{
  GpInference inference;
  GpStructure structure;
  structure.noiseVariance = 1e-6;
  GpMap map(structure);
  map.addObservation({0, 0, 0}, true, {});
  const auto doubleIt = [&]
  {
    const GpMap same = map;
    map.merge(same, {});
  };
  for (int i = 0; i < 20; ++i) doubleIt();
  EXPECT_THROW(for (int i = 0; i < 10; ++i) doubleIt(), std::overflow_error);
  expectFinite(map, inference);
}

TEST(GpOptions, IllegalOnesAreNamed)
{
  const auto expectRefusal = [](const std::string& name, const std::function<void(GpInference&)>& change)
  {
    GpInference inference;
    change(inference);
    try
    {
      inference.validate(0.1);
      ADD_FAILURE() << name << " was taken";
    }
    catch (const std::invalid_argument& error)
    {
      EXPECT_EQ(std::string(error.what()).rfind(name + " = ", 0), 0u) << error.what();
    }
  };
  expectRefusal("kernelSupport", [](GpInference& i) { i.kernelSupport = 0; });
  expectRefusal("kernelSupport", [](GpInference& i) { i.kernelSupport = 1e-200; });
  expectRefusal("kernelSupport", [](GpInference& i) { i.kernelSupport = 7.0; });
  expectRefusal("lengthScale", [](GpInference& i) { i.lengthScale = kNan; });
  expectRefusal("maxPoints", [](GpInference& i) { i.maxPoints = 0; });
  expectRefusal("maxPoints", [](GpInference& i) { i.maxPoints = 5000; });
  expectRefusal("freeResolution", [](GpInference& i) { i.freeResolution = 0; });
  expectRefusal("maxRange", [](GpInference& i) { i.minRange = i.maxRange = 1; });
  expectRefusal("occupiedThreshold", [](GpInference& i) { i.thresholds.occupied = 0.2; });
  for (const auto& change :
       {+[](GpStructure& s) { s.signalVariance = 0; }, +[](GpStructure& s) { s.noiseVariance = 0; },
        +[](GpStructure& s) { s.squashGain = -1; }, +[](GpStructure& s) { s.minVariance = 0; },
        +[](GpStructure& s) { s.blockDepth = 7; }})
  {
    GpStructure structure;
    change(structure);
    EXPECT_THROW(GpMap{structure}, std::invalid_argument);
  }
}

TEST(GpOptions, PresetsAreLegal)
{
  for (const GpPreset preset : {GpPreset::Default, GpPreset::Thesis, GpPreset::La3dm})
  {
    const GpOptions options = presetOptions(preset);
    EXPECT_NO_THROW(options.structure.validate());
    EXPECT_NO_THROW(options.inference.validate(options.structure.resolution));
  }
}

}  // namespace
}  // namespace lamap::test
