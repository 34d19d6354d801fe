// What a reading means, for all four maps: a laser in a room.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservation2DRangeScan.h>

#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "law_maps.h"

namespace lamap::test
{
namespace
{
template <typename Map>
class ReadingLaws : public ::testing::Test
{
};
TYPED_TEST_SUITE(ReadingLaws, AllMaps);

constexpr double kHalfWidth_m = 3;
constexpr double kHalfDepth_m = 2.5;
constexpr double kResolution_m = 0.1;

struct Pole
{
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  double radius_m = 0;  ///< 0: there is none
};

/// Distance to the walls of the room, or to the pole, from a place inside.
double rangeIn(const Pole& pole, const Eigen::Vector2d& from, const Eigen::Vector2d& direction,
               const Eigen::Vector2d& halfSize)
{
  const auto toWall = [&](int axis, double half)
  {
    return direction[axis] == 0 ? 1e9 : ((direction[axis] > 0 ? half : -half) - from[axis]) / direction[axis];
  };
  double range_m = std::min(toWall(0, halfSize.x()), toWall(1, halfSize.y()));
  const Eigen::Vector2d to = pole.centre - from;
  const double along = to.dot(direction);
  const double aside = to.squaredNorm() - along * along;
  const double squared = pole.radius_m * pole.radius_m;
  if (along > 0 && aside < squared) range_m = std::min(range_m, along - std::sqrt(squared - aside));
  return range_m;
}

mrpt::obs::CObservation2DRangeScan scanIn(const Pole& pole, const Eigen::Vector2d& from,
                                          const Eigen::Vector2d& halfSize = {kHalfWidth_m, kHalfDepth_m})
{
  constexpr size_t kBeams = 541;
  mrpt::obs::CObservation2DRangeScan scan;
  scan.aperture = static_cast<float>(1.5 * M_PI);
  scan.maxRange = 12;
  scan.resizeScan(kBeams);
  for (size_t i = 0; i < kBeams; ++i)
  {
    const double azimuth = scan.aperture * (static_cast<double>(i) / (kBeams - 1) - 0.5);
    const Eigen::Vector2d direction(std::cos(azimuth), std::sin(azimuth));
    scan.setScanRange(i, static_cast<float>(rangeIn(pole, from, direction, halfSize)));
    scan.setScanRangeValidity(i, true);
  }
  return scan;
}

/// Where a ray of a scan ended.
Eigen::Vector2d endOf(const mrpt::obs::CObservation2DRangeScan& scan, size_t ray, const Eigen::Vector2d& from)
{
  const double azimuth =
      scan.aperture * (static_cast<double>(ray) / static_cast<double>(scan.getScanSize() - 1) - 0.5);
  return from +
         static_cast<double>(scan.getScanRange(ray)) * Eigen::Vector2d(std::cos(azimuth), std::sin(azimuth));
}

std::pair<int, int> cellOf(const Eigen::Vector2d& place)
{
  return {static_cast<int>(std::floor(place.x() / kResolution_m)),
          static_cast<int>(std::floor(place.y() / kResolution_m))};
}

template <typename Map>
Map planarMap()
{
  return made<Map>({{"creationOpts.planar", "true"}, {"insertOpts.maxRange", "30"}});
}

template <typename Map>
size_t freeCells(const Map& map)
{
  size_t count = 0;
  map.visitCells([&](const CellIndex&, const CellEstimate& estimate)
                 { count += estimate.state == CellState::Free; });
  return count;
}

std::vector<Eigen::Vector2d> placesInTheRoom()
{
  std::vector<Eigen::Vector2d> places;
  for (int i = 0; i < 12; ++i) places.emplace_back(-2.6 + 0.11 * i, 0.4 * std::sin(i));
  return places;
}

TYPED_TEST(ReadingLaws, AThinPoleThatEveryScanHitsIsNotFree)
{
  for (const Pole& pole : {Pole{{1.03, 0.04}, 0.03}, Pole{{0.55, -0.65}, 0.05}, Pole{{1.0, 0.3}, 0.05}})
  {
    SCOPED_TRACE(pole.centre.transpose());
    auto map = planarMap<TypeParam>();
    std::map<std::pair<int, int>, size_t> scansThatHit;
    const auto places = placesInTheRoom();
    for (const Eigen::Vector2d& place : places)
    {
      const auto scan = scanIn(pole, place);
      map.insertObservation(scan, mrpt::poses::CPose3D(place.x(), place.y(), 0, 0, 0, 0));
      std::set<std::pair<int, int>> hit;
      for (size_t i = 0; i < scan.getScanSize(); ++i)
      {
        const Eigen::Vector2d end = endOf(scan, i, place);
        if ((end - pole.centre).norm() < pole.radius_m + 1e-3) hit.insert(cellOf(end));
      }
      for (const auto& cell : hit) ++scansThatHit[cell];
    }
    size_t alwaysHit = 0;
    for (const auto& [cell, scans] : scansThatHit)
    {
      if (scans < places.size()) continue;
      ++alwaysHit;
      const mrpt::math::TPoint3D centre((cell.first + 0.5) * kResolution_m,
                                        (cell.second + 0.5) * kResolution_m, 0);
      const auto held = map.estimateCell({cell.first, cell.second, *map.planarLayer()});
      const auto asked = map.estimateAt(centre);
      ASSERT_TRUE(held && asked);
      EXPECT_NE(held->state, CellState::Free) << centre << ": " << held->prob;
      EXPECT_NE(asked->state, CellState::Free) << centre << ": " << asked->prob;
    }
    EXPECT_GT(alwaysHit, 0U);
  }
}

/// A wall is hit here and there where a laser looks along it, and rays to its farther parts pass close by.
TYPED_TEST(ReadingLaws, AWallAtAGlancingAngleIsNotFree)
{
  constexpr double kHalfLength_m = 9;
  constexpr double kAside_m = 1.03;
  auto map = planarMap<TypeParam>();
  std::set<std::pair<int, int>> hit;
  for (const Eigen::Vector2d& place : placesInTheRoom())
  {
    const auto scan = scanIn({}, place, {kHalfLength_m, kAside_m});
    map.insertObservation(scan, mrpt::poses::CPose3D(place.x(), place.y(), 0, 0, 0, 0));
    for (size_t i = 0; i < scan.getScanSize(); ++i)
    {
      const Eigen::Vector2d end = endOf(scan, i, place);
      const bool isFarAlong = end.x() > 2 && std::abs(end.y()) > kAside_m - 1e-3;
      if (isFarAlong) hit.insert(cellOf(end));
    }
  }
  size_t free = 0;
  for (const auto& [x, y] : hit)
  {
    const auto held = map.estimateCell({x, y, *map.planarLayer()});
    ASSERT_TRUE(held);
    free += held->state == CellState::Free;
  }
  EXPECT_GT(hit.size(), 100U);
  EXPECT_LE(free, 1U) << free << " of " << hit.size();
}

/// Loses every tenth reading, or so many neighbours at a time.
void lose(mrpt::obs::CObservation2DRangeScan& scan, size_t burst, float code)
{
  for (size_t i = 0; i < scan.getScanSize(); ++i)
  {
    if (i / burst % 10 != 3) continue;
    scan.setScanRange(i, code);
    scan.setScanRangeValidity(i, false);
  }
}

TYPED_TEST(ReadingLaws, LostReadingsMakeNoFreeSpaceBehindWalls)
{
  const auto cellsWith = [&](size_t burst, float code)
  {
    auto map = planarMap<TypeParam>();
    for (const Eigen::Vector2d& place : placesInTheRoom())
    {
      auto scan = scanIn({}, place);
      if (burst > 0) lose(scan, burst, code);
      map.insertObservation(scan, mrpt::poses::CPose3D(place.x(), place.y(), 0, 0, 0, 0));
    }
    return static_cast<double>(freeCells(map));
  };
  const double whole = cellsWith(0, 0);
  EXPECT_GT(whole, 2000);
  for (const size_t burst : {1U, 7U, 29U})
    for (const float code : {0.0F, 12.0F, 13.0F, std::numeric_limits<float>::infinity(),
                             std::numeric_limits<float>::quiet_NaN()})
      EXPECT_NEAR(cellsWith(burst, code) / whole, 1, 0.03) << burst << " " << code;
}

TYPED_TEST(ReadingLaws, OpenSpaceEndsAtTheSensorsRange)
{
  mrpt::obs::CObservation2DRangeScan scan = scanIn({}, {0, 0});
  scan.maxRange = 2;  // nearer than all walls
  auto map = planarMap<TypeParam>();
  map.insertObservation(scan, mrpt::poses::CPose3D());
  double farthest = 0;
  map.visitCells(
      [&](const CellIndex& cell, const CellEstimate& estimate)
      {
        const Eigen::Vector3d centre = cellCentre(cell, kResolution_m);
        if (estimate.state == CellState::Free) farthest = std::max(farthest, centre.head<2>().norm());
      });
  EXPECT_GT(farthest, 1.8);
  EXPECT_LT(farthest, 2 + Law<TypeParam>::kReach_m);
}

}  // namespace
}  // namespace lamap::test
