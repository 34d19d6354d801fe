// What a map of models lets in, from scans and from files: numbers in range, and no more work than it can do.
#include <gtest/gtest.h>
#include <lamap_core/overlapping/map.h>
#include <lamap_core/overlapping/model_fusion.h>
#include <support/posed_scans.h>
#include <support/seeds.h>

#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>

namespace lamap::test
{
namespace
{
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

/// A scan of rays in all directions.
Scan burst(double reach_m, int rays)
{
  Random random(7);
  RayFan fan;
  fan.centre = {0.03, 0.02, 0.05};
  for (int i = 0; i < rays; ++i) fan.addReturn(random.inCube(reach_m));
  Scan scan;
  scan.fans.push_back(fan);
  return scan;
}

double secondsOf(const std::function<void()>& work)
{
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

OverlappingOptions waitingFor(uint32_t scans)
{
  OverlappingOptions options;
  options.inference.scansPerModel = scans;
  options.inference.iterations = 2;
  return options;
}

TEST(OverlappingLimits, AScanThatCannotBeTrainedDoesNotWait)
{
  for (const bool planar : {false, true})
  {
    SCOPED_TRACE(planar);
    OverlappingOptions options = waitingFor(3);
    options.structure.planar = planar;
    // In the plane, rays hardly ever cross too many cells.
    const double reach_m = planar ? 0 : 1800;
    OverlappingHilbertMap map(options.structure);
    (void)map.insert(burst(1, 20), options.inference, nullptr, 1);
    const OverlappingHilbertMap before = map;
    if (reach_m > 0)
    {
      const double seconds = secondsOf(
          [&] {
            EXPECT_THROW((void)map.insert(burst(reach_m, 3000), options.inference, nullptr, 1),
                         std::length_error);
          });
      EXPECT_LT(seconds, 60) << "it is refused before masks of its blocks are made";
    }
    EXPECT_TRUE(map == before);
    EXPECT_TRUE(map.trainPending(options.inference, 1));
    EXPECT_EQ(map.modelCount(), 1u);
  }
}

TEST(OverlappingLimits, WaitingScansThatCannotBeTrainedAreDropped)
{
  if (shareOfCases() < 0.5) GTEST_SKIP() << "takes minutes with sanitizers; LAMAP_SEEDS=1 runs it";
  const OverlappingOptions options = waitingFor(3);
  OverlappingOptions coarse = options;
  coarse.structure.resolution = 10;
  coarse.structure.latticeSpacing = 5;
  coarse.structure.gamma = 0.01;
  OverlappingHilbertMap source(coarse.structure);
  (void)source.insert(burst(4000, 3000), coarse.inference, nullptr, 1);
  ASSERT_EQ(source.pending().scans.size(), 1u);
  OverlappingHilbertMap map(options.structure);
  PendingScans pending = source.pending();
  pending.pose = {};
  map.restore({}, pending);
  EXPECT_EQ(map.dropUntrainable(options.inference, 1), 1u);
  EXPECT_TRUE(map.empty());

  (void)map.insert(burst(1, 20), options.inference, nullptr, 1);
  EXPECT_EQ(map.dropUntrainable(options.inference, 1), 0u);
  EXPECT_EQ(map.pending().scans.size(), 1u);
}

TEST(OverlappingLimits, WhatIsSurelyTrainableIsTrained)
{
  Random random(3);
  for (const bool compact : {true, false})
  {
    OverlappingOptions options = waitingFor(2);
    if (!compact) options.structure.features = HilbertFeatures::Nystroem;
    OverlappingHilbertMap map(options.structure);
    (void)map.insert(roomScan(random, {}), options.inference, nullptr, 1);
    EXPECT_TRUE(isSurelyTrainable(map.pending(), map.structure(), options.inference));
    // Two scans that are fine by themselves may be too much together.
    PendingScans far = map.pending();
    ModelScan moved = far.scans.front();
    RayFan& fan = moved.rays.scan.fans.front();
    const Eigen::Vector3d by(3000, 3000, 3000);
    fan.centre += by;
    for (Ray& ray : fan.rays)
      if (ray.meaning == RayEnd::Return) ray.end += by;
    far.scans.push_back(moved);
    EXPECT_FALSE(isSurelyTrainable(far, map.structure(), options.inference));
  }
}

TEST(OverlappingLimits, KernelsThatReachTooManyCellsAreRefusedBeforeTheyAreListed)
{
  OverlappingOptions options;
  options.structure.features = HilbertFeatures::Nystroem;
  options.structure.components = 1400;
  options.structure.gamma = 1e-6;
  options.structure.resolution = 1;
  options.inference.iterations = 1;
  options.inference.freeResolution = 200;
  OverlappingHilbertMap map(options.structure);
  EXPECT_THROW((void)map.insert(burst(585, 1500), options.inference, nullptr, 1), std::length_error);
  EXPECT_TRUE(map.empty());

  // The same from a file, when the model is moved.
  OverlappingHilbertMap small(options.structure);
  (void)small.insert(burst(5, 20), options.inference, nullptr, 1);
  HilbertModel model = *small.models().front().model;
  model.inducing.resize(1400, model.inducing.front());
  model.kernelWeights.resize(1400, 0.5f);
  model.boxLow.setConstant(-600);
  model.boxHigh.setConstant(600);
  small.restore({{small.models().front().pose, std::make_shared<const HilbertModel>(model)}}, {});
  const OverlappingHilbertMap before = small;
  EXPECT_THROW(small.setModelPose(0, Eigen::Isometry3d::Identity(), {}, 1), std::length_error);
  EXPECT_TRUE(small == before);
}

/// What restore() says of models and waiting scans that were changed.
class Restored : public testing::Test
{
 protected:
  Restored()
  {
    Random random(5);
    options_ = waitingFor(2);
    options_.inference.rangeStd = 0.1;
    map_ = std::make_unique<OverlappingHilbertMap>(options_.structure);
    HilbertUncertainty uncertainty;
    uncertainty.pose.diagonal().setConstant(1e-4);
    for (int i = 0; i < 3; ++i)
      (void)map_->insert(roomScan(random, {}), options_.inference, i == 2 ? &uncertainty : nullptr, 1);
  }

  void expectModelRefused(const char* what, const std::function<void(HilbertModel&, ModelPose&)>& change)
  {
    PlacedModel placed = map_->models().front();
    HilbertModel model = *placed.model;
    change(model, placed.pose);
    placed.model = std::make_shared<const HilbertModel>(model);
    expectRefused(what, {placed}, map_->pending());
  }
  void expectScanRefused(const char* what, const std::function<void(PendingScans&)>& change)
  {
    PendingScans pending = map_->pending();
    change(pending);
    expectRefused(what, map_->models(), pending);
  }

  OverlappingOptions options_;
  std::unique_ptr<OverlappingHilbertMap> map_;

 private:
  void expectRefused(const char* what, std::vector<PlacedModel> models, PendingScans pending)
  {
    OverlappingHilbertMap map(options_.structure);
    EXPECT_THROW(map.restore(std::move(models), std::move(pending)), std::runtime_error) << what;
    EXPECT_TRUE(map.empty()) << what;
  }
};

TEST_F(Restored, WhatTheMapHadIsLetIn)
{
  OverlappingHilbertMap map(options_.structure);
  EXPECT_NO_THROW(map.restore(map_->models(), map_->pending()));
}

TEST_F(Restored, ModelsBeyondTheirFrameAreRefused)
{
  const double reach_m = 131072 * options_.structure.resolution;
  for (const double far : {kNan, kInf, -kInf, 1e300, 1e12, 1.01 * reach_m, -1.01 * reach_m})
    for (const int axis : {0, 2})
    {
      SCOPED_TRACE(far);
      expectModelRefused("box",
                         [&](HilbertModel& m, ModelPose&) { (far < 0 ? m.boxLow : m.boxHigh)[axis] = far; });
      expectModelRefused("offset", [&](HilbertModel&, ModelPose& pose) { pose.offset_m[axis] = far; });
      expectModelRefused(
          "hit", [&](HilbertModel& m, ModelPose&)
          { m.hits.assign(1, Eigen::Vector3d::Unit(axis).cast<float>() * static_cast<float>(far)); });
      if (!std::isfinite(far)) continue;  // refused with the image
      expectModelRefused("view",
                         [&](HilbertModel& m, ModelPose&)
                         {
                           DepthView::Image image = m.views.front().image();
                           image.sensor[axis] = far;
                           m.views.front() = DepthView::fromImage(image);
                         });
    }
  for (const float weight : {static_cast<float>(kNan), static_cast<float>(kInf), 1e30f, 0.0f})
    expectModelRefused("weight", [&](HilbertModel& m, ModelPose&) { m.sites.weights.back() = weight; });
  for (const int32_t block :
       {std::numeric_limits<int32_t>::max(), std::numeric_limits<int32_t>::min(), 1 << 20})
    expectModelRefused("site", [&](HilbertModel& m, ModelPose&)
                       { (block < 0 ? m.sites.blocks.front() : m.sites.blocks.back()).z = block; });
  for (const int32_t anchor : {std::numeric_limits<int32_t>::max(), std::numeric_limits<int32_t>::min()})
    expectModelRefused("anchor", [&](HilbertModel&, ModelPose& pose) { pose.anchor.y = anchor; });
  expectModelRefused("a view of a planar map",
                     [](HilbertModel& m, ModelPose&)
                     {
                       DepthView::Image image = m.views.front().image();
                       image.planar = true;
                       image.rows = 1;
                       image.firstRow = 0;
                       image.depths_m.resize(image.columns);
                       image.openShares.resize(size_t{5} * image.columns);
                       m.views.front() = DepthView::fromImage(image);
                     });
}

TEST_F(Restored, FieldsThatNoOptionAllowsAreRefused)
{
  DepthView::Image image = map_->models().front().model->views.front().image();
  for (double FieldRules::*length : {&FieldRules::near_m, &FieldRules::depth_m})
    for (const double bad : {kNan, kInf, -1.0, 1e7})
    {
      DepthView::Image changed = image;
      changed.rules.*length = bad;
      EXPECT_THROW((void)DepthView::fromImage(changed), std::runtime_error) << bad;
    }
}

TEST_F(Restored, WaitingScansThatInsertionWouldNotLeaveAreRefused)
{
  const auto fanOfFirst = [](PendingScans& pending) -> RayFan&
  { return pending.scans.front().rays.scan.fans.front(); };
  for (const double bad : {kNan, kInf, -kInf, 1e300, -1e12, 7000.0})
  {
    SCOPED_TRACE(bad);
    for (const int axis : {0, 1, 2})
    {
      expectScanRefused("centre", [&](PendingScans& p) { fanOfFirst(p).centre[axis] = bad; });
      expectScanRefused("first ray", [&](PendingScans& p) { fanOfFirst(p).rays.front().end[axis] = bad; });
      expectScanRefused("last ray", [&](PendingScans& p) { fanOfFirst(p).rays.back().end[axis] = bad; });
    }
  }
  for (const double bad : {kNan, kInf, -1.0, 1e300})
  {
    SCOPED_TRACE(bad);
    expectScanRefused("width", [&](PendingScans& p) { fanOfFirst(p).beam.halfWidth_rad = bad; });
    expectScanRefused("height", [&](PendingScans& p) { fanOfFirst(p).beam.halfHeight_rad = bad; });
    expectScanRefused("deviation", [&](PendingScans& p) { fanOfFirst(p).beam.rangeStd_m = bad; });
    if (bad != 1e300)
      expectScanRefused("range", [&](PendingScans& p) { fanOfFirst(p).statedRangeMax_m = bad; });
    const auto uncertaintyOf = [](PendingScans& p) -> HilbertUncertainty&
    { return *p.scans.front().uncertainty; };
    ASSERT_TRUE(map_->pending().scans.front().uncertainty.has_value());
    expectScanRefused("pose", [&](PendingScans& p) { uncertaintyOf(p).pose(4, 4) = bad; });
    expectScanRefused("asymmetric pose", [&](PendingScans& p) { uncertaintyOf(p).pose(0, 3) = bad; });
    expectScanRefused("point", [&](PendingScans& p) { uncertaintyOf(p).point(1, 1) = bad; });
    expectScanRefused("range deviation", [&](PendingScans& p) { uncertaintyOf(p).rangeStd_m = bad; });
    if (bad != -1.0)
      expectScanRefused("centre of rotation", [&](PendingScans& p) { uncertaintyOf(p).centre.x() = bad; });
  }
  expectScanRefused("axis", [&](PendingScans& p) { fanOfFirst(p).beam.up.z() = kNan; });
  expectScanRefused("a ray without length",
                    [&](PendingScans& p)
                    {
                      RayFan& fan = fanOfFirst(p);
                      Ray& ray = fan.rays.front();
                      ray.end = ray.meaning == RayEnd::Return ? fan.centre : Eigen::Vector3d::Zero();
                    });
  expectScanRefused("pose of the waiting scans", [&](PendingScans& p) { p.pose.offset_m.x() = 1e9; });
}

TEST(OverlappingLimits, AScanWithABeamThatNoFileMayHoldIsRefused)
{
  OverlappingHilbertMap map;
  for (const double bad : {kNan, kInf, -1.0, 1e300})
  {
    Scan scan = burst(1, 5);
    scan.fans.front().beam.rangeStd_m = bad;
    EXPECT_THROW((void)map.insert(scan, {}, nullptr, 1), std::invalid_argument) << bad;
    EXPECT_TRUE(map.empty());
  }
}

}  // namespace
}  // namespace lamap::test
