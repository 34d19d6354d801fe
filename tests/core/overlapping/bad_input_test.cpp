// Scans of which little or nothing can be learned, and options that cannot be.
#include <gtest/gtest.h>
#include <lamap_core/overlapping/map.h>
#include <support/posed_scans.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>

namespace lamap::test
{
namespace
{
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

std::vector<OverlappingOptions> allKinds()
{
  std::vector<OverlappingOptions> kinds;
  for (const OverlappingPreset preset : {OverlappingPreset::Default, OverlappingPreset::Thesis})
    for (const HilbertSolver solver : {HilbertSolver::Lbfgs, HilbertSolver::SgdL1, HilbertSolver::SgdL2})
      for (const bool planar : {false, true})
      {
        OverlappingOptions options = presetOptions(preset);
        options.structure.planar = planar;
        options.inference.solver = solver;
        kinds.push_back(options);
      }
  return kinds;
}

void expectFinite(const OverlappingHilbertMap& map)
{
  map.visitCells({},
                 [](const CellIndex&, const CellEstimate& cell)
                 {
                   ASSERT_TRUE(std::isfinite(cell.evidence[0]));
                   ASSERT_GE(cell.prob, 0.0);
                   ASSERT_LE(cell.prob, 1.0);
                 });
}

Scan scanOf(const std::vector<Eigen::Vector3d>& returns,
            const Eigen::Vector3d& origin = Eigen::Vector3d(0.05, 0.05, 0.05))
{
  return scanWith({fanOf(origin, returns)});
}

TEST(OverlappingMapBadInput, UnusableRaysAreCountedAndLeaveNothing)
{
  OverlappingHilbertMap map;
  Scan scan = scanOf({{kNan, 0, 0}, {0, kInf, 0}, {0.05, 0.05, 0.05}});
  for (const Eigen::Vector3d& direction : {Eigen::Vector3d(1, 0, 0), {0, 0, 0}, {kNan, 0, 0}})
    scan.fans.front().add(RayEnd::NoReturn, direction);
  const RayCounts counts = map.insert(scan, {});
  EXPECT_EQ(counts.used(), 0u);
  EXPECT_EQ(counts.notFinite, 3u);
  EXPECT_EQ(counts.tooNear, 2u);
  EXPECT_EQ(counts.unbounded, 1u);
  EXPECT_TRUE(map.empty());
  EXPECT_EQ(map.insert({}, {}).used(), 0u);
  EXPECT_EQ(map.insert(scanOf({{1, 1, 1}}, {kNan, 0, 0}), {}).notFinite, 1u);
  EXPECT_EQ(map.insert(scanOf({{1e11, 1, 1}}, {1e11, 0, 0}), {}).outside, 1u);
  EXPECT_EQ(map.insert(scanOf({{1, 1, 1}}, {1e11, 0, 0}), {}).tooLong, 1u);
  EXPECT_EQ(map.insert(scanOf({{1e6, 1, 1}}), {}).tooLong, 1u);
  EXPECT_TRUE(map.empty());
}

TEST(OverlappingMapBadInput, PoorScansGiveFiniteMaps)
{
  Random random(2);
  std::vector<Eigen::Vector3d> coinciding(50, Eigen::Vector3d(1.03, 0.52, 0.23));
  std::vector<Scan> poor{
      scanOf({{1.03, 0.52, 0.23}}),                      // one point
      scanOf(coinciding),                                // all points in one place
      scanOf({{0.06, 0.05, 0.05}, {0.05, 0.06, 0.05}}),  // hits only: no free sample fits before them
      scanOf({{900, 0.5, 0.2}, {1, 900, 0.3}}),          // two points far from each other
  };
  poor.push_back(scanWith({fanOf({0, 0, 0}, {}, {{1, 0, 0}, {0, 1, 0.5}}, 0, 1.5)}));
  for (OverlappingOptions options : allKinds())
  {
    options.inference.trainingPoints = HilbertPoints::Points;
    for (size_t i = 0; i < poor.size(); ++i)
    {
      SCOPED_TRACE(i);
      // The whole kernel's box around two points a kilometre apart would be too many cells.
      if (i == 3 && options.structure.features == HilbertFeatures::Nystroem) continue;
      OverlappingHilbertMap map(options.structure);
      const RayCounts counts = map.insert(poor[i], options.inference);
      EXPECT_GT(counts.used(), 0u);
      EXPECT_EQ(map.modelCount(), 1u);
      EXPECT_GT(map.evidence().blockCount(), 0u);
      expectFinite(map);
      if (i < 2 && options.structure.outOfFieldLimit > 0)
      {
        EXPECT_TRUE(map.at({1.03, 0.52, 0.23}, {}));
      }
    }
  }
}

TEST(OverlappingMapBadInput, ScansWithoutFreeSpaceOrWithContradictionsAreFinite)
{
  Random random(3);
  for (OverlappingOptions options : allKinds())
  {
    RoomRecipe recipe;
    recipe.upright = options.structure.planar;
    recipe.rays = 40;
    const Scan scan = roomScan(random, recipe);
    OverlappingHilbertMap map(options.structure);
    OverlappingInference noFree = options.inference;
    noFree.freeWeight = 0;
    noFree.considerInvalidRangesAsFreeSpace = false;
    map.insert(scan, noFree);
    // Another sensor looks through what the first one saw, with both labels at one place.
    RayFan through = scan.fans.front();
    for (Ray& ray : through.rays)
      if (ray.meaning == RayEnd::Return) ray.end += 0.5 * (ray.end - through.centre);
    Scan both = scan;
    both.fans.push_back(through);
    map.insert(both, options.inference);
    expectFinite(map);
    EXPECT_EQ(map.modelCount(), 2u);
  }
}

TEST(OverlappingMapBadInput, AScanFarFromAllOthersIsByItself)
{
  Random random(4);
  const Scan near = roomScan(random, {});
  Eigen::Isometry3d away = Eigen::Isometry3d::Identity();
  away.translation() = Eigen::Vector3d(-100000.0, 5e5, 300.0);
  const Scan far = moved(near, away);
  OverlappingHilbertMap alone, both;
  alone.insert(near, {});
  both.insert(near, {});
  both.insert(far, {});
  alone.visitCells({}, [&](const CellIndex& cell, const CellEstimate& estimate)
                   { ASSERT_EQ(both.cell(cell, {})->evidence, estimate.evidence); });
  const Eigen::Vector3d hit = far.inMap(endsOf(far.fans.front()).front());
  EXPECT_TRUE(both.continuousAt(hit, {}));
  EXPECT_TRUE(both.at(hit, {}));
}

TEST(OverlappingMapBadInput, AModelOfMoreCellsThanFitIsRefusedAndChangesNothing)
{
  const OverlappingOptions options = presetOptions(OverlappingPreset::Thesis);
  OverlappingHilbertMap map(options.structure);
  map.addEvidence({0, 0, 0}, 1, {});
  const OverlappingHilbertMap before = map;
  EXPECT_THROW(map.insert(scanOf({{2000, 5, 2000}, {-2000, 2000, 0}}), options.inference), std::length_error);
  EXPECT_TRUE(map == before);
}

TEST(OverlappingOptions, IllegalOnesAreNamed)
{
  const auto expectStructure =
      [](const std::string& name, const std::function<void(OverlappingStructure&)>& set)
  {
    OverlappingStructure structure;
    set(structure);
    try
    {
      const OverlappingHilbertMap map(structure);
      ADD_FAILURE() << name << " was taken";
    }
    catch (const std::invalid_argument& refused)
    {
      EXPECT_NE(std::string(refused.what()).find(name), std::string::npos) << refused.what();
    }
  };
  expectStructure("resolution", [](auto& s) { s.resolution = 0; });
  expectStructure("resolution", [](auto& s) { s.resolution = kNan; });
  expectStructure("blockDepth", [](auto& s) { s.blockDepth = 7; });
  expectStructure("planarHeight", [](auto& s) { s.planarHeight = kInf; });
  expectStructure("gamma", [](auto& s) { s.gamma = -1; });
  expectStructure("gamma",
                  [](auto& s)
                  {
                    s.gamma = 0.02;
                    s.latticeSpacing = 4;
                  });
  expectStructure("latticeSpacing", [](auto& s) { s.latticeSpacing = 0; });
  expectStructure("latticeSpacing", [](auto& s) { s.latticeSpacing = 0.01; });
  expectStructure("cutoff", [](auto& s) { s.cutoff = 1; });
  expectStructure("components", [](auto& s) { s.components = 0; });
  expectStructure("priorPrecision", [](auto& s) { s.priorPrecision = 0; });
  expectStructure("outOfFieldLimit", [](auto& s) { s.outOfFieldLimit = -1; });
  expectStructure("fieldLimit", [](auto& s) { s.fieldLimit = -1; });

  const auto expectInference =
      [](const std::string& name, const std::function<void(OverlappingInference&)>& set)
  {
    OverlappingInference inference;
    set(inference);
    OverlappingHilbertMap map;
    try
    {
      map.insert(scanOf({{1, 1, 1}}), inference);
      ADD_FAILURE() << name << " was taken";
    }
    catch (const std::invalid_argument& refused)
    {
      EXPECT_NE(std::string(refused.what()).find(name), std::string::npos) << refused.what();
      EXPECT_TRUE(map.empty());
    }
  };
  expectInference("minRange", [](auto& i) { i.minRange = -1; });
  expectInference("maxRange", [](auto& i) { i.maxRange = kNan; });
  expectInference("rayDecimation", [](auto& i) { i.rayDecimation = 0; });
  expectInference("freeMargin", [](auto& i) { i.freeMargin = -1; });
  expectInference("iterations", [](auto& i) { i.iterations = 0; });
  expectInference("alpha", [](auto& i) { i.alpha = 0; });
  expectInference("epochs", [](auto& i) { i.epochs = 0; });
  expectInference("scansPerModel", [](auto& i) { i.scansPerModel = 0; });
  expectInference("boxQuantile", [](auto& i) { i.boxQuantile = 0.5; });
  expectInference("fieldNear", [](auto& i) { i.fieldNear = kNan; });
  expectInference("fieldDepth", [](auto& i) { i.fieldDepth = -0.1; });
  expectInference("fieldAngle", [](auto& i) { i.fieldAngle = 0.05; });
  expectInference("fieldWeight", [](auto& i) { i.fieldWeight = 0; });
  expectInference("freeThreshold", [](auto& i) { i.thresholds.free = 2; });
  expectInference("varianceThreshold", [](auto& i) { i.thresholds.variance = 0.1; });
}

}  // namespace
}  // namespace lamap::test
