#include <gtest/gtest.h>
#include <lamap_mrpt/maps/CBGKMap.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/maps/CSimplePointsMap.h>

#include <limits>
#include <thread>

#include <support/small_maps.h>

namespace
{
using lamap::CBGKMap;
using lamap::test::roomScan;
using mrpt::maps::CSimplePointsMap;
using mrpt::poses::CPose2D;
using mrpt::poses::CPose3D;

/// An L of single occupied cells, and a free cell that must not count.
CBGKMap corner()
{
  CBGKMap map;
  for (int i = 0; i <= 10; ++i)
  {
    map.updateVoxel(0.05 + 0.3 * i, 0.05, 0.45, true);
    map.updateVoxel(0.05, 0.05 + 0.3 * i, 0.45, true);
  }
  map.updateVoxel(1.05, 1.05, 0.45, false);
  return map;
}

TEST(Matching, ThePointsAreTheCentresOfOccupiedCells)
{
  const CBGKMap map = corner();
  const CSimplePointsMap* points = map.getAsSimplePointsMap();
  ASSERT_TRUE(points);
  ASSERT_EQ(points->size(), 21u);
  std::vector<float> xs;
  for (size_t i = 0; i < points->size(); ++i)
  {
    float x, y, z;
    points->getPoint(i, x, y, z);
    EXPECT_FLOAT_EQ(z, 0.45f);
    EXPECT_TRUE(std::abs(x - 0.05f) < 1e-6f || std::abs(y - 0.05f) < 1e-6f);
  }
  EXPECT_EQ(map.getAsSimplePointsMap(), points) << "made once";
}

TEST(Matching, ThePointsFollowTheMapAndItsThresholds)
{
  CBGKMap map = corner();
  EXPECT_EQ(map.getAsSimplePointsMap()->size(), 21u);
  map.updateVoxel(5, 5, 5, true);
  EXPECT_EQ(map.getAsSimplePointsMap()->size(), 22u);
  map.insertionOptions.thresholds.occupied = 0.99999;
  EXPECT_EQ(map.getAsSimplePointsMap()->size(), 0u);
  map.insertionOptions.thresholds.occupied = 0.7;
  EXPECT_EQ(map.getAsSimplePointsMap()->size(), 22u);
}

/// Brute force from the definition of TMatchingParams, including angles and decimation.
size_t pairsByBruteForce(const CBGKMap& map, const CSimplePointsMap& others, const CPose3D& pose,
                         const mrpt::maps::TMatchingParams& params, bool flat)
{
  size_t pairs = 0;
  const CSimplePointsMap& mine = *map.getAsSimplePointsMap();
  for (size_t i = params.offset_other_map_points; i < others.size(); i += params.decimation_other_map_points)
  {
    mrpt::math::TPoint3D other;
    others.getPoint(i, other);
    const auto seen = pose.composePoint(other);
    double nearest = std::numeric_limits<double>::max();
    for (size_t j = 0; j < mine.size(); ++j)
    {
      mrpt::math::TPoint3D own;
      mine.getPoint(j, own);
      const double dz = flat ? 0 : own.z - seen.z;
      nearest = std::min(nearest, std::hypot(own.x - seen.x, own.y - seen.y, dz));
    }
    const auto& pivot = params.angularDistPivotPoint;
    const double toPivot = flat ? std::hypot(seen.x - pivot.x, seen.y - pivot.y) : (seen - pivot).norm();
    pairs += nearest < params.maxDistForCorrespondence + params.maxAngularDistForCorrespondence * toPivot;
  }
  return pairs;
}

CSimplePointsMap scattered()
{
  CSimplePointsMap points;
  for (int i = 0; i < 40; ++i)
    points.insertPoint(0.08f * static_cast<float>(i), 0.01f * static_cast<float>(i * i % 37),
                       0.45f + 0.02f * static_cast<float>(i % 5));
  return points;
}

TEST(Matching, PairsAreThoseOfBruteForceIn2DAnd3DInAnyOrder)
{
  const CBGKMap map = corner();
  const CSimplePointsMap others = scattered();
  const CPose3D pose(0.1, -0.05, 0, 0.05, 0, 0);
  for (const bool flat : {true, false, true, false})
  {
    for (const size_t decimation : {size_t{1}, size_t{3}})
    {
      SCOPED_TRACE(std::to_string(flat) + " " + std::to_string(decimation));
      mrpt::maps::TMatchingParams params;
      params.maxDistForCorrespondence = 0.08f;
      params.maxAngularDistForCorrespondence = 0.02f;
      params.angularDistPivotPoint = {0.5, 0.5, 0.4};
      params.decimation_other_map_points = decimation;
      params.offset_other_map_points = decimation - 1;
      mrpt::tfest::TMatchingPairList pairs;
      mrpt::maps::TMatchingExtraResults results;
      if (flat)
        map.determineMatching2D(&others, CPose2D(pose), pairs, params, results);
      else
        map.determineMatching3D(&others, pose, pairs, params, results);
      const size_t expected = pairsByBruteForce(map, others, pose, params, flat);
      EXPECT_GT(expected, 2u);
      EXPECT_EQ(pairs.size(), expected);
      EXPECT_NEAR(results.correspondencesRatio,
                  static_cast<double>(decimation * expected) / static_cast<double>(others.size()), 1e-5);
    }
  }
}

TEST(Matching, UniqueRobustKeepsOnePairPerCell)
{
  CBGKMap map;
  map.updateVoxel(0.05, 0.05, 0.05, true);
  CSimplePointsMap others;
  others.insertPoint(0.051f, 0.05f, 0.05f);
  others.insertPoint(0.35f, 0.05f, 0.05f);
  mrpt::maps::TMatchingParams params;
  params.onlyUniqueRobust = true;
  mrpt::tfest::TMatchingPairList pairs;
  mrpt::maps::TMatchingExtraResults results;
  map.determineMatching3D(&others, CPose3D(), pairs, params, results);
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_EQ(pairs[0].localIdx, 0u);
}

TEST(Matching, AllPairsAreGivenIfAskedFor)
{
  const CBGKMap map = corner();
  CSimplePointsMap others;
  others.insertPoint(0.05f, 0.05f, 0.45f);
  mrpt::maps::TMatchingParams params;
  params.onlyKeepTheClosest = false;
  params.maxDistForCorrespondence = 1.6f;
  mrpt::tfest::TMatchingPairList pairs;
  mrpt::maps::TMatchingExtraResults results;
  map.determineMatching3D(&others, CPose3D(), pairs, params, results);
  EXPECT_EQ(pairs.size(), 11u) << "the corner and five on each side";
  EXPECT_EQ(results.correspondencesRatio, 1.0f);
  params.onlyUniqueRobust = true;
  EXPECT_ANY_THROW(map.determineMatching3D(&others, CPose3D(), pairs, params, results));
}

TEST(Matching, TheRatioTakesPointsLearnedMapsAndWholeMultiMaps)
{
  const CBGKMap map = corner();
  mrpt::maps::TMatchingRatioParams params;
  params.maxDistForCorr = 0.05f;
  EXPECT_FLOAT_EQ(map.compute3DMatchingRatio(&map, CPose3D(), params), 1.0f);
  EXPECT_FLOAT_EQ(map.compute3DMatchingRatio(map.getAsSimplePointsMap(), CPose3D(), params), 1.0f);
  // Moved by 0.3 m along x: of the 21 points, the other ten of the row along x are still on cells, and one of
  // the column.
  EXPECT_NEAR(map.compute3DMatchingRatio(&map, CPose3D(0.3, 0, 0, 0, 0, 0), params), 10.0 / 21.0, 1e-5);
  EXPECT_FLOAT_EQ(map.compute3DMatchingRatio(&map, CPose3D(0, 0, 5, 0, 0, 0), params), 0.0f);

  mrpt::maps::CMultiMetricMap withLearned;
  withLearned.maps.push_back(std::make_shared<mrpt::maps::COccupancyGridMap2D>());
  withLearned.maps.push_back(std::make_shared<CBGKMap>(map));
  EXPECT_FLOAT_EQ(map.compute3DMatchingRatio(&withLearned, CPose3D(), params), 1.0f);
  mrpt::maps::CMultiMetricMap withPoints = withLearned;
  auto far = std::make_shared<CSimplePointsMap>();
  far->insertPoint(100, 100, 100);
  withPoints.maps.push_back(far);
  EXPECT_FLOAT_EQ(map.compute3DMatchingRatio(&withPoints, CPose3D(), params), 0.0f)
      << "its points map comes first";
  // As in map-partition: each of two multi-maps asks its own maps for the ratio to the other.
  EXPECT_GT(withLearned.compute3DMatchingRatio(&withLearned, CPose3D(), params), 0.0f);
}

TEST(Matching, WithoutPointsTheRatioIsZeroAndPairsAreRefused)
{
  const CBGKMap map = corner();
  const mrpt::maps::COccupancyGridMap2D grid;
  EXPECT_EQ(map.compute3DMatchingRatio(&grid, CPose3D(), {}), 0.0f);
  EXPECT_EQ(map.compute3DMatchingRatio(nullptr, CPose3D(), {}), 0.0f);
  mrpt::tfest::TMatchingPairList pairs;
  mrpt::maps::TMatchingExtraResults results;
  EXPECT_THROW(map.determineMatching2D(&grid, CPose2D(), pairs, {}, results), std::invalid_argument);
  EXPECT_THROW(map.determineMatching3D(&grid, CPose3D(), pairs, {}, results), std::invalid_argument);
  const CBGKMap empty;
  EXPECT_EQ(empty.compute3DMatchingRatio(&map, CPose3D(), {}), 0.0f);
  EXPECT_EQ(map.compute3DMatchingRatio(&empty, CPose3D(), {}), 0.0f);
  empty.determineMatching2D(&map, CPose2D(), pairs, {}, results);
  EXPECT_TRUE(pairs.empty());
}

TEST(Matching, SquaredDistanceIsToTheNearestCellInThePlane)
{
  const CBGKMap map = corner();
  EXPECT_NEAR(map.squareDistanceToClosestCorrespondence(-0.95f, 0.05f), 1.0f, 1e-5f);
  EXPECT_NEAR(map.squareDistanceToClosestCorrespondence(0.35f, 0.25f), 0.04f, 1e-5f);
  EXPECT_EQ(CBGKMap().squareDistanceToClosestCorrespondence(0, 0), std::numeric_limits<float>::max());
}

TEST(Matching, SeveralThreadsMayAskAtOnce)
{
  const CBGKMap map = corner();
  std::vector<std::thread> threads;
  std::vector<float> ratios(4);
  for (size_t i = 0; i < ratios.size(); ++i)
    threads.emplace_back(
        [&, i]
        {
          for (int k = 0; k < 20; ++k)
          {
            ratios[i] = map.compute3DMatchingRatio(&map, CPose3D(), {});
            (void)map.squareDistanceToClosestCorrespondence(1, 1);
            (void)map.computeObservationLikelihood(roomScan(), CPose3D(0.01 * k, 0, 0, 0, 0, 0));
            (void)map.boundingBox();
          }
        });
  for (std::thread& thread : threads) thread.join();
  for (const float ratio : ratios) EXPECT_FLOAT_EQ(ratio, 1.0f);
}

}  // namespace
