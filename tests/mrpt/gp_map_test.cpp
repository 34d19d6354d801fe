// What a GP map gives as an MRPT map.
#include <gtest/gtest.h>
#include <lamap_mrpt/maps/CGPMap.h>
#include <mrpt/maps/CSimplePointsMap.h>

#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include <support/golden_files.h>
#include <support/made_maps.h>
#include <support/small_maps.h>

namespace
{
using lamap::CGPMap;
using namespace lamap::test;
using mrpt::poses::CPose3D;

TEST(GpMrptMap, AliasAndClassNameMakeTheMap)
{
  for (const char* name : {"gpMap", "lamap::CGPMap"})
    EXPECT_EQ(made<CGPMap>({{"creationOpts.resolution", "0.3"}}, name).resolution(), 0.3);
}

TEST(GpMrptMap, IllegalOptionsAreRefusedByName)
{
  const auto complaint = [](const Settings& settings)
  {
    try
    {
      (void)made<CGPMap>(settings);
    }
    catch (const std::exception& error)
    {
      return std::string(error.what());
    }
    return std::string();
  };
  for (const auto& [name, text] : Settings{{"creationOpts.signalVariance", "0"},
                                           {"creationOpts.noiseVariance", "-1"},
                                           {"creationOpts.fusion", "kalman"},
                                           {"creationOpts.resolution", "nan"},
                                           {"creationOpts.squashGain", "0"},
                                           {"insertOpts.maxPoints", "5000"},
                                           {"insertOpts.kernelSupport", "50"},
                                           {"insertOpts.lengthScale", "0"},
                                           {"insertOpts.freeMargin", "10cm"},
                                           {"insertOpts.lenghtScale", "3"},
                                           {"insertOpts.freeThreshold", "0.9"}})
    EXPECT_NE(complaint({{name, text}}).find(name.substr(name.find('.') + 1)), std::string::npos)
        << name << " = " << text << ": " << complaint({{name, text}});
}

TEST(GpMrptMap, WallsAreOccupiedAndTheRoomIsFree)
{
  CGPMap map;
  for (const size_t rays : {181, 251, 199}) map.insertObservation(roomScan(rays));
  // The laser is at (0.1, 0, 0.3); the walls are 3.05 m ahead of it and 2.05 m beside.
  EXPECT_EQ(map.estimateAt({3.15, 0.0, 0.3})->state, lamap::CellState::Occupied);
  EXPECT_EQ(map.estimateAt({0.1, 2.05, 0.3})->state, lamap::CellState::Occupied);
  EXPECT_EQ(map.estimateAt({1.5, 0.3, 0.3})->state, lamap::CellState::Free);
  EXPECT_FALSE(map.estimateAt({1.5, 0.3, 3.0}));
  mrpt::math::TPoint3D end;
  ASSERT_TRUE(map.castRay({0.1, 0, 0.35}, {1, 0, 0}, end, false, 10.0)) << end;
  EXPECT_NEAR(end.x, 3.15, 0.35);
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
  EXPECT_EQ(map.evidenceNames(), (std::vector<std::string>{"precision", "mean"}));
  const auto cell = map.estimateAt({3.15, 0.0, 0.3});
  EXPECT_GT(cell->evidence[0], 151.0);  // counted up to maxEvidence, beside the prior's 1
  EXPECT_NEAR(*cell->variance, 1 / 151.0, 1e-12);
  EXPECT_GT(cell->evidence[1], 0.0);
}

TEST(GpMrptMap, TheTruePoseIsTheMostLikely)
{
  CGPMap map;
  for (const size_t rays : {181, 251, 199}) map.insertObservation(roomScan(rays));
  const double truth = map.computeObservationLikelihood(roomScan(), CPose3D());
  EXPECT_TRUE(std::isfinite(truth));
  for (const CPose3D& other :
       {CPose3D(0.6, 0, 0, 0, 0, 0), CPose3D(0, -0.6, 0, 0, 0, 0), CPose3D(0, 0, 0, 0.4, 0, 0)})
    EXPECT_LT(map.computeObservationLikelihood(roomScan(), other), truth) << other;
}

TEST(GpMrptMap, AnUpdatedVoxelIsAGpOfOnePoint)
{
  CGPMap map;
  map.updateVoxel(0.05, 0.05, 0.05, true);
  EXPECT_NEAR(map.estimateCell({0, 0, 0})->evidence[1], 1 / 1.05, 1e-6);
  map.updateVoxel(0.05, 0.05, 0.05, false);
  EXPECT_EQ(map.estimateCell({0, 0, 0})->prob, 0.5);
  EXPECT_THROW(map.updateVoxel(1e300, 0, 0, true), std::invalid_argument);
}

TEST(GpMrptMap, FilesOfOlderVersionsLoadAsTheyWereAndThoseOfTodaySaveToTheSameBytes)
{
  // What the files' maps said when they were written: number of cells, mean of f (log-odds) at a point.
  const mrpt::math::TPoint3D point(2.05, 0.35, 0.55);
  const std::vector<std::tuple<std::string, Settings, size_t, double>> written = {
      {"bcm",
       {{"insertOpts.maxRange", "4"}, {"insertOpts.usePoseCovariance", "false"}},
       8336,
       0.645214484963},
      {"bayes",
       {{"creationOpts.fusion", "bayes"},
        {"insertOpts.maxRange", "4"},
        {"insertOpts.usePoseCovariance", "false"}},
       8336,
       2.4724225998},
      {"thesis", {{"creationOpts.preset", "thesis"}, {"insertOpts.maxRange", "4"}}, 17320, 0.745535805338}};
  for (const auto& [name, settings, cells, evidence] : written)
  {
    SCOPED_TRACE(name);
    const auto loaded = goldenMapOf<CGPMap>("gpMap_v1_" + name, nullptr);
    ASSERT_TRUE(loaded);
    EXPECT_EQ(cellCount(*loaded), cells);
    const size_t last = loaded->evidenceNames().size() - 1;
    EXPECT_NEAR(loaded->estimateAt(point)->evidence.at(last), evidence, 1e-8);
    expectSavesTheSameAgain(*loaded);

    // What is learned today is what was learned when the newest file was written, on every processor.
    const auto today = taught<CGPMap>(settings);
    const auto newest = goldenMapOf("gpMap_v3_" + name, &today);
    ASSERT_TRUE(newest);
    EXPECT_TRUE(cellsOf(today) == cellsOf(*newest));
    expectSavesAs(*newest, "gpMap_v3_" + name);

    const auto older = goldenMapOf<CGPMap>("gpMap_v2_" + name, nullptr);
    ASSERT_TRUE(older);
    EXPECT_TRUE(cellsOf(today) == cellsOf(*older));
    EXPECT_EQ(older->creationOptions().maxEvidence, 0);
    expectSavesTheSameAgain(*older);
  }
}

}  // namespace
