// What both kinds of Hilbert maps give as MRPT maps.
#include <gtest/gtest.h>
#include <lamap_core/hilbert/state.h>
#include <lamap_mrpt/maps/CHilbertMap.h>
#include <lamap_mrpt/maps/COverlappingHilbertMap.h>
#include <lamap_mrpt/maps/uncertain_inputs.h>
#include <lamap_mrpt/observations/pose_covariance.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <support/golden_files.h>
#include <support/made_maps.h>
#include <support/small_maps.h>

namespace
{
using lamap::CHilbertMap;
using lamap::COverlappingHilbertMap;
using namespace lamap::test;
using mrpt::poses::CPose3D;

/// Kinds of maps that files hold differently.
template <typename Map>
std::vector<Settings> kinds();

template <>
std::vector<Settings> kinds<CHilbertMap>()
{
  const std::string training = "creationOpts.training";
  const std::string features = "creationOpts.features";
  return {{},
          {{"creationOpts.planar", "true"}},
          {{"creationOpts.preset", "thesis"}},
          {{training, "batch"}},
          {{training, "batch"}, {"insertOpts.trainingPoints", "points"}, {"insertOpts.rangeStd", "0.1"}},
          {{training, "sgd"}},
          {{training, "sgd"}, {features, "nystroem"}}};
}

template <>
std::vector<Settings> kinds<COverlappingHilbertMap>()
{
  return {{},
          {{"creationOpts.planar", "true"}},
          {{"creationOpts.preset", "thesis"}},
          {{"creationOpts.keepModels", "false"}},
          {{"creationOpts.pruning", "state"}},
          {{"insertOpts.scansPerModel", "3"}},
          {{"insertOpts.scansPerModel", "3"}, {"insertOpts.rangeStd", "0.1"}}};
}

template <typename Map>
class HilbertMaps : public testing::Test
{
};
using Both = testing::Types<CHilbertMap, COverlappingHilbertMap>;
TYPED_TEST_SUITE(HilbertMaps, Both);

TYPED_TEST(HilbertMaps, AliasAndClassNameMakeTheMap)
{
  const TypeParam byAlias = made<TypeParam>({{"creationOpts.resolution", "0.3"}});
  EXPECT_EQ(byAlias.resolution(), 0.3);
  const std::string className = TypeParam().GetRuntimeClass()->className;
  EXPECT_EQ(made<TypeParam>({{"creationOpts.resolution", "0.3"}},
                            "lamap::" + className.substr(className.rfind(':') + 1))
                .resolution(),
            0.3);
}

TYPED_TEST(HilbertMaps, IllegalAndContradictingOptionsAreRefusedByName)
{
  const auto complaint = [](const Settings& settings)
  {
    try
    {
      (void)made<TypeParam>(settings);
    }
    catch (const std::exception& error)
    {
      return std::string(error.what());
    }
    return std::string();
  };
  for (const auto& [name, text] : Settings{{"creationOpts.gamma", "-1"},
                                           {"creationOpts.resolution", "nan"},
                                           {"creationOpts.latticeSpacing", "0"},
                                           {"creationOpts.latticeSpacing", "5"},
                                           {"creationOpts.components", "0"},
                                           {"insertOpts.iterations", "0"},
                                           {"insertOpts.hitWeight", "0"},
                                           {"insertOpts.solver", "newton"},
                                           {"insertOpts.freeMargin", "10cm"},
                                           {"insertOpts.maxRannge", "3"},
                                           {"insertOpts.freeThreshold", "0.9"},
                                           {"creationOpts.latticeSpacing", "0.01"}})
    EXPECT_NE(complaint({{name, text}}).find(name.substr(name.find('.') + 1)), std::string::npos)
        << name << " = " << text << ": " << complaint({{name, text}});
}

TYPED_TEST(HilbertMaps, WallsAreOccupiedAndTheRoomIsFree)
{
  TypeParam map = made<TypeParam>();
  for (const size_t rays : {181, 251, 199}) map.insertObservation(roomScan(rays));
  // The laser is at (0.1, 0, 0.3); the walls are 3.05 m ahead of it and 2.05 m beside.
  EXPECT_EQ(map.estimateAt({3.15, 0.0, 0.3})->state, lamap::CellState::Occupied);
  EXPECT_EQ(map.estimateAt({0.1, 2.05, 0.3})->state, lamap::CellState::Occupied);
  EXPECT_EQ(map.estimateAt({1.5, 0.3, 0.3})->state, lamap::CellState::Free);
  EXPECT_FALSE(map.estimateAt({1.5, 0.3, 3.0}));
  mrpt::math::TPoint3D end;
  ASSERT_TRUE(map.castRay({0.1, 0, 0.35}, {1, 0, 0}, end, false, 10.0)) << end;
  EXPECT_NEAR(end.x, 3.15, 0.35);
  double prob = 0;
  ASSERT_TRUE(map.getPointOccupancy(1.5F, 0.3F, 0.3F, prob));
  EXPECT_LT(prob, 0.3);

  // Not on the stack: MRPT's own alignment of it differs from the compiler's.
  const auto cubes = mrpt::opengl::COctoMapVoxels::Create();
  map.getAsOctoMapVoxels(*cubes);
  EXPECT_GT(cubes->getVoxelCount(mrpt::opengl::VOXEL_SET_OCCUPIED), 50U);
  mrpt::maps::CSimplePointsMap points;
  points.insertObservation(roomScan());
  mrpt::maps::TMatchingRatioParams params;
  params.maxDistForCorr = 0.3F;
  EXPECT_GT(map.compute3DMatchingRatio(&points, CPose3D(), params), 0.9F);
  EXPECT_LT(map.compute3DMatchingRatio(&points, CPose3D(0.8, 0.8, 0, 0, 0, 0), params), 0.5F);
}

TYPED_TEST(HilbertMaps, TheTruePoseIsTheMostLikely)
{
  TypeParam map = made<TypeParam>();
  for (const size_t rays : {181, 251, 199}) map.insertObservation(roomScan(rays));
  const double truth = map.computeObservationLikelihood(roomScan(), CPose3D());
  EXPECT_TRUE(std::isfinite(truth));
  for (const CPose3D& other :
       {CPose3D(0.6, 0, 0, 0, 0, 0), CPose3D(0, -0.6, 0, 0, 0, 0), CPose3D(0, 0, 0, 0.4, 0, 0)})
    EXPECT_LT(map.computeObservationLikelihood(roomScan(), other), truth) << other;
}

TYPED_TEST(HilbertMaps, ScansThatTeachLittleGiveFiniteMaps)
{
  lamap::Scan scan;
  lamap::RayFan& fan = scan.fans.emplace_back();
  fan.centre = {0, 0, 0.5};
  std::vector<lamap::Scan> scans;
  fan.addReturn({1, 0, 0.5});
  scans.push_back(scan);  // a single point
  fan.rays.assign(50, fan.rays.front());
  scans.push_back(scan);  // all at one place
  fan.rays = {{{1, 0, 0}, lamap::RayEnd::NoReturn, 0}, {{0, 1, 0}, lamap::RayEnd::NoReturn, 0}};
  fan.statedRangeMax_m = 2;
  scans.push_back(scan);  // free space only
  for (Settings settings : kinds<TypeParam>())
  {
    settings.emplace_back("insertOpts.freeMargin", "0");
    for (const lamap::Scan& each : scans)
    {
      TypeParam map = made<TypeParam>(settings);
      map.insertScan(each);
      map.insertScan(each);
      map.visitCells([](const lamap::CellIndex&, const lamap::CellEstimate& estimate)
                     { ASSERT_TRUE(estimate.prob >= 0 && estimate.prob <= 1) << estimate.prob; });
    }
  }
}

// As for every other map: what stands nowhere is counted and left out, and the program goes on.
TYPED_TEST(HilbertMaps, ScansFromNowhereAreLeftOut)
{
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  TypeParam map = taught<TypeParam>({{"insertOpts.usePoseCovariance", "true"}});
  const auto before = bytesOf(map);
  for (const CPose3D& nowhere :
       {CPose3D(kNaN, 0, 0, 0, 0, 0), CPose3D(1e30, 0, 0, 0, 0, 0), CPose3D(0, 0, 0, kNaN, 0, 0)})
  {
    EXPECT_FALSE(map.insertObservation(roomScan(61), nowhere)) << nowhere;
    EXPECT_FALSE(map.insertObservationAt(roomScan(61), mrpt::poses::CPose3DPDFGaussian(nowhere))) << nowhere;
  }
  EXPECT_EQ(bytesOf(map), before);
}

TYPED_TEST(HilbertMaps, ZeroCovarianceIsACertainPose)
{
  TypeParam certain = made<TypeParam>();
  TypeParam zero = made<TypeParam>({{"insertOpts.usePoseCovariance", "true"}});
  certain.insertObservation(roomScan(61), kSecondPose);
  zero.insertObservationAt(roomScan(61), mrpt::poses::CPose3DPDFGaussian(kSecondPose));
  ASSERT_EQ(cellCount(zero), cellCount(certain));
  certain.visitCells([&](const lamap::CellIndex& cell, const lamap::CellEstimate& estimate)
                     { ASSERT_EQ(zero.estimateCell(cell)->prob, estimate.prob); });
}

// A turn about the vertical by σ moves a point at distance d sideways by σ·d.
/// Of the points of a sensor that is anywhere on the robot.
lamap::HilbertUncertainty uncertaintyAt(const mrpt::poses::CPose3DPDFGaussian& robot,
                                        const Eigen::Vector3d& sensor_map)
{
  lamap::HilbertUncertainty uncertainty;
  uncertainty.pose = lamap::covarianceOfSensor(robot, sensor_map);
  uncertainty.centre = sensor_map;
  return uncertainty;
}

TEST(UncertainInputs, ATurnOfTheRobotSpreadsFarPointsSideways)
{
  mrpt::poses::CPose3DPDFGaussian pose(CPose3D(1, 2, 0, 0.5, 0, 0));
  pose.cov(3, 3) = 0.01;
  const auto uncertainty = uncertaintyAt(pose, {1, 2, 0});
  const Eigen::Vector3d point =
      Eigen::Vector3d(1, 2, 0) + 4.0 * Eigen::Vector3d(std::cos(0.5), std::sin(0.5), 0);
  const Eigen::Matrix3d covariance = uncertainty.of(point, {1, 2, 0});
  const Eigen::Vector3d side(-std::sin(0.5), std::cos(0.5), 0);
  EXPECT_NEAR(side.dot(covariance * side), 0.01 * 16, 1e-9);
  EXPECT_NEAR(covariance.trace(), 0.01 * 16, 1e-9);
}

// With MRPT's own composition: perturb each of the six numbers a little.
TEST(UncertainInputs, FollowsMrptsAnglesToFirstOrder)
{
  const std::array<double, 6> mean = {1, -2, 0.5, 0.7, -0.4, 0.3};
  const auto poseAt = [](const std::array<double, 6>& p)
  { return CPose3D(p[0], p[1], p[2], p[3], p[4], p[5]); };
  const mrpt::math::TPoint3D inRobot(2.0, -1.0, 0.5);
  const auto pointAt = [&](const std::array<double, 6>& p)
  {
    const auto point = poseAt(p).composePoint(inRobot);
    return Eigen::Vector3d(point.x, point.y, point.z);
  };
  for (size_t i = 0; i < 6; ++i)
  {
    mrpt::poses::CPose3DPDFGaussian pose(poseAt(mean));
    pose.cov(static_cast<int>(i), static_cast<int>(i)) = 0.01;
    auto forward = mean;
    auto backward = mean;
    forward[i] += 1e-6;
    backward[i] -= 1e-6;
    const Eigen::Vector3d slope = (pointAt(forward) - pointAt(backward)) / 2e-6;
    const Eigen::Matrix3d due = 0.01 * slope * slope.transpose();
    const Eigen::Matrix3d covariance = uncertaintyAt(pose, {3, 1, 0.25}).of(pointAt(mean), {1, -2, 0.5});
    EXPECT_LT((covariance - due).norm(), 1e-8) << "of number " << i << "\n" << covariance << "\n" << due;
  }
}

TEST(HilbertMrptMap, CellsCannotBeWritten)
{
  CHilbertMap map;
  EXPECT_THROW(map.updateVoxel(0, 0, 0, true), std::logic_error);
}

TEST(HilbertMrptMap, SaysHowManyTrainingPointsItKeeps)
{
  for (const bool batch : {false, true})
  {
    CHilbertMap map =
        made<CHilbertMap>({{"creationOpts.training", batch ? "batch" : "incremental"}}, "hilbertMap");
    map.insertRay(1, 0.2F, 0.1F, 0, 0, 0);
    EXPECT_EQ(map.asString().find("training points") != std::string::npos, batch) << map.asString();
  }
}

TEST(HilbertMrptMap, AnUncertainPlaceIsNearerToOneHalf)
{
  CHilbertMap map;
  for (const size_t rays : {181, 251, 199}) map.insertObservation(roomScan(rays));
  const mrpt::math::TPoint3D wall(3.15, 0.0, 0.3);
  mrpt::math::CMatrixDouble33 covariance;
  covariance.setZero();
  const double certain = *map.expectedLogoddsAt(wall, covariance);
  EXPECT_NEAR(certain, map.estimateAt(wall)->evidence[0], 1e-3);
  covariance(0, 0) = 0.09;
  EXPECT_LT(*map.expectedLogoddsAt(wall, covariance), certain);
}

TEST(OverlappingMrptMap, AMovedModelIsThatOfAMapBuiltThere)
{
  COverlappingHilbertMap moved;
  COverlappingHilbertMap rebuilt;
  const CPose3D corrected(0.45, 0.15, 0.1, 0.62, 0.02, -0.03);
  moved.insertObservation(roomScan(), CPose3D());
  moved.insertObservation(roomScan(61), kSecondPose);
  rebuilt.insertObservation(roomScan(), CPose3D());
  rebuilt.insertObservation(roomScan(61), corrected);
  ASSERT_EQ(moved.modelCount(), 2U);
  const CPose3D sensorInRobot = roomScan().sensorPose;
  const CPose3D before = moved.modelPose(1);
  EXPECT_LT((before - (kSecondPose + sensorInRobot)).norm(), 1e-6);
  moved.setModelPose(1, corrected + sensorInRobot);
  ASSERT_GT(cellCount(moved), 1000U);
  size_t differ = 0;
  rebuilt.visitCells(
      [&](const lamap::CellIndex& cell, const lamap::CellEstimate& estimate)
      {
        const auto other = moved.estimateCell(cell);
        differ += !other || std::abs(other->prob - estimate.prob) > 1e-3;
      });
  // The rays of the rebuilt map went through the map's frame: few cells stand on an edge of rounding.
  EXPECT_LT(differ, cellCount(rebuilt) / 200);
  EXPECT_THROW(moved.setModelPose(2, corrected), std::out_of_range);
}

TEST(OverlappingMrptMap, ScansThatWaitAreRead)
{
  const auto map = taught<COverlappingHilbertMap>({{"insertOpts.scansPerModel", "3"}});
  EXPECT_EQ(map.modelCount(), 0U);
  EXPECT_FALSE(map.isEmpty());
  EXPECT_GT(cellCount(map), 1000U);
  const auto facts = map.facts();
  EXPECT_TRUE(std::any_of(facts.begin(), facts.end(),
                          [](const auto& fact)
                          { return fact.name == "scans that wait for others" && fact.text() == "2"; }));
}

TEST(OverlappingMrptMap, AnUpdatedVoxelTakesOneHitOrOneFreePoint)
{
  COverlappingHilbertMap map;
  map.updateVoxel(0.05, 0.05, 0.05, true);
  EXPECT_NEAR(map.estimateCell({0, 0, 0})->evidence[0], 0.6 * 2, 1e-5);
  map.updateVoxel(0.05, 0.05, 0.05, false);
  EXPECT_NEAR(map.estimateCell({0, 0, 0})->evidence[0], 0.6 * 1, 1e-5);
  EXPECT_THROW(map.updateVoxel(1e300, 0, 0, true), std::invalid_argument);
}

TYPED_TEST(HilbertMaps, FilesOfOlderVersionsLoadAsTheyWereAndThoseOfTodaySaveToTheSameBytes)
{
  // What the files' maps said when they were written: number of cells, log-odds at a point.
  const mrpt::math::TPoint3D point(2.05, 0.35, 0.55);
  const std::vector<std::pair<size_t, double>> written =
      std::is_same_v<TypeParam, CHilbertMap>
          ? std::vector<std::pair<size_t, double>>{{114930, 0.11289191246}, {114515, -17.1270236969}}
          : std::vector<std::pair<size_t, double>>{{48343, 0.61385154724}, {9022, 10.22592163086}};
  size_t number = 0;
  for (const Settings& settings : {Settings{}, Settings{{"creationOpts.preset", "thesis"}}})
  {
    // Options of today are part of the files: they are compared as they were stored.
    const std::string ending = std::to_string(number);
    const auto loaded = goldenMapOf<TypeParam>(aliasOf<TypeParam>() + "_v1_" + ending, nullptr);
    ASSERT_TRUE(loaded);
    EXPECT_EQ(cellCount(*loaded), written.at(number).first);
    EXPECT_NEAR(loaded->estimateAt(point)->evidence[0], written.at(number).second, 1e-5);
    expectSavesTheSameAgain(*loaded);

    Settings uncertain = settings;
    uncertain.emplace_back("insertOpts.usePoseCovariance", "true");
    const TypeParam today = taught<TypeParam>(uncertain);
    const std::string newestName = aliasOf<TypeParam>() + "_v4_" + ending;
    const auto newest = goldenMapOf(newestName, &today);
    ASSERT_TRUE(newest);
    EXPECT_EQ(cellCount(*newest), cellCount(today));
    expectSavesAs(*newest, newestName);

    const auto older = goldenMapOf<TypeParam>(aliasOf<TypeParam>() + "_v3_" + ending, nullptr);
    ASSERT_TRUE(older);
    EXPECT_EQ(cellCount(*older), cellCount(taught<TypeParam>(settings)));
    EXPECT_EQ(older->likelihoodOptions.freeBefore, 0);
    expectSavesTheSameAgain(*older);
    ++number;
  }
}

TEST(HilbertMrptMap, VotesOfFilesOfVersion2AreHits)
{
  for (const std::string name : {"0", "1"})
  {
    const auto loaded = goldenMapOf<CHilbertMap>("hilbertMap_v2_" + name, nullptr);
    ASSERT_TRUE(loaded) << name;
    EXPECT_GT(cellCount(*loaded), 20000U);
    const lamap::HilbertState state = loaded->core().state();
    EXPECT_EQ(state.seen.empty(), name == "1");
    for (const lamap::HilbertState::SeenBlock& block : state.seen)
      for (size_t i = 0; i < block.hits.size(); ++i)
      {
        EXPECT_GE(block.hits[i], 8);
        EXPECT_EQ(block.passes[i], 0);
      }
    expectSavesTheSameAgain(*loaded);
  }
}

TEST(OverlappingMrptMap, ModelsOfFilesOfVersion3AreAskedSharp)
{
  for (const std::string name : {"0", "1"})
  {
    const auto loaded = goldenMapOf<COverlappingHilbertMap>("overlappingHilbertMap_v3_" + name, nullptr);
    ASSERT_TRUE(loaded) << name;
    EXPECT_GT(loaded->core().modelCount(), 0U);
    for (const lamap::PlacedModel& placed : loaded->core().models()) EXPECT_EQ(placed.model->variance, 0);
    expectSavesTheSameAgain(*loaded);
  }
}

TEST(OverlappingMrptMap, FilesOfVersion2LoadWithTheScansThatWait)
{
  for (const std::string name : {"0", "1", "waiting"})
  {
    const auto loaded = goldenMapOf<COverlappingHilbertMap>("overlappingHilbertMap_v2_" + name, nullptr);
    ASSERT_TRUE(loaded) << name;
    EXPECT_GT(cellCount(*loaded), 1000U);
    EXPECT_EQ(loaded->core().pending().scans.size(), name == "waiting" ? 2U : 0U);
    expectSavesTheSameAgain(*loaded);
  }
}
}  // namespace
