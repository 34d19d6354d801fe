// What Hilbert maps of a long way weigh: 66 scans of some 5,000 points in a simulated corridor, cells of 0.1
// m.
#include <gtest/gtest.h>
#include <lamap_core/hilbert/map.h>
#include <lamap_core/hilbert/state.h>
#include <lamap_core/overlapping/map.h>
#include <lamap_sim/scanner.h>

namespace lamap::test
{
namespace
{
constexpr int kScans = 66;
constexpr double kRangeMax_m = 30.0;

std::vector<Scan> corridorScans()
{
  const sim::World world = sim::makeWorld("corridor", 7);
  sim::SensorModel sensor = sim::makeSensor("pan-tilt-laser");
  std::vector<Eigen::Vector3d> thinnedOut;
  for (size_t i = 0; i < sensor.beams.size(); i += 17) thinnedOut.push_back(sensor.beams[i]);
  sensor.beams = thinnedOut;
  EXPECT_GE(sensor.beams.size(), 5000u);
  const sim::Scanner scanner(world, sensor, {}, 7);
  const auto poses = sim::makeTrajectory(world, sensor, sim::Motion::Stops, kScans);
  std::vector<Scan> scans;
  for (size_t i = 0; i < poses.size(); ++i)
  {
    RayFan& fan = scans.emplace_back().fans.emplace_back();
    fan.centre = poses[i].position_map;
    const Eigen::Matrix3d rotation = sim::rotationOf(poses[i]);
    for (const sim::BeamReading& reading : scanner.scan(poses[i], i))
      fan.addReturn(fan.centre + rotation * reading.point_sensor);
  }
  return scans;
}

TEST(HilbertMemory, OneModelOfACorridorStaysBelow2MegabytesAnd4BytesPerCellThatRaysSaw)
{
  HilbertInference inference;
  inference.maxRange = kRangeMax_m;
  HilbertMap map;
  for (const Scan& scan : corridorScans()) ASSERT_GT(map.insert(scan, inference).hits, 4000u);
  EXPECT_GT(map.weightCount(), 100000u);  // it is the whole corridor
  EXPECT_GE(map.memoryBytes(), 8 * map.weightCount());
  EXPECT_LT(map.lattice().memoryBytes(), 2000000u);
  size_t seen = 0;
  for (const HilbertState::SeenBlock& block : map.state().seen) seen += block.hits.size();
  EXPECT_GT(seen, 500000u);
  EXPECT_LT(map.memoryBytes() - map.lattice().memoryBytes(), 4 * seen);
  RecordProperty("bytes", static_cast<int>(map.memoryBytes()));
}

TEST(HilbertMemory, KeptModelsStayBelow110KilobytesPerScan)
{
  OverlappingInference inference;
  inference.maxRange = kRangeMax_m;
  OverlappingHilbertMap map;
  for (const Scan& scan : corridorScans()) ASSERT_GT(map.insert(scan, inference).hits, 4000u);
  ASSERT_EQ(map.modelCount(), static_cast<size_t>(kScans));
  size_t kernels = 0;
  for (const PlacedModel& placed : map.models()) kernels += placed.model->kernelCount();
  EXPECT_GT(kernels, 66u * 5000);
  EXPECT_GE(map.modelBytes(), 4 * kernels);
  EXPECT_LT(map.modelBytes(), 110000u * kScans);
  RecordProperty("bytesAScan", static_cast<int>(map.modelBytes() / kScans));
}

}  // namespace
}  // namespace lamap::test
