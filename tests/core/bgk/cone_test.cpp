// Wide beams in BGK maps: the evidence of their training points, and what all maps promise.
#include <gtest/gtest.h>
#include <lamap_core/bgk/map.h>
#include <lamap_core/training/sampler.h>
#include <support/bgk_inferences.h>
#include <support/bgk_oracle.h>
#include <support/grid_words.h>
#include <support/seeded_scans.h>
#include <support/seeds.h>

#include <cmath>

namespace lamap::test
{
namespace
{
constexpr double kDegree = M_PI / 180;

/// Pings of some sonars that look ahead, the echoes of each 0.4 m or more apart.
Scan pings(Random& random, double aperture_deg)
{
  Scan scan;
  scan.sensorPose_map.translation() = random.inCube(3);
  scan.sensorPose_map.linear() =
      Eigen::AngleAxisd(random.uniform(-3, 3), random.inCube(1).normalized()).toRotationMatrix();
  for (int i = 0; i < 3; ++i)
  {
    RayFan& fan = scan.fans.emplace_back();
    fan.centre = random.inCube(0.2);
    fan.beam.halfWidth_rad = 0.5 * aperture_deg * kDegree;
    fan.beam.halfHeight_rad = 0.8 * fan.beam.halfWidth_rad;
    fan.statedRangeMax_m = 3;
    const Eigen::Vector3d direction = (Eigen::Vector3d(1.5, 0, 0) + random.inCube(1)).normalized();
    double range = random.uniform(0.8, 1.5);
    for (uint8_t rank = 0; rank < i; ++rank, range += 0.4 + random.uniform(0, 0.4))
      fan.rays.push_back({fan.centre + range * direction, RayEnd::Return, rank});
    if (fan.rays.empty()) fan.rays.push_back({3.5 * direction + fan.centre, RayEnd::Return, 0});
  }
  return scan;
}

TEST(BgkCone, EvidenceIsTheSumOverTheTrainingPoints)
{
  for (unsigned seed = 1; seed <= seeds(4); ++seed)
    for (const BgkInference& inference : inferencesWith(BeamWidth::Observation))
    {
      if (inference.freeSpace == FreeSpace::Line) continue;
      SCOPED_TRACE(seed);
      Random random(seed);
      const Scan scan = pings(random, 20);
      BgkMap map;
      map.insert(scan, inference);

      const double resolution_m = map.structure().resolution;
      const BgkInference resolved = inference.resolved(resolution_m);
      const SelectedRays rays = selectRays(scan, resolved.rangeLimits());
      const ScanFrame frame = ScanFrame::around(rays.scan, resolution_m, std::nullopt);
      Sampler sampler;
      const lamap::TrainingSet& set =
          sampler.sample(rays, resolved.samplingRules(), frame, BlockOffset(frame.anchor()), 1);
      std::vector<TrainingPoint> points;
      set.forEachPoint([&](const TrainingPoint& point) { points.push_back(point); });
      // Free points that stand by themselves in a protected cell still speak for the cells beside it.
      for (const PlacedPoint& free : set.freePoints)
        if (set.isIn(&BlockMasks::protectedHit, cellOfLocal(free.place)))
          points.push_back({free.place, false, set.freeWeight * free.weight, 0});

      size_t compared = 0;
      for (const CellEvidence& cell : cellsOf(map.evidence()))
      {
        if (++compared % 7 != 0) continue;
        const CellIndex local{cell.cell.x - frame.anchor().x, cell.cell.y - frame.anchor().y,
                              cell.cell.z - frame.anchor().z};
        const Eigen::Vector3d centre(local.x + 0.5, local.y + 0.5, local.z + 0.5);
        double occupied = 0;
        double free = 0;
        double tolerance = 1e-5;
        for (const TrainingPoint& point : points)
        {
          const double distance = (point.place - centre).norm();
          (point.occupied ? occupied : free) += point.weight * oracleKernel(resolved.kernel, distance, 2, 1);
          if (distance < 2) tolerance += 1e-6;  // of the kernel's polynomial
        }
        if (set.isIn(&BlockMasks::protectedHit, local)) free = 0;
        ASSERT_NEAR(static_cast<double>(cell.evidence.first) * kEvidenceUnit, occupied, tolerance);
        ASSERT_NEAR(static_cast<double>(cell.evidence.second) * kEvidenceUnit, free, tolerance);
      }
      ASSERT_GT(compared, 1000U);
    }
}

TEST(BgkCone, AnApertureThatTendsToZeroGivesThePlainMap)
{
  for (BgkInference inference : inferencesWith(BeamWidth::Observation))
  {
    Random random(3);
    const Scan scan = pings(random, 1e-3);
    inference.beamWidth = BeamWidth::Observation;
    BgkMap cone;
    cone.insert(scan, inference);
    Scan narrow = scan;
    for (RayFan& fan : narrow.fans) fan.beam = {};
    BgkMap plain;
    plain.insert(narrow, inference);
    EXPECT_EQ(differenceOf(cone.evidence(), plain.evidence()), "");
    // But for later echoes, which free nothing.
    for (RayFan& fan : narrow.fans)
      if (fan.rays.size() > 1) fan.rays.resize(1);
    BgkMap firstEchoes;
    firstEchoes.insert(narrow, inference);
    inference.beamWidth = BeamWidth::None;
    BgkMap without;
    without.insert(narrow, inference);
    EXPECT_EQ(differenceOf(firstEchoes.evidence(), without.evidence()), "");
  }
}

TEST(BgkCone, WithoutBeamWidthAnApertureMeansNothing)
{
  for (BgkInference inference : inferencesWith(BeamWidth::Observation))
  {
    inference.beamWidth = BeamWidth::None;
    Random random(4);
    Scan scan = pings(random, 20);
    BgkMap stated;
    stated.insert(scan, inference);
    for (RayFan& fan : scan.fans)
    {
      fan.beam = {};
      for (Ray& ray : fan.rays) ray.echo = 0;
    }
    BgkMap plain;
    plain.insert(scan, inference);
    EXPECT_EQ(differenceOf(stated.evidence(), plain.evidence()), "");
  }
}

TEST(BgkCone, ThreadsAndOrderChangeNothing)
{
  for (const BgkInference& inference : inferencesWith(BeamWidth::Observation))
  {
    Random random(5);
    const Scan one = pings(random, 15);
    const Scan other = pings(random, 30);
    BgkMap serial;
    serial.insert(one, inference, 1);
    serial.insert(other, inference, 1);
    BgkMap parallel;
    parallel.insert(other, inference, 4);
    parallel.insert(one, inference, 4);
    EXPECT_EQ(differenceOf(serial.evidence(), parallel.evidence()), "");
  }
}

TEST(BgkCone, MovingByWholeCellsMovesTheMap)
{
  BgkStructure structure;
  structure.resolution = 0.125;
  const CellIndex by{-13, 4099, 7};
  for (const BgkInference& inference : inferencesWith(BeamWidth::Observation))
  {
    Random random(6);
    Scan scan = quantized(pings(random, 15), 20);
    BgkMap here(structure);
    here.insert(scan, inference);
    BgkMap there(structure);
    there.insert(moved(scan, 0.125 * Eigen::Vector3d(by.x, by.y, by.z)), inference);
    const std::vector<CellEvidence> cells = cellsOf(here.evidence());
    ASSERT_EQ(cells.size(), cellsOf(there.evidence()).size());
    for (const CellEvidence& cell : cells)
    {
      const CellIndex place{cell.cell.x + by.x, cell.cell.y + by.y, cell.cell.z + by.z};
      // The rays over a cone are no round numbers: where points stand as they are, the last unit may differ.
      const CellSums evidence = there.evidence().at(place);
      ASSERT_NEAR(static_cast<double>(evidence.first), static_cast<double>(cell.evidence.first), 1);
      ASSERT_NEAR(static_cast<double>(evidence.second), static_cast<double>(cell.evidence.second), 1);
    }
  }
}

TEST(BgkCone, TheCapTakesNoFreeEvidence)
{
  for (const BgkInference& inference : inferencesWith(BeamWidth::Observation))
  {
    Scan scan;
    RayFan& fan = scan.fans.emplace_back();
    fan.centre = {0.05, 0.05, 0.05};
    fan.beam.halfWidth_rad = fan.beam.halfHeight_rad = 10 * kDegree;
    fan.addReturn({3.05, 0.05, 0.05});
    BgkMap map;
    map.insert(scan, inference);
    for (int i = -4; i <= 4; ++i)
    {
      const Eigen::Vector3d place = fan.centre + 3 * towards(2.0 * i);
      const auto cell = cellAt(place, map.structure().resolution);
      const CellSums evidence = map.evidence().at(*cell);
      EXPECT_GT(evidence.first, 0U) << i;
      EXPECT_EQ(evidence.second, 0U) << i;
      EXPECT_GT(
          map.evidence().at(*cellAt(fan.centre + 2 * towards(2.0 * i), map.structure().resolution)).second,
          0U);
    }
  }
}

}  // namespace
}  // namespace lamap::test
