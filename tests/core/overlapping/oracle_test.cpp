// The cells and the continuous map against brute force from the equations.
#include <gtest/gtest.h>
#include <lamap_core/grid/cell_sums.h>
#include <support/overlapping_oracle.h>
#include <support/seeds.h>

#include <algorithm>
#include <cmath>

namespace lamap::test
{
namespace
{
struct Case
{
  OverlappingOptions options;
  RoomRecipe recipe;
  std::vector<Scan> scans;
};

Case randomCase(Random& random)
{
  Case one;
  const bool thesis = random.chance(0.3);
  one.options = presetOptions(thesis ? OverlappingPreset::Thesis : OverlappingPreset::Default);
  OverlappingStructure& structure = one.options.structure;
  OverlappingInference& inference = one.options.inference;
  structure.blockDepth = random.integer(2, 6);
  structure.resolution = random.pick<double>({0.08, 0.1, 0.125});
  structure.pruning = random.pick<Pruning>({Pruning::None, Pruning::Lossless});
  structure.planar = random.chance(0.3);
  structure.planarHeight = random.uniform(-1, 1);
  structure.components = 30;
  structure.outOfFieldLimit = random.pick<double>({0.0, 0.6, 2.0});
  if (!thesis && random.chance(0.4)) structure.latticeSpacing = random.uniform(0.2, 0.35);
  if (!thesis && random.chance(0.4)) structure.gamma = random.uniform(10, 25);
  inference.iterations = 8;
  inference.scansPerModel = static_cast<uint32_t>(random.integer(1, 2));
  inference.boxQuantile = random.pick<double>({0.0, 0.05});
  inference.fieldAngle = random.pick<double>({2.5, 10.0});
  inference.fieldDepth = random.uniform(0.1, 0.4);
  inference.trainingPoints = random.pick<HilbertPoints>({HilbertPoints::Cells, HilbertPoints::Points});
  one.recipe.upright = structure.planar;
  one.recipe.rays = random.integer(5, 100);
  one.recipe.centre_map = random.inCube(3.0);
  one.scans = roomScans(random, one.recipe, 4);
  structure.fieldLimit = random.pick<double>({0.0, 1.5, 6.0});
  return one;
}

OverlappingHilbertMap mapOf(const Case& one)
{
  OverlappingHilbertMap map(one.options.structure);
  for (const Scan& scan : one.scans) map.insert(scan, one.options.inference);
  map.trainPending(one.options.inference);
  return map;
}

OverlappingOracle oracleOf(const Case& one, const OverlappingHilbertMap& map)
{
  OverlappingOracle oracle(one.options.structure, one.options.inference);
  const size_t together = one.options.inference.scansPerModel;
  for (size_t i = 0; i < map.modelCount(); ++i)
    oracle.addModel(*map.models()[i].model, {one.scans.begin() + static_cast<long>(i * together),
                                             one.scans.begin() + static_cast<long>((i + 1) * together)});
  return oracle;
}

/// All cells within a metre of the room.
template <typename Visit>
void forEachCell(const Case& one, const OverlappingHilbertMap& map, Visit&& visit)
{
  const double r = one.options.structure.resolution;
  const Eigen::Vector3d low = one.recipe.centre_map - one.recipe.halfSize_m;
  const Eigen::Vector3d high = one.recipe.centre_map + one.recipe.halfSize_m;
  const auto cell = [&](double coordinate) { return static_cast<int32_t>(std::floor(coordinate / r)); };
  const bool planar = one.options.structure.planar;
  const int margin = 4;
  for (int32_t z = planar ? map.planarLayer() : cell(low.z()) - margin;
       z <= (planar ? map.planarLayer() : cell(high.z()) + margin); ++z)
    for (int32_t y = cell(low.y()) - margin; y <= cell(high.y()) + margin; ++y)
      for (int32_t x = cell(low.x()) - margin; x <= cell(high.x()) + margin; ++x) visit(CellIndex{x, y, z});
}

TEST(OverlappingMapProperty, CellsAreTheSumOverModelsByBruteForce)
{
  for (unsigned seed = 1; seed <= seeds(14); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Case one = randomCase(random);
    const OverlappingHilbertMap map = mapOf(one);
    ASSERT_GT(map.modelCount(), 0u);
    const OverlappingOracle oracle = oracleOf(one, map);
    size_t compared = 0, doubtful = 0, withEvidence = 0, outside = 0;
    forEachCell(one, map,
                [&](const CellIndex& cell)
                {
                  // A quarter of the cells will do.
                  if (one.options.structure.planar ? false : (cell.x + cell.y + cell.z) % 4 != 0) return;
                  const auto answer = oracle.at(cellCentre(cell, one.options.structure.resolution));
                  ++compared;
                  if (answer.doubtful)
                  {
                    ++doubtful;
                    return;
                  }
                  const auto held = map.cell(cell, {});
                  ASSERT_EQ(held.has_value(), answer.any()) << cell.x << " " << cell.y << " " << cell.z;
                  if (!held) return;
                  ++withEvidence;
                  outside += answer.inField ? 0 : 1;
                  ASSERT_EQ(held->evidence[1], answer.inField ? 1.0 : 0.0);
                  ASSERT_NEAR(held->evidence[0], answer.logodds, 2e-4 + 2e-6 * std::abs(answer.logodds));
                  const double limit = one.options.structure.fieldLimit;
                  const double logodds =
                      answer.inField && limit > 0
                          ? answer.logodds / std::pow(1 + std::pow(answer.logodds / limit, 4), 0.25)
                          : answer.logodds;
                  ASSERT_NEAR(held->prob, 1 / (1 + std::exp(-logodds)), 1e-4);
                });
    if (HasFatalFailure()) return;
    EXPECT_LT(static_cast<double>(doubtful), 0.1 * static_cast<double>(compared) + 20);
    EXPECT_GT(withEvidence, 50u);
    if (one.options.structure.outOfFieldLimit > 0 && !one.options.structure.planar)
    {
      EXPECT_GT(outside, 10u);
    }
  }
}

TEST(OverlappingMapProperty, ContinuousAndCellsAgreeAtTheCentres)
{
  for (unsigned seed = 101; seed < 101 + seeds(8); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Case one = randomCase(random);
    OverlappingHilbertMap map = mapOf(one);
    const CellIndex told = *cellAt(one.recipe.centre_map, one.options.structure.resolution);
    map.addEvidence(told, 1.25, {});
    size_t both = 0, oneOnly = 0;
    forEachCell(one, map,
                [&](const CellIndex& cell)
                {
                  if (cell.x % 2 != 0 && !(cell == told)) return;
                  const auto held = map.cell(cell, {});
                  const auto asked = map.continuousAt(cellCentre(cell, one.options.structure.resolution), {});
                  if (held.has_value() != asked.has_value())
                  {
                    ++oneOnly;  // a kernel's end within rounding of the centre
                    return;
                  }
                  if (!held) return;
                  ++both;
                  ASSERT_EQ(held->evidence[1], asked->evidence[1]);
                  ASSERT_NEAR(held->evidence[0], asked->evidence[0], 1e-3);
                });
    if (HasFatalFailure()) return;
    EXPECT_GT(both, 50u);
    EXPECT_LE(oneOnly, 2u);
  }
}

TEST(OverlappingMapProperty, ContinuousIsTheSumOverModelsBetweenTheCentresToo)
{
  for (unsigned seed = 201; seed < 201 + seeds(6); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Case one = randomCase(random);
    const OverlappingHilbertMap map = mapOf(one);
    const OverlappingOracle oracle = oracleOf(one, map);
    for (int i = 0; i < 300; ++i)
    {
      const Eigen::Vector3d point = one.recipe.centre_map + random.inCube(2.0);
      const auto answer = oracle.at(point);
      if (answer.doubtful) continue;
      const auto asked = map.continuousAt(point, {});
      ASSERT_EQ(asked.has_value(), answer.any()) << point.transpose();
      if (!asked) continue;
      ASSERT_NEAR(asked->evidence[0], answer.logodds, 1e-4 + 1e-6 * std::abs(answer.logodds));
    }
  }
}

TEST(OverlappingMapProperty, AnotherResolutionIsTheContinuousMapAtItsCentres)
{
  Random random(7);
  RoomRecipe recipe;
  OverlappingOptions options;
  options.inference.trainingPoints = HilbertPoints::Points;  // hits of whole cells depend on the cells
  OverlappingHilbertMap map(options.structure);
  for (const Scan& scan : roomScans(random, recipe, 3)) map.insert(scan, options.inference);
  const OverlappingHilbertMap coarse = map.resampled(0.23, {});
  EXPECT_DOUBLE_EQ(coarse.structure().resolution, 0.23);
  size_t cells = 0;
  coarse.visitCells({},
                    [&](const CellIndex& cell, const CellEstimate& estimate)
                    {
                      const auto asked = map.continuousAt(cellCentre(cell, 0.23), {});
                      if (!asked) return;
                      ++cells;
                      EXPECT_NEAR(asked->evidence[0], estimate.evidence[0], 1e-3);
                    });
  EXPECT_GT(cells, 100u);
}

}  // namespace
}  // namespace lamap::test
