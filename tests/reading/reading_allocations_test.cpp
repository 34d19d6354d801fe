// Reading allocates nothing once it is warm.
#include <gtest/gtest.h>
#include <lamap_mrpt/maps/CBGKMap.h>
#include <lamap_mrpt/maps/CGPMap.h>
#include <lamap_mrpt/maps/COverlappingHilbertMap.h>
#include <support/small_maps.h>

#include <cmath>
#include <functional>
#include <new>

#include "counted_allocations.h"

namespace lamap::test
{
namespace
{
template <typename Map>
class ReadingAllocations : public ::testing::Test
{
};
using GridMaps = ::testing::Types<CBGKMap, CGPMap, COverlappingHilbertMap>;
TYPED_TEST_SUITE(ReadingAllocations, GridMaps);

/// How often something allocates when it is done again.
size_t allocationsOf(const std::function<void()>& work)
{
  work();
  const size_t before = allocations();
  work();
  return allocations() - before;
}

TYPED_TEST(ReadingAllocations, AreNone)
{
  const size_t before = allocations();
  ::operator delete(::operator new(3));
  ASSERT_GT(allocations(), before) << "none would be counted";

  TypeParam map;
  const auto scan = roomScan();
  map.insertObservation(scan);
  map.insertObservation(scan, mrpt::poses::CPose3D(0.1, 0, 0, 0.05, 0, 0));
  typename TypeParam::Core::Accessor accessor(map.core(), map.stateThresholds());
  size_t known = 0;
  EXPECT_EQ(allocationsOf(
                [&]
                {
                  for (int i = 0; i < 1000; ++i)
                  {
                    const Eigen::Vector3d point(0.01 * i - 5, 0.003 * i, 0.3);
                    known += accessor.stateAt(point).has_value() + accessor.probAt(point).has_value() +
                             accessor.at(point).has_value();
                    known += map.core().at(point, map.stateThresholds()).has_value();
                  }
                }),
            0U);
  EXPECT_EQ(allocationsOf(
                [&] {
                  accessor.visitBox({-20, -20, 0}, {20, 20, 9}, [&](const KnownCell&) { ++known; });
                }),
            0U);
  EXPECT_GT(known, 1000U);
  size_t met = 0;
  EXPECT_EQ(
      allocationsOf(
          [&]
          {
            mrpt::math::TPoint3D end;
            for (int i = 0; i < 100; ++i)
              met += map.castRay({0, 0, 0.3}, {std::cos(0.1 * i), std::sin(0.1 * i), 0}, end, i % 2 == 0, 20);
          }),
      0U);
  EXPECT_GT(met, 20U);
  const auto likelihoods = [&]
  {
    double sum = 0;
    for (int i = 0; i < 20; ++i)
      sum += map.computeObservationLikelihood(scan, mrpt::poses::CPose3D(0.03 * i, 0, 0, 0.01 * i, 0, 0));
    return sum;
  };
  const double fresh = likelihoods();
  EXPECT_EQ(allocationsOf([&] { (void)likelihoods(); }), 0U);
  // After an insertion, too: the terms are computed anew in their old places.
  map.insertObservation(scan, mrpt::poses::CPose3D(0.05, 0, 0, 0, 0, 0));
  const size_t beforeThem = allocations();
  const double after = likelihoods();
  EXPECT_EQ(allocations() - beforeThem, 0U);
  EXPECT_NE(after, fresh);
  EXPECT_EQ(TypeParam(map).computeObservationLikelihood(scan, {}),
            map.computeObservationLikelihood(scan, {}));
}

// The cache of the likelihood outlives changes of the map, but not of its cells' size.
TYPED_TEST(ReadingAllocations, ALikelihoodIsThatOfTheMapAsItIs)
{
  const auto scan = roomScan();
  const mrpt::poses::CPose3D pose(0.03, 0, 0, 0.01, 0, 0);
  TypeParam map;
  for (const double resolution : {0.1, 0.25, 0.1})
    for (const bool planar : {false, true})
    {
      typename TypeParam::TCreationOptions creation;
      creation.resolution = resolution;
      creation.planar = planar;
      TypeParam other(creation);
      map = other;
      const double empty = map.computeObservationLikelihood(scan, pose);
      other.insertObservation(scan);
      map = other;
      EXPECT_NE(map.computeObservationLikelihood(scan, pose), empty);
      EXPECT_EQ(map.computeObservationLikelihood(scan, pose), other.computeObservationLikelihood(scan, pose));
      map.clear();
      EXPECT_EQ(map.computeObservationLikelihood(scan, pose), empty);
    }
}
}  // namespace
}  // namespace lamap::test
