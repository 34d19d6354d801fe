// What a GP map gives as an MRPT map.
#include <gtest/gtest.h>
#include <lamap_mrpt/files/map_file.h>
#include <lamap_mrpt/maps/CGPMap.h>
#include <mrpt/maps/CSimplePointsMap.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <memory>

#include <support/golden_files.h>
#include <support/made_maps.h>
#include <support/small_maps.h>

namespace
{
using lamap::CGPMap;
using namespace lamap::test;
using mrpt::poses::CPose3D;

/// Every option, none of them at its default.
Settings allOtherOptions()
{
  return {{"creationOpts.preset", "la3dm"},
          {"creationOpts.resolution", "0.125"},
          {"creationOpts.blockDepth", "4"},
          {"creationOpts.pruning", "state"},
          {"creationOpts.planar", "true"},
          {"creationOpts.planarHeight", "0.5"},
          {"creationOpts.fusion", "bayes"},
          {"creationOpts.signalVariance", "2"},
          {"creationOpts.noiseVariance", "0.25"},
          {"creationOpts.squashGain", "3"},
          {"creationOpts.minVariance", "0.125"},
          {"insertOpts.nested", "true"},
          {"insertOpts.freeSpace", "none"},
          {"insertOpts.freeResolution", "0.5"},
          {"insertOpts.freeMargin", "0.25"},
          {"insertOpts.freeDownsampling", "0.25"},
          {"insertOpts.trainingPoints", "centroids"},
          {"insertOpts.hitDownsampling", "0.25"},
          {"insertOpts.protectHits", "5"},
          {"insertOpts.kernelSupport", "0.5"},
          {"insertOpts.lengthScale", "0.375"},
          {"insertOpts.maxPoints", "100"},
          {"insertOpts.minRange", "0.25"},
          {"insertOpts.maxRange", "15"},
          {"insertOpts.considerInvalidRangesAsFreeSpace", "false"},
          {"insertOpts.rayDecimation", "2"},
          {"insertOpts.beamWidth", "observation"},
          {"insertOpts.usePoseCovariance", "true"},
          {"insertOpts.freeThreshold", "0.25"},
          {"insertOpts.occupiedThreshold", "0.75"},
          {"insertOpts.varianceThreshold", "0.125"},
          {"likelihoodOpts.decimation", "3"},
          {"likelihoodOpts.outlierProb", "0.25"},
          {"likelihoodOpts.endPointStd", "0.125"},
          {"likelihoodOpts.unobservedProb", "0.5"},
          {"likelihoodOpts.independence", "0.75"},
          {"renderOpts.generateOccupiedVoxels", "false"},
          {"renderOpts.visibleOccupiedVoxels", "false"},
          {"renderOpts.generateFreeVoxels", "true"},
          {"renderOpts.visibleFreeVoxels", "false"},
          {"renderOpts.generateGridLines", "true"},
          {"renderOpts.hideBuriedVoxels", "false"},
          {"renderOpts.colourBy", "probability"},
          {"renderOpts.freeOpacity", "0.25"}};
}

TEST(GpMrptMap, AliasAndClassNameMakeTheMap)
{
  for (const char* name : {"gpMap", "lamap::CGPMap"})
    EXPECT_EQ(made<CGPMap>({{"creationOpts.resolution", "0.3"}}, name).resolution(), 0.3);
}

TEST(GpMrptMap, EveryOptionIsReadStoredCopiedAndWritten)
{
  const CGPMap map = made<CGPMap>(allOtherOptions());
  const auto due = map.optionValues();
  const auto usual = CGPMap().optionValues();
  for (size_t i = 0; i < due.size(); ++i)
    EXPECT_NE(due[i].text, usual[i].text) << due[i].section << "." << due[i].key << " is at its default";
  const auto expectSame = [&](const lamap::CLearnedMap& other)
  {
    const auto values = other.optionValues();
    ASSERT_EQ(values.size(), due.size());
    for (size_t i = 0; i < due.size(); ++i) EXPECT_EQ(values[i].text, due[i].text) << due[i].key;
  };
  expectSame(CGPMap(map));
  expectSame(*std::dynamic_pointer_cast<CGPMap>(objectFrom(bytesOf(map))));

  const std::string prefix = "map_gpMap_00";
  CGPMap::TMapDefinition definition;
  definition.loadFromConfigFile(mrpt::config::CConfigFileMemory(iniOf("gpMap", allOtherOptions())), prefix);
  mrpt::config::CConfigFileMemory written;
  definition.saveToConfigFile(written, prefix);
  CGPMap::TMapDefinition again;
  again.loadFromConfigFile(mrpt::config::CConfigFileMemory(written.getContent()), prefix);
  const std::unique_ptr<CGPMap> remade(CGPMap::CreateFromMapDefinition(again));
  expectSame(*remade);
}

TEST(GpMrptMap, EveryOptionTakesEffect)
{
  // Each with what else it needs to have an effect.
  const Settings centroids = {{"insertOpts.trainingPoints", "centroids"}};
  const std::vector<std::tuple<std::string, std::string, Settings>> changes = {
      {"creationOpts.resolution", "0.125", {}},
      {"creationOpts.blockDepth", "2", {}},
      {"creationOpts.pruning", "state", {}},
      {"creationOpts.planar", "true", {}},
      {"creationOpts.planarHeight", "0.5", {{"creationOpts.planar", "true"}}},
      {"creationOpts.fusion", "bayes", {}},
      {"creationOpts.signalVariance", "2", {}},
      {"creationOpts.noiseVariance", "0.3", {}},
      {"creationOpts.squashGain", "2", {}},
      {"creationOpts.minVariance", "0.001", {}},
      {"insertOpts.nested", "true", {}},
      {"insertOpts.freeSpace", "none", {}},
      {"insertOpts.freeResolution", "0.7", {}},
      {"insertOpts.freeMargin", "0.5", {}},
      {"insertOpts.freeDownsampling", "0.5", centroids},
      {"insertOpts.trainingPoints", "centroids", {}},
      {"insertOpts.hitDownsampling", "0.4", centroids},
      {"insertOpts.protectHits", "1", {{"insertOpts.freeMargin", "0"}, {"insertOpts.freeResolution", "0.1"}}},
      {"insertOpts.kernelSupport", "0.3", {}},
      {"insertOpts.lengthScale", "0.2", {}},
      {"insertOpts.maxPoints", "3", {}},
      {"insertOpts.minRange", "1", {}},
      {"insertOpts.maxRange", "1.5", {}},
      {"insertOpts.considerInvalidRangesAsFreeSpace", "false", {}},
      {"insertOpts.rayDecimation", "3", {}},
      {"insertOpts.beamWidth", "spacing", {}},
      {"insertOpts.usePoseCovariance", "true", {}},
      {"insertOpts.freeThreshold", "0.01", {}},
      {"insertOpts.occupiedThreshold", "0.99", {}},
      {"insertOpts.varianceThreshold", "0.01", {}}};
  const CGPMap untouched;
  const size_t options = untouched.creationOptions().optionTable().options().size() +
                         untouched.insertionOptions.optionTable().options().size();
  EXPECT_EQ(changes.size() + 1, options) << "say here how a new option shows; all but the preset";
  for (const auto& [name, text, others] : changes)
  {
    const CGPMap usual = taught<CGPMap>(others);
    Settings settings = others;
    settings.emplace_back(name, text);
    const CGPMap changed = taught<CGPMap>(settings);
    if (name == "creationOpts.pruning" || name == "creationOpts.fusion")
      EXPECT_NE(factsOf(changed), factsOf(usual)) << name;
    else
      EXPECT_FALSE(cellsOf(changed) == cellsOf(usual)) << name << " = " << text << " changes nothing";
  }
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
  EXPECT_NEAR(*cell->variance * cell->evidence[0], 1.0, 1e-12);
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
      {"bcm", {{"insertOpts.maxRange", "4"}}, 8336, 0.645214484963},
      {"bayes", {{"creationOpts.fusion", "bayes"}, {"insertOpts.maxRange", "4"}}, 8336, 2.4724225998},
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
    const auto newest = goldenMapOf("gpMap_v2_" + name, &today);
    ASSERT_TRUE(newest);
    EXPECT_TRUE(cellsOf(today) == cellsOf(*newest));
    expectSavesAs(*newest, "gpMap_v2_" + name);
  }
}

}  // namespace
