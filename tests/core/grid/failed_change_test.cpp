// Changes of a map that fail half-way, for want of memory or because a sum would pass its limit.
#include <gtest/gtest.h>
#include <lamap_core/bgk/map.h>
#include <lamap_core/gp/map.h>
#include <lamap_core/hilbert/map.h>
#include <lamap_core/overlapping/map.h>
#include <support/hilbert_states.h>
#include <support/posed_scans.h>
#include <support/seeded_scans.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <functional>
#include <limits>
#include <new>
#include <stdexcept>

namespace
{
/// Allocations until one fails; negative: none will.
std::atomic<int64_t> allocationsLeft{-1};
std::atomic<size_t> bytesAsked{0};  ///< by all allocations so far
}  // namespace

void* operator new(size_t size)
{
  bytesAsked += size;
  if (allocationsLeft.load() >= 0 && allocationsLeft.fetch_sub(1) == 0) throw std::bad_alloc();
  if (void* memory = std::malloc(size > 0 ? size : 1)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept
{
  std::free(memory);
}
void operator delete(void* memory, size_t) noexcept
{
  std::free(memory);
}

namespace lamap::test
{
namespace
{
bool isSame(const BgkMap& a, const BgkMap& b)
{
  return a.evidence() == b.evidence();
}
bool isSame(const GpMap& a, const GpMap& b)
{
  return a.evidence() == b.evidence();
}
bool isSame(const HilbertMap& a, const HilbertMap& b)
{
  return differenceOf(a.state(), b.state()).empty();
}
bool isSame(const OverlappingHilbertMap& a, const OverlappingHilbertMap& b)
{
  return a == b && a.pending().pose == b.pending().pose;
}

/// How many allocations of a change are let fail, spread over all of them. A sanitized build takes a hundred
/// times as long and looks for other faults.
#ifdef LAMAP_SANITIZED
constexpr int64_t kMostTries = 8;
#else
constexpr int64_t kMostTries = std::numeric_limits<int64_t>::max();
#endif

/** Lets the first allocation of a change fail, then the second, and so on until the change is done.
 * @param stride of the sweep, e.g. because a change takes many allocations */
template <typename Map>
void expectAllOrNothing(const Map& before, const std::function<void(Map&)>& change, int64_t stride = 1)
{
  Map expected = before;
  constexpr int64_t kNoneFails = std::numeric_limits<int64_t>::max();
  allocationsLeft = kNoneFails;
  change(expected);
  const int64_t allocations = kNoneFails - allocationsLeft.exchange(-1);
  ASSERT_FALSE(isSame(expected, before));
  stride = std::max(stride, allocations / kMostTries);
  for (int64_t failing = 0, tries = 0;; failing += stride, ++tries)
  {
    Map map = before;
    bool failed = false;
    allocationsLeft = failing;
    try
    {
      change(map);
    }
    catch (const std::bad_alloc&)
    {
      failed = true;
    }
    const bool tried = allocationsLeft.exchange(-1) < 0;
    ASSERT_EQ(failed, tried) << "allocation " << failing << " failed and nobody was told";
    ASSERT_TRUE(isSame(map, failed ? before : expected)) << "allocation " << failing;
    if (!failed)
    {
      EXPECT_GT(failing, 0);
      return;
    }
    // What failed once may be tried again.
    if (tries % 7 != 0) continue;
    change(map);
    ASSERT_TRUE(isSame(map, expected)) << "again after allocation " << failing;
  }
}

ScanRecipe smallScan()
{
  ScanRecipe recipe;
  recipe.halfEdge_m = 0.5;
  recipe.rays = 8;
  recipe.fans = 1;
  return recipe;
}

constexpr Pruning kPrunings[] = {Pruning::None, Pruning::Lossless, Pruning::State};

template <typename Map, typename Structure, typename Inference>
void expectScansAndMergesAreAllOrNothing(Structure structure, const Inference& inference)
{
  Random random(5);
  const Scan first = randomScan(random, smallScan());
  const Scan second = randomScan(random, smallScan());
  for (const Pruning pruning : kPrunings)
    for (const unsigned threads : {1u, 2u})
    {
      SCOPED_TRACE(testing::Message() << "pruning " << static_cast<int>(pruning) << ", threads " << threads);
      structure.pruning = pruning;
      Map map(structure), other(structure);
      const auto insert = [&](const Scan& scan)
      { return [&, threads](Map& changed) { (void)changed.insert(scan, inference, threads); }; };
      expectAllOrNothing<Map>(map, insert(first));
      insert(first)(map);
      insert(second)(other);
      expectAllOrNothing<Map>(map, insert(first));   // no cell is new
      expectAllOrNothing<Map>(map, insert(second));  // some are
      if (threads == 1) expectAllOrNothing<Map>(map, [&](Map& changed) { changed.merge(other, {}); });
    }
}

TEST(FailedChange, LeavesABgkMapAsItWas)
{
  expectScansAndMergesAreAllOrNothing<BgkMap>(BgkStructure{}, BgkInference{});
  BgkMap map;
  expectAllOrNothing<BgkMap>(map, [](BgkMap& changed) { changed.addEvidence({1, 2, 3}, 1, 2, {}); });
}

TEST(FailedChange, LeavesAGpMapAsItWas)
{
  GpInference nested;
  nested.nested = true;
  expectScansAndMergesAreAllOrNothing<GpMap>(GpStructure{}, GpInference{});
  expectScansAndMergesAreAllOrNothing<GpMap>(GpStructure{}, nested);
  GpMap map;
  expectAllOrNothing<GpMap>(map, [](GpMap& changed) { changed.addObservation({1, 2, 3}, true, {}); });
}

TEST(FailedChange, LeavesAHilbertMapAsItWas)
{
  Random random(3);
  const Scan first = roomScan(random, RoomRecipe{}), second = roomScan(random, RoomRecipe{});
  HilbertInference inference;
  inference.epochs = 1;
  inference.iterations = 1;
  const auto insert = [&](const Scan& scan)
  { return [&](HilbertMap& map) { (void)map.insert(scan, inference, nullptr, 1); }; };
  constexpr int64_t kStride = 5;
  for (HilbertStructure structure : allHilbertStructures())
    for (const HilbertPoints points : {HilbertPoints::Cells, HilbertPoints::Points})
    {
      SCOPED_TRACE(nameOf(structure) + (points == HilbertPoints::Cells ? ", cells" : ", points"));
      structure.resolution = 0.2;
      structure.latticeSpacing = 0.4;
      structure.gamma = 5.0;
      inference.trainingPoints = points;
      HilbertMap map(structure);
      expectAllOrNothing<HilbertMap>(map, insert(first), kStride);
      insert(first)(map);
      expectAllOrNothing<HilbertMap>(map, insert(second), kStride);
    }
}

TEST(FailedChange, LeavesAnOverlappingHilbertMapAsItWas)
{
  Random random(3);
  OverlappingOptions options;
  options.structure.resolution = 0.2;
  options.structure.latticeSpacing = 0.4;
  options.structure.gamma = 5.0;
  options.inference.iterations = 1;
  const Scan first = roomScan(random, {}), second = roomScan(random, {});
  using Map = OverlappingHilbertMap;
  const auto insert = [&](const Scan& scan, unsigned threads)
  { return [&, threads](Map& map) { (void)map.insert(scan, options.inference, nullptr, threads); }; };
  constexpr int64_t kStride = 5;
  for (const Pruning pruning : kPrunings)
  {
    SCOPED_TRACE(static_cast<int>(pruning));
    options.structure.pruning = pruning;
    options.inference.scansPerModel = 1;
    Map map(options.structure), other(options.structure);
    expectAllOrNothing<Map>(map, insert(first, 1), kStride);
    insert(first, 1)(map);
    insert(second, 1)(other);
    expectAllOrNothing<Map>(map, insert(second, 2), kStride);
    other.addEvidence({1, 1, 1}, 0.5, {});
    expectAllOrNothing<Map>(map, [&](Map& changed) { changed.merge(other, {}); });
    expectAllOrNothing<Map>(map, [&](Map& changed) { changed.addEvidence({1, 1, 1}, -2, {}); });
    insert(second, 1)(map);
    map.addEvidence({0, 0, 0}, 0.75, {});
    expectAllOrNothing<Map>(
        map,
        [&](Map& changed)
        {
          changed.setModelPoses(
              {{0, Eigen::Isometry3d(second.sensorPose_map)}, {1, Eigen::Isometry3d(first.sensorPose_map)}},
              {}, 1);
        },
        kStride);

    // Scans that wait, and the one that ends the waiting.
    options.inference.scansPerModel = 2;
    Map waiting(options.structure);
    expectAllOrNothing<Map>(waiting, insert(first, 1), kStride);
    insert(first, 1)(waiting);
    expectAllOrNothing<Map>(waiting, insert(second, 1), kStride);
    expectAllOrNothing<Map>(
        waiting, [&](Map& changed) { (void)changed.trainPending(options.inference, 1); }, kStride);
  }
}

/// Rays that together cross far too many cells of a map.
Scan longScan()
{
  Random random(3);
  Scan scan;
  RayFan& fan = scan.fans.emplace_back();
  for (int i = 0; i < 3000; ++i)
    fan.addReturn({random.uniform(-1800, 1800), random.uniform(-1800, 1800), random.uniform(-1800, 1800)});
  return scan;
}

template <typename Map, typename Inference>
void expectRefusedInLittleMemory(Map map, const Inference& inference)
{
  const Scan scan = longScan();
  const size_t before = bytesAsked;
  EXPECT_THROW((void)map.insert(scan, inference, nullptr, 1), std::length_error);
  EXPECT_LT(bytesAsked - before, size_t{64} << 20);
}

TEST(TooLongScan, IsRefusedInLittleMemory)
{
  expectRefusedInLittleMemory(HilbertMap(HilbertStructure{}.resolved()), HilbertInference{});
  expectRefusedInLittleMemory(OverlappingHilbertMap(OverlappingStructure{}.resolved()),
                              OverlappingInference{});
  OverlappingInference waits;
  waits.scansPerModel = 2;
  expectRefusedInLittleMemory(OverlappingHilbertMap(OverlappingStructure{}.resolved()), waits);
  const size_t before = bytesAsked;
  EXPECT_THROW((void)BgkMap().insert(longScan(), {}, 1), std::length_error);
  EXPECT_THROW((void)GpMap().insert(longScan(), {}, 1), std::length_error);
  EXPECT_LT(bytesAsked - before, size_t{128} << 20);
}

TEST(FailedChange, LeavesAMapWhoseSumsWouldOverflowAsItWas)
{
  Random random(7);
  for (const Pruning pruning : kPrunings)
  {
    BgkStructure structure;
    structure.pruning = pruning;
    BgkMap map(structure);
    (void)map.insert(randomScan(random, smallScan()), {}, 1);
    for (int i = 0; i < 8; ++i) map.addEvidence({0, 0, 0}, 1e12, 0, {});
    const BgkMap before = map;
    EXPECT_THROW(map.addEvidence({0, 0, 0}, 1e12, 0, {}), std::overflow_error);
    EXPECT_TRUE(isSame(map, before));
    EXPECT_THROW(map.merge(before, {}), std::overflow_error);
    EXPECT_TRUE(isSame(map, before));
  }
  GpMap map;
  (void)map.insert(randomScan(random, smallScan()), {}, 1);
  for (int doublings = 0; doublings < 60; ++doublings)
  {
    const GpMap before = map;
    try
    {
      map.merge(before, {});
    }
    catch (const std::overflow_error&)
    {
      EXPECT_TRUE(isSame(map, before));
      return;
    }
  }
  FAIL() << "sums grow without limit";
}

}  // namespace
}  // namespace lamap::test
