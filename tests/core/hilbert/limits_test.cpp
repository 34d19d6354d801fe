// What a Hilbert map lets in: training sets that it can train on, and states that no question stumbles over.
#include <gtest/gtest.h>
#include <lamap_core/hilbert/map.h>
#include <support/hilbert_states.h>

#include <functional>
#include <limits>
#include <stdexcept>

namespace lamap::test
{
namespace
{
TEST(HilbertLimits, PointsThatCouldNotBeTrainedOnAreRefusedWhenTheyCome)
{
  HilbertStructure structure;
  structure.training = HilbertTraining::Batch;
  structure.features = HilbertFeatures::Nystroem;
  structure.components = 5000;
  HilbertState state;
  Random random(2);
  for (int i = 0; i < 200000; ++i)
  {
    HilbertState::Point point;
    point.place = random.inCube(3.0);
    state.points.push_back(point);
  }
  HilbertMap map(structure);
  map.restore(state);
  HilbertInference inference;
  inference.trainingPoints = HilbertPoints::Points;
  EXPECT_THROW((void)map.insert(roomScan(random, {0.1, 0.2, 0.1}, 30), inference, nullptr, 1),
               std::length_error);
  EXPECT_FALSE(map.isStale()) << "the next question trains nothing";
  EXPECT_EQ(differenceOf(map.state(), state), "");

  structure.components = 100;
  HilbertMap fewer(structure);
  fewer.restore(state);
  (void)fewer.insert(roomScan(random, {0.1, 0.2, 0.1}, 30), inference, nullptr, 1);
  EXPECT_TRUE(fewer.isStale());
}

// A weight below the smallest number that is stored is none: a map may have scans and nothing to learn from
// them.
TEST(HilbertLimits, WeightsThatAreTooSmallToCountAreNone)
{
  for (const HilbertStructure& structure : allHilbertStructures())
    for (const HilbertPoints points : {HilbertPoints::Cells, HilbertPoints::Points})
    {
      SCOPED_TRACE(nameOf(structure));
      HilbertInference inference;
      inference.trainingPoints = points;
      inference.hitWeight = inference.freeWeight = 1e-300;
      RayFan fan;
      fan.centre = {0.05, 0.05, 0.05};
      fan.addReturn({0.55, 0.35, 0.25});
      Scan scan;
      scan.fans.push_back(fan);
      HilbertMap map(structure);
      EXPECT_EQ(map.insert(scan, inference, nullptr, 1).hits, 1u);
      (void)map.logoddsAt({0.55, 0.35, 0.25});
      EXPECT_FALSE(map.isStale());
      map.visitCells(
          {}, [](const CellIndex&, const CellEstimate&) {}, 1);
      HilbertMap again(structure);
      again.restore(map.state());
      EXPECT_EQ(differenceOf(again.state(), map.state()), "");
      inference.hitWeight = 2;
      EXPECT_EQ(map.insert(scan, inference, nullptr, 1).hits, 1u);
      EXPECT_GT(map.logoddsAt({0.55, 0.35, 0.25}), 0);
    }
}

TEST(HilbertLimits, StatesThatNoMapCouldHaveAreRefused)
{
  Random random(4);
  for (HilbertStructure structure : allHilbertStructures())
  {
    SCOPED_TRACE(nameOf(structure));
    HilbertInference inference;
    inference.epochs = 1;
    HilbertMap map(structure);
    (void)map.insert(roomScan(random, {0.1, 0.2, 0.1}, 60), inference, nullptr, 1);
    const HilbertState good = map.state();
    const auto expectRefused = [&](const char* what, const std::function<void(HilbertState&)>& change)
    {
      HilbertState state = good;
      change(state);
      HilbertMap other(structure);
      EXPECT_THROW(other.restore(state), std::invalid_argument) << what;
      EXPECT_TRUE(other.empty()) << what;
    };
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    constexpr float kInf = std::numeric_limits<float>::infinity();
    for (const float bad : {kNan, kInf, -kInf, 1e30f, -3e38f})
    {
      expectRefused("mean", [&](HilbertState& s) { s.blocks.back().weights.back().mean = bad; });
      if (!good.classifier.empty())
        expectRefused("classifier", [&](HilbertState& s) { s.classifier.front() = bad; });
    }
    for (const float bad : {kNan, kInf, -1.0f})
      expectRefused("precision", [&](HilbertState& s) { s.blocks.front().weights.front().precision = bad; });
    if (structure.training == HilbertTraining::Incremental)
      expectRefused("no precision", [](HilbertState& s) { s.blocks.front().weights.front().precision = 0; });
    if (!good.inducing.empty())
      for (const double bad : {1e300, -1e12, static_cast<double>(kNan)})
        expectRefused("inducing point", [&](HilbertState& s) { s.inducing.back().y() = bad; });
    ASSERT_FALSE(good.seen.empty());
    for (const int32_t end : {std::numeric_limits<int32_t>::max(), std::numeric_limits<int32_t>::max() >> 3})
      expectRefused("seen cells", [&](HilbertState& s) { s.seen.back().index.z = end; });
    expectRefused("seen cells",
                  [](HilbertState& s) { s.seen.front().index.z = std::numeric_limits<int32_t>::min(); });
  }
}
}  // namespace
}  // namespace lamap::test
