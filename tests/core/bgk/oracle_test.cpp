// Invariants 1 and 3: evidence equals the brute-force sum over the training set, and is nowhere else.
#include <gtest/gtest.h>
#include <lamap_core/bgk/map.h>
#include <support/bgk_oracle.h>
#include <support/random_options.h>
#include <support/seeded_scans.h>
#include <support/seeds.h>

#include <algorithm>
#include <string>

namespace lamap::test
{
namespace
{
void expectEqualCounts(const RayCounts& counts, const RayCounts& oracle)
{
  EXPECT_EQ(counts.hits, oracle.hits);
  EXPECT_EQ(counts.freeOnly, oracle.freeOnly);
  EXPECT_EQ(counts.decimated, oracle.decimated);
  EXPECT_EQ(counts.notFinite, oracle.notFinite);
  EXPECT_EQ(counts.tooNear, oracle.tooNear);
  EXPECT_EQ(counts.unbounded, oracle.unbounded);
  EXPECT_EQ(counts.outside, oracle.outside);
}

/// Inserts the scans and compares with the oracle. @return the worst deviation a scan.
double expectAgreement(const BgkStructure& structure, const BgkInference& inference,
                       const std::vector<Scan>& scans)
{
  BgkMap map(structure);
  std::vector<OracleField> fields;
  for (const Scan& scan : scans)
  {
    fields.emplace_back(scan, structure, inference);
    expectEqualCounts(map.insert(scan, inference, 1), fields.back().counts());
  }
  const Comparison comparison = compare(map, fields);
  EXPECT_EQ(comparison.firstDifference, "");
  // Rounded once, to the nearest unit; below one unit it is one.
  // A 128th of rounded evidence is rounded again.
  EXPECT_LE(comparison.worstRounding, 0.51 * kEvidenceUnit);
  return comparison.worstDeviation / static_cast<double>(scans.size());
}

/// Every kernel, planar or not, every block depth and supports from a fraction of a cell to beyond a block's
/// edge.
void sweep(FreeSpace freeSpace, TrainingPoints trainingPoints)
{
  double worst = 0;
  uint64_t seed = 0;
  for (const KernelShape kernel : kAllKernels)
    for (const bool planar : {false, true})
      for (int blockDepth = 2; blockDepth <= 6; ++blockDepth)
        for (const double support_cells : {0.45, 1.0, 2.0, 3.3, 1.1 * (1 << (blockDepth - 1))})
        {
          if (support_cells > 20 && !planar && kernel != KernelShape::Sparse) continue;
          if (isSkipped(++seed)) continue;
          Random random(seed);
          BgkStructure structure;
          structure.resolution = random.pick<double>({0.1, 0.125, 0.07});
          structure.blockDepth = blockDepth;
          structure.planar = planar;
          structure.planarHeight = random.uniform(-1, 1);
          structure.pruning = random.pick<Pruning>({Pruning::None, Pruning::Lossless});
          BgkInference inference = randomInference(random, structure.resolution);
          inference.freeSpace = freeSpace;
          inference.trainingPoints = trainingPoints;
          inference.kernel = kernel;
          inference.kernelSupport = support_cells * structure.resolution;
          SCOPED_TRACE("seed " + std::to_string(seed) + ": " + nameOf(inference) +
                       (planar ? ", planar" : ", 3D") + ", block depth " + std::to_string(blockDepth) +
                       ", support of " + std::to_string(support_cells) + " cells");
          ScanRecipe recipe;
          recipe.halfEdge_m = 6 * structure.resolution;
          recipe.clusterRadius_m = structure.resolution;
          std::vector<Scan> scans;
          for (int i = support_cells > 10 ? 2 : 0; i < 3; ++i) scans.push_back(randomScan(random, recipe));
          worst = std::max(worst, expectAgreement(structure, inference, scans));
          if (::testing::Test::HasFailure()) return;
        }
  ::testing::Test::RecordProperty("worst_deviation_1e-9", std::to_string(worst * 1e9));
}

// The oracle enumerates cells around each point; here every point meets every cell.
TEST(BgkOracle, MissesNoCellAroundAPoint)
{
  for (unsigned seed = 1; seed <= seeds(5); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    BgkStructure structure;
    BgkInference inference = randomInference(random, structure.resolution);
    inference.freeSpace = seed % 2 ? FreeSpace::Line : FreeSpace::Samples;
    inference.protectHits = 0;
    ScanRecipe recipe;
    recipe.halfEdge_m = 0.4;
    const OracleField field(randomScan(random, recipe), structure, inference);
    const double support = inference.kernelSupport.value_or(0.2);
    for (int64_t x = -20; x < 20; ++x)
      for (int64_t y = -20; y < 20; ++y)
        for (int64_t z = -20; z < 20; ++z)
        {
          const Eigen::Vector3d centre =
              cellCentre({static_cast<int32_t>(x), static_cast<int32_t>(y), static_cast<int32_t>(z)}, 0.1);
          double occupied = 0, free = 0;
          for (const auto& hit : field.training().hits_map)
            occupied += oracleKernel(inference.kernel, (hit - centre).norm(), support, inference.kernelScale);
          for (const auto& point : field.training().frees_map)
            free += inference.freeWeight *
                    oracleKernel(inference.kernel, (point - centre).norm(), support, inference.kernelScale);
          const bool isHit = field.training().rawHits.count(Cell{x, y, z}) > 0;
          for (const auto& line : field.training().lines)
            if (line.hasHit || !isHit)
              free += inference.freeWeight *
                      oracleKernel(inference.kernel, line.distanceTo(centre), support, inference.kernelScale);
          ASSERT_NEAR(field.at({x, y, z}).occupied, occupied, 1e-10);
          ASSERT_NEAR(field.at({x, y, z}).free, free, 1e-10);
        }
  }
}

TEST(BgkMapProperty, EvidenceIsTheBruteForceSumOfSampledCells)
{
  sweep(FreeSpace::Samples, TrainingPoints::Cells);
}
TEST(BgkMapProperty, EvidenceIsTheBruteForceSumOfLinesOfCells)
{
  sweep(FreeSpace::Line, TrainingPoints::Cells);
}
TEST(BgkMapProperty, EvidenceIsTheBruteForceSumOfHitCells)
{
  sweep(FreeSpace::None, TrainingPoints::Cells);
}
TEST(BgkMapProperty, EvidenceIsTheBruteForceSumOfSampledCentroids)
{
  sweep(FreeSpace::Samples, TrainingPoints::Centroids);
}
TEST(BgkMapProperty, EvidenceIsTheBruteForceSumOfLinesOfCentroids)
{
  sweep(FreeSpace::Line, TrainingPoints::Centroids);
}
TEST(BgkMapProperty, EvidenceIsTheBruteForceSumOfHitCentroids)
{
  sweep(FreeSpace::None, TrainingPoints::Centroids);
}

TEST(BgkMapProperty, EvidenceIsTheBruteForceSumForRandomOptions)
{
  for (unsigned seed = 1001; seed < 1001 + seeds(200); ++seed)
  {
    Random random(seed);
    BgkStructure structure;
    structure.resolution = random.uniform(0.03, 0.4);
    structure.blockDepth = random.integer(2, 6);
    structure.planar = random.chance(0.3);
    structure.planarHeight = random.uniform(-1, 1);
    structure.priorAlpha = random.uniform(0.001, 1);
    structure.priorBeta = random.uniform(0.001, 1);
    structure.pruning = random.pick<Pruning>({Pruning::None, Pruning::Lossless});
    const BgkInference inference = randomInference(random, structure.resolution);
    SCOPED_TRACE("seed " + std::to_string(seed) + ": " + nameOf(inference));
    ScanRecipe recipe;
    recipe.halfEdge_m = random.uniform(2, 9) * structure.resolution;
    recipe.clusterRadius_m = random.uniform(0.1, 1) * recipe.halfEdge_m;
    recipe.rays = random.integer(1, 30);
    recipe.fans = 3;
    recipe.centre_map = random.inCube(30);
    std::vector<Scan> scans;
    for (int i = random.integer(1, 3); i > 0; --i)
    {
      Scan& scan = scans.emplace_back(randomScan(random, recipe));
      if (random.chance(0.5)) continue;  // its rays are in the map's frame
      const Eigen::Vector3d axis = random.inCube(1.0).normalized();
      scan.sensorPose_map.linear() = Eigen::AngleAxisd(random.uniform(-3.1, 3.1), axis).toRotationMatrix();
      scan.sensorPose_map.translation() = random.inCube(5);
    }
    expectAgreement(structure, inference, scans);
    if (HasFailure()) return;
  }
}

TEST(BgkMapProperty, EvidenceIsTheBruteForceSumForEveryPreset)
{
  for (const BgkPreset preset : {BgkPreset::Default, BgkPreset::Thesis, BgkPreset::La3dm})
    for (unsigned seed = 1; seed <= seeds(10); ++seed)
    {
      SCOPED_TRACE("preset " + std::to_string(static_cast<int>(preset)) + ", seed " + std::to_string(seed));
      Random random(seed);
      BgkOptions options = presetOptions(preset);
      options.inference.beamWidth = BeamWidth::None;  // the oracle knows no widths
      if (options.structure.pruning == Pruning::State) options.structure.pruning = Pruning::None;
      ScanRecipe recipe;
      recipe.halfEdge_m = 1.5;
      recipe.rays = 40;
      expectAgreement(options.structure, options.inference,
                      {randomScan(random, recipe), randomScan(random, recipe)});
    }
}

// Rays that run along faces, edges and corners of cells and blocks, ends on them, origins on them.
TEST(BgkMapProperty, FacesEdgesAndCornersOfBlocksAreInvisible)
{
  for (const TrainingPoints trainingPoints : kAllTrainingPoints)
    for (const FreeSpace freeSpace : kAllFreeSpaces)
      for (int blockDepth = 2; blockDepth <= 6; ++blockDepth)
      {
        BgkStructure structure;
        structure.resolution = 0.125;
        structure.blockDepth = blockDepth;
        BgkInference inference;
        inference.trainingPoints = trainingPoints;
        inference.freeSpace = freeSpace;
        inference.beamWidth = BeamWidth::None;
        SCOPED_TRACE(nameOf(inference) + ", block depth " + std::to_string(blockDepth));
        const double block = structure.resolution * (1 << (blockDepth - 1));
        RayFan fan;
        for (const double x : {-block, 0.0, block, 0.5 * block})
          for (const double y : {-block, 0.0, block}) fan.addReturn({x, y, 0.0});
        fan.addReturn({0, 0, block});
        fan.addReturn({0, 0, -block});
        for (const Eigen::Vector3d& origin : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(-2 * block, 0, 0),
                                              Eigen::Vector3d(0.5, 0.25, -0.375)})
        {
          fan.centre = origin;
          expectAgreement(structure, inference, {scanWith({fan})});
        }
      }
}

// One hit in the middle of cell (0, 0, 0): by hand from eq. (4.10) at r = 0, 1/2, and √2/2.
TEST(BgkMap, WeighsAHitByHand)
{
  BgkStructure structure;
  structure.resolution = 0.5;
  BgkInference inference;
  inference.freeSpace = FreeSpace::None;
  BgkMap map(structure);
  const RayCounts counts = map.insert(scanWith({fanOf({9.3, 0.1, 0.2}, {{0.3, 0.2, 0.1}})}), inference);
  EXPECT_EQ(counts.hits, 1u);
  const auto alphaAt = [&](const CellIndex& cell)
  { return map.cell(cell, inference.thresholds)->evidence[0]; };
  EXPECT_NEAR(alphaAt({0, 0, 0}), 0.003 + 1.0, 1e-6);
  for (const CellIndex& cell : {CellIndex{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}})
    EXPECT_NEAR(alphaAt(cell), 0.003 + 1.0 / 6.0, 1e-6);
  const double r = std::sqrt(0.5), pi = std::acos(-1.0);
  EXPECT_NEAR(alphaAt({1, 1, 0}),
              0.003 + (2 + std::cos(2 * pi * r)) * (1 - r) / 3 + std::sin(2 * pi * r) / (2 * pi), 1e-6);
  EXPECT_EQ(map.cell({0, 0, 0}, inference.thresholds)->evidence[1], 0.003);
  EXPECT_EQ(map.cell({0, 0, 0}, inference.thresholds)->state, CellState::Occupied);
}

// A cell whose centre is exactly as far as the support is not within it.
TEST(BgkMap, GivesNothingAtExactlyTheSupport)
{
  for (const double resolution : {0.125, 0.25, 0.1, 0.05, 0.3})
    for (const int support_cells : {1, 2, 3, 5})
    {
      SCOPED_TRACE(std::to_string(resolution) + " m, " + std::to_string(support_cells) + " cells");
      BgkStructure structure;
      structure.resolution = resolution;
      BgkInference inference;
      inference.freeSpace = FreeSpace::None;
      // As somebody writes it: 0.3, not the product of 3 and 0.1, which is larger.
      inference.kernelSupport = std::round(support_cells * resolution * 1000) / 1000;
      BgkMap map(structure);
      const Eigen::Vector3d hit = Eigen::Vector3d(7.3, -4.6, 2.2) * resolution;
      map.insert(scanWith({fanOf({0, 0, 0}, {hit})}), inference);
      for (const int sign : {-1, 1})
      {
        EXPECT_TRUE(map.cell({7 + sign * (support_cells - 1), -5, 2}, {}).has_value());
        EXPECT_FALSE(map.cell({7 + sign * support_cells, -5, 2}, {}).has_value());
        EXPECT_FALSE(map.cell({7, -5 + sign * support_cells, 2}, {}).has_value());
        EXPECT_FALSE(map.cell({7, -5, 2 + sign * support_cells}, {}).has_value());
      }
      // 3² + 4² = 5².
      if (support_cells == 5)
      {
        EXPECT_FALSE(map.cell({7 + 3, -5 - 4, 2}, {}).has_value());
      }
    }
}

/// A sensor half a metre above a floor, before a wall, whose beams are too close for points with a width.
Scan denseScanOfACorner()
{
  RayFan fan;
  for (int azimuth = -40; azimuth <= 40; ++azimuth)
    for (int elevation = -25; elevation <= 20; ++elevation)
    {
      const Eigen::Vector3d direction = towards(azimuth, elevation);
      const double toWall = 1.53 / direction.x();
      const double toFloor = elevation < 0 ? -0.52 / direction.z() : toWall;
      fan.addReturn(direction * std::min(toWall, toFloor));
    }
  Scan scan = scanWith({fan});
  scan.sensorPose_map.translation() = Eigen::Vector3d(0.031, -0.017, 0.51);
  return scan;
}

TEST(BgkMapProperty, WithSpacingUnseenCellsAreFreeOnlyAmongFreeCells)
{
  const Scan scan = denseScanOfACorner();
  for (const bool planar : {false, true})
    for (const int blockDepth : {3, 4})  // by sums, and from tables
      for (const double support_cells : {2.0, 2.6})
      {
        SCOPED_TRACE(testing::Message() << planar << " " << blockDepth << " " << support_cells);
        BgkStructure structure;
        structure.blockDepth = blockDepth;
        structure.planar = planar;
        structure.planarHeight = 0.51;
        BgkInference inference;
        ASSERT_EQ(inference.beamWidth, BeamWidth::Spacing);
        inference.kernelSupport = support_cells * structure.resolution;
        EXPECT_LT(expectAgreement(structure, inference, {scan}), 1e-6);
      }
}

// Parallel beams, one through the centre of each cell but for a gap. By hand: the half-space above a cell of
// the floor is k(1) + 4 k(√2) + 4 k(√3) = 0.232 with a support of 2 cells.
TEST(BgkMap, WithSpacingTheFloorBelowTheLowestBeamIsNotFreeButAGapBetweenBeamsIs)
{
  std::vector<RayFan> beams;
  for (int y = -3; y <= 3; ++y)
    for (int z = 0; z < 3; ++z)
      if (y != 0 || z != 1)
      {
        const Eigen::Vector3d centre(0.05, 0.1 * y + 0.05, 0.1 * z + 0.05);
        beams.push_back(fanOf(centre, {centre + Eigen::Vector3d(2, 0, 0)}));
      }
  BgkInference inference;
  BgkMap kept;
  kept.insert(scanWith(beams), inference);
  inference.beamWidth = BeamWidth::None;
  BgkMap plain;
  plain.insert(scanWith(beams), inference);
  const auto freeAt = [](const BgkMap& map, const CellIndex& cell)
  { return static_cast<double>(map.evidence().at(cell).second) * kEvidenceUnit; };
  EXPECT_NEAR(freeAt(plain, {10, 2, -1}), 0.5 * 0.232, 1e-3);
  EXPECT_NEAR(freeAt(kept, {10, 2, -1}), 0.5 * 0.232 / 128, 1e-5);
  EXPECT_EQ(freeAt(kept, {10, 0, 1}), freeAt(plain, {10, 0, 1}));  // the gap
  EXPECT_EQ(freeAt(kept, {10, 2, 0}), freeAt(plain, {10, 2, 0}));  // seen
}

// Invariant 3.
TEST(BgkMapProperty, CellsBeyondTheSupportKeepThePrior)
{
  for (unsigned seed = 1; seed <= seeds(20); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    BgkStructure structure;
    structure.pruning = random.pick<Pruning>({Pruning::None, Pruning::Lossless, Pruning::State});
    structure.priorAlpha = 0.02;
    structure.priorBeta = 0.05;
    const BgkInference inference = randomInference(random, structure.resolution);
    BgkMap map(structure);
    std::vector<OracleField> fields;
    for (int i = 0; i < 3; ++i)
    {
      const Scan scan = randomScan(random, {});
      fields.emplace_back(scan, structure, inference);
      map.insert(scan, inference, 1);
    }
    for (int i = 0; i < 20000; ++i)
    {
      const CellIndex cell{random.integer(-25, 25), random.integer(-25, 25), random.integer(-25, 25)};
      bool reached = false;
      for (const OracleField& field : fields)
      {
        const OracleEvidence evidence = field.at({cell.x, cell.y, cell.z});
        reached |= evidence.occupiedReach != OracleEvidence::Reach::No ||
                   evidence.freeReach != OracleEvidence::Reach::No;
      }
      if (reached) continue;
      ASSERT_FALSE(map.cell(cell, {}).has_value());
      ASSERT_FALSE(map.at(cellCentre(cell, structure.resolution), {}).has_value());
      ASSERT_FALSE(map.evidence().at(cell).any());
      ASSERT_EQ(map.priorOf(cell), (std::array<double, 2>{0.02, 0.05}));
    }
  }
}
}  // namespace
}  // namespace lamap::test
