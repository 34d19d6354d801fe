// Invariant 9: where free space ends.
#include <gtest/gtest.h>
#include <lamap_core/bgk/map.h>
#include <lamap_core/scan/open_space.h>
#include <support/bgk_oracle.h>
#include <support/grid_words.h>
#include <support/random_options.h>
#include <support/seeded_scans.h>
#include <support/seeds.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace lamap::test
{
namespace
{
constexpr double kResolution = 0.1;
/// A sample is at most half a diagonal from the centre of its cell.
const double kSnap = kResolution * std::sqrt(3.0) / 2;

/// Where free points of a ray may be: up to its end less the margin.
std::vector<FreeLine> allowedSegments(const RayFan& fan, const BgkInference& inference)
{
  std::vector<FreeLine> segments;
  const auto add = [&](const Eigen::Vector3d& ray, double length, double margin)
  {
    if (length - margin < 0) return;
    segments.push_back({fan.centre, fan.centre + ray.normalized() * (length - margin)});
  };
  for (const Eigen::Vector3d& end : endsOf(fan))
  {
    const Eigen::Vector3d ray = end - fan.centre;
    const bool cut = inference.maxRange > 0 && ray.norm() > inference.maxRange;
    add(ray, cut ? inference.maxRange : ray.norm(), cut ? 0 : *inference.freeMargin);
  }
  OpenSpace openSpace(fan, 0);
  for (const Eigen::Vector3d& direction : endsOf(fan, RayEnd::NoReturn))
  {
    if (!inference.considerInvalidRangesAsFreeSpace) continue;
    const double reach = openSpace.reach_m(direction);
    add(direction, inference.maxRange > 0 ? std::min(reach, inference.maxRange) : reach, 0);
  }
  return segments;
}

TEST(BgkMapProperty, NoFreeEvidenceBehindARaysEndOrWithinTheMargin)
{
  for (const FreeSpace freeSpace : {FreeSpace::Samples, FreeSpace::Line})
    for (const TrainingPoints trainingPoints : kAllTrainingPoints)
      for (const double margin : {0.0, 0.05, 0.1, 0.25, 0.8})
        for (unsigned seed = 1; seed <= seeds(20); ++seed)
        {
          Random random(seed);
          BgkInference inference = randomInference(random, kResolution);
          inference.freeSpace = freeSpace;
          inference.trainingPoints = trainingPoints;
          inference.freeMargin = margin;
          inference.rayDecimation = 1;
          inference.minRange = 0;
          inference.kernelSupport = random.uniform(0.5, 2) * kResolution;
          if (inference.maxRange > 0) inference.maxRange = random.uniform(0.5, 1.5);
          // One ray for each end, so that the rays are those of the scan.
          inference.hitDownsampling = 0.0;
          inference.freeDownsampling = 0.0;
          SCOPED_TRACE("seed " + std::to_string(seed) + ": " + nameOf(inference) + ", margin " +
                       std::to_string(margin));
          RayFan fan;
          fan.centre = random.inCube(0.3);
          for (int i = 0; i < 3; ++i) fan.addReturn(random.inCube(1.5));
          fan.add(RayEnd::NoReturn, random.inCube(1));
          BgkMap map;
          map.insert(scanWith({fan}), inference, 1);

          const std::vector<FreeLine> segments = allowedSegments(fan, inference);
          // In `cells` samples are snapped; in lines they are where they are.
          const bool snapped = trainingPoints == TrainingPoints::Cells && freeSpace == FreeSpace::Samples;
          const double reach = *inference.kernelSupport + (snapped ? kSnap : 0) + 1e-9;
          size_t free = 0;
          for (const CellEvidence& cell : cellsOf(map.evidence()))
          {
            if (cell.evidence.second == 0) continue;
            ++free;
            double nearest = 1e9;
            for (const FreeLine& segment : segments)
              nearest = std::min(nearest, segment.distanceTo(cellCentre(cell.cell, kResolution)));
            ASSERT_LE(nearest, reach) << cell.cell.x << ", " << cell.cell.y << ", " << cell.cell.z;
          }
          if (!segments.empty() && *inference.kernelSupport > kSnap)
          {
            EXPECT_GT(free, 0u);
          }
        }
}

/// The farthest cell along +x of the ray's own row that holds free evidence.
int farthestFree(const BgkInference& inference, const RayFan& fan)
{
  BgkMap map;
  map.insert(scanWith({fan}), inference, 1);
  int farthest = -1000;
  for (const CellEvidence& cell : cellsOf(map.evidence()))
    if (cell.evidence.second > 0 && cell.cell.y == 0 && cell.cell.z == 0)
      farthest = std::max(farthest, cell.cell.x);
  return farthest;
}

TEST(BgkMap, EndsFreeSpaceOneMarginBeforeTheHit)
{
  // From the centre of cell 0 to the centre of cell 20; the support reaches only the training cell itself.
  const RayFan fan = fanOf({0.05, 0.05, 0.05}, {{2.05, 0.05, 0.05}});
  for (const FreeSpace freeSpace : {FreeSpace::Samples, FreeSpace::Line})
    for (const TrainingPoints trainingPoints : kAllTrainingPoints)
    {
      BgkInference inference;
      inference.freeSpace = freeSpace;
      inference.trainingPoints = trainingPoints;
      inference.protectHits = 0;
      inference.kernelSupport = 0.04;
      SCOPED_TRACE(nameOf(inference));
      inference.freeMargin = 0.17;  // samples end at 1.8, lines at 1.83: both in cell 18
      EXPECT_EQ(farthestFree(inference, fan), 18);
      inference.freeMargin = 0.08;
      EXPECT_EQ(farthestFree(inference, fan), 19);
      inference.freeMargin = 0.57;
      EXPECT_EQ(farthestFree(inference, fan), 14);
      inference.freeMargin = 2.1;
      EXPECT_EQ(farthestFree(inference, fan), -1000);
    }
}

TEST(BgkMap, FreesUpToTheMaximumRangeWithoutAHit)
{
  const RayFan returned = fanOf({0.05, 0.05, 0.05}, {{5.05, 0.05, 0.05}});
  const RayFan notReturned = fanOf({0.05, 0.05, 0.05}, {}, {{7, 0, 0}});
  const RayFan stated = fanOf({0.05, 0.05, 0.05}, {{5.05, 0.05, 0.05}}, {{0.1, 0, 0}}, 0, 1.53);
  for (const FreeSpace freeSpace : {FreeSpace::Samples, FreeSpace::Line})
    for (const TrainingPoints trainingPoints : kAllTrainingPoints)
    {
      BgkInference inference;
      inference.freeSpace = freeSpace;
      inference.trainingPoints = trainingPoints;
      inference.kernelSupport = 0.04;
      inference.maxRange = 1.53;  // no margin before an end without a hit: the last sample is at 1.5
      SCOPED_TRACE(nameOf(inference));
      EXPECT_EQ(farthestFree(inference, returned), 15);
      EXPECT_EQ(farthestFree(inference, notReturned), 15);
      inference.maxRange = 0;
      EXPECT_EQ(farthestFree(inference, stated), 15);
      EXPECT_EQ(farthestFree(inference, notReturned), -1000);

      inference.maxRange = 1.53;
      for (const RayFan& fan : {returned, notReturned, stated})
      {
        BgkMap map;
        map.insert(scanWith({fan}), inference, 1);
        for (const CellEvidence& cell : cellsOf(map.evidence())) EXPECT_EQ(cell.evidence.first, 0u);
      }
      inference.considerInvalidRangesAsFreeSpace = false;
      EXPECT_EQ(farthestFree(inference, returned), 15);
      EXPECT_EQ(farthestFree(inference, notReturned), -1000);
    }
}

TEST(BgkMap, SparesCellsWithEnoughHitsFromFreeEvidence)
{
  // Two hits in cell (10, 0, 0), one in cell (10, 5, 0); rays pass through both to something behind.
  const RayFan fan = fanOf({0.05, 0.05, 0.05}, {{1.03, 0.05, 0.05}, {1.07, 0.06, 0.05}, {1.05, 0.55, 0.05}});
  const RayFan behind = fanOf({1.05, -2.05, 0.05}, {{1.05, 3.05, 0.05}});
  for (const FreeSpace freeSpace : {FreeSpace::Samples, FreeSpace::Line})
    for (const TrainingPoints trainingPoints : kAllTrainingPoints)
    {
      BgkInference inference;
      inference.freeSpace = freeSpace;
      inference.trainingPoints = trainingPoints;
      SCOPED_TRACE(nameOf(inference));
      const auto freeIn = [&](uint32_t protectHits, const CellIndex& cell)
      {
        inference.protectHits = protectHits;
        BgkMap map;
        map.insert(scanWith({fan, behind}), inference, 1);
        EXPECT_GT(map.evidence().at(cell).first, 0u);
        return map.evidence().at(cell).second;
      };
      EXPECT_GT(freeIn(0, {10, 0, 0}), 0u);
      EXPECT_EQ(freeIn(1, {10, 0, 0}), 0u);
      EXPECT_EQ(freeIn(2, {10, 0, 0}), 0u);
      EXPECT_GT(freeIn(3, {10, 0, 0}), 0u);
      EXPECT_EQ(freeIn(1, {10, 5, 0}), 0u);
      EXPECT_GT(freeIn(2, {10, 5, 0}), 0u);
      EXPECT_GT(freeIn(2, {10, 1, 0}), 0u);  // its neighbour is not spared

      // In another scan the cell is not spared.
      inference.protectHits = 2;
      BgkMap map;
      map.insert(scanWith({fan}), inference, 1);
      EXPECT_EQ(map.evidence().at({10, 0, 0}).second, 0u);
      map.insert(scanWith({behind}), inference, 1);
      EXPECT_GT(map.evidence().at({10, 0, 0}).second, 0u);
    }
}
/// Rays along a wall pass through cells that hold it, between their returns.
TEST(BgkFreeSpace, PassesThroughASeenSurfaceOnlyWhereHitsAreNotProtected)
{
  constexpr double kAside_m = 1.03;
  RayFan fan;
  std::set<int> hit;
  for (int degrees = 7; degrees <= 27; ++degrees)
  {
    const double x = kAside_m / std::tan(degrees * M_PI / 180);
    fan.addReturn({x, kAside_m, 0.05});
    hit.insert(static_cast<int>(std::floor(x / 0.1)));
  }
  const auto freeEvidence = [&](uint32_t protectHits)
  {
    BgkInference inference;
    inference.beamWidth = BeamWidth::None;
    inference.protectHits = protectHits;
    BgkMap map;
    map.insert(scanWith({fan}), inference);
    uint64_t sum = 0;
    for (int x = 20; x < 80; ++x)
      if (hit.count(x) == 0) sum += map.evidence().at({x, 10, 0}).second;
    return static_cast<double>(sum);
  };
  EXPECT_LT(freeEvidence(1), 0.8 * freeEvidence(0));
  EXPECT_EQ(freeEvidence(1), freeEvidence(3)) << "the number of hits is of no matter beside them";
}

}  // namespace
}  // namespace lamap::test
