#include <gtest/gtest.h>
#include <lamap_mrpt/compat/mrpt_compat.h>
#include <lamap_mrpt/files/map_file.h>
#include <lamap_mrpt/maps/CBGKMap.h>
#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/maps/COctoMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/maps/TMetricMapInitializer.h>
#include <mrpt/opengl/COpenGLScene.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <random>
#include <set>

#include <support/golden_files.h>
#include <support/small_maps.h>

namespace
{
using lamap::CBGKMap;
using lamap::CellEstimate;
using lamap::CellIndex;
using namespace lamap::test;

std::map<std::array<int32_t, 3>, CellEstimate> cellsOf(const CBGKMap& map)
{
  std::map<std::array<int32_t, 3>, CellEstimate> cells;
  map.visitCells(
      [&](const CellIndex& cell, const CellEstimate& estimate) {
        cells[{cell.z, cell.y, cell.x}] = estimate;
      });
  return cells;
}

void expectSameCells(const CBGKMap& map, const CBGKMap& expected)
{
  const auto cells = cellsOf(map);
  const auto due = cellsOf(expected);
  ASSERT_EQ(cells.size(), due.size());
  ASSERT_FALSE(due.empty());
  for (const auto& [cell, estimate] : due)
  {
    const auto found = cells.find(cell);
    ASSERT_NE(found, cells.end());
    EXPECT_EQ(found->second.evidence, estimate.evidence);
    EXPECT_EQ(found->second.prob, estimate.prob);
    EXPECT_EQ(found->second.variance, estimate.variance);
    EXPECT_EQ(found->second.state, estimate.state);
  }
}

/// Maps of every kind that has its own file content.
std::vector<CBGKMap> maps()
{
  std::vector<CBGKMap> all;
  for (const auto pruning : {lamap::Pruning::None, lamap::Pruning::Lossless, lamap::Pruning::State})
    for (const bool planar : {false, true})
      for (const int depth : {2, 4, 6})
      {
        CBGKMap::TCreationOptions options;
        options.pruning = pruning;
        options.planar = planar;
        options.planarHeight = 0.5;
        options.blockDepth = depth;
        CBGKMap map(options);
        map.insertScan(smallScan());
        map.insertObservation(roomScan(), mrpt::poses::CPose3D(-20, -30, -0.2, 1, 0.1, 0));
        // Counts beyond 32 bits, and octants stored once.
        for (int i = 0; i < 13; ++i)
        {
          map.insertionOptions.kernelScale = 1000;
          map.updateVoxel(0.05, 0.05, 0.55, true);
        }
        for (int i = 0; i < 8; ++i)
          map.updateVoxel(4.05 + 0.1 * (i & 1), 4.05 + 0.1 * (i >> 1 & 1), 0.85 + 0.1 * (i >> 2), false);
        map.insertionOptions.kernelScale = 1;
        all.push_back(map);
      }
  all.emplace_back();
  return all;
}

TEST(Serialization, LosesNothingAndRepeatsItself)
{
  int number = 0;
  for (const CBGKMap& map : maps())
  {
    SCOPED_TRACE(number++);
    const auto bytes = bytesOf(map);
    const auto object = objectFrom(bytes);
    const auto loaded = std::dynamic_pointer_cast<CBGKMap>(object);
    ASSERT_TRUE(loaded);
    EXPECT_EQ(bytesOf(*loaded), bytes);
    if (!map.isEmpty()) expectSameCells(*loaded, map);
    EXPECT_EQ(loaded->isEmpty(), map.isEmpty());
  }
}

TEST(Serialization, PriorMapsOfPriorMapsAreIncluded)
{
  const TemporaryFolder folder;
  CBGKMap first;
  first.updateVoxel(1.05, 0.05, 0.05, true);
  lamap::saveMapFile(first, folder.file("first.lamap.gz"));
  CBGKMap::TCreationOptions options;
  options.priorMap = folder.file("first.lamap.gz");
  CBGKMap second(options);
  second.updateVoxel(2.05, 0.05, 0.05, true);
  lamap::saveMapFile(second, folder.file("second.lamap.gz"));
  options.priorMap = folder.file("second.lamap.gz");
  CBGKMap third(options);
  third.updateVoxel(3.05, 0.05, 0.05, true);
  const auto loaded = std::dynamic_pointer_cast<CBGKMap>(objectFrom(bytesOf(third)));
  ASSERT_TRUE(loaded);
  EXPECT_EQ(cellsOf(*loaded).size(), 3u);
  expectSameCells(*loaded, third);
  EXPECT_EQ(bytesOf(*loaded), bytesOf(third));
}

TEST(Serialization, AForeignPriorMapIsRefusedByName)
{
  const TemporaryFolder folder;
  lamap::saveMapFile(mrpt::maps::COctoMap(0.1), folder.file("octo.lamap.gz"));
  CBGKMap::TCreationOptions options;
  options.priorMap = folder.file("octo.lamap.gz");
  try
  {
    CBGKMap map(options);
    FAIL() << "taken";
  }
  catch (const std::invalid_argument& error)
  {
    for (const std::string part : {"priorMap", "octo.lamap.gz", "mrpt::maps::COctoMap", "lamap::CBGKMap"})
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
  lamap::saveMapFile(CBGKMap(0.2), folder.file("coarse.lamap.gz"));
  options.priorMap = folder.file("coarse.lamap.gz");
  EXPECT_THROW(CBGKMap{options}, std::invalid_argument);
}

std::string complaintAbout(const std::vector<uint8_t>& bytes)
{
  try
  {
    (void)objectFrom(bytes);
  }
  catch (const std::exception& error)
  {
    return lamap::compat::messageOf(error);
  }
  return "";
}

TEST(Serialization, ANewerVersionIsRefusedAsSuch)
{
  auto bytes = bytesOf(CBGKMap());
  const size_t versionAt = 1 + std::string("lamap::CBGKMap").size();
  ASSERT_EQ(bytes.at(versionAt), 3);
  bytes[versionAt] = 9;
  const std::string complaint = complaintAbout(bytes);
  for (const std::string part : {"lamap::CBGKMap", "version 9", "up to version 3", "newer"})
    EXPECT_NE(complaint.find(part), std::string::npos) << complaint;
}

TEST(Serialization, AFailedLoadLeavesTheMapAsItWas)
{
  CBGKMap map;
  map.insertScan(smallScan());
  const auto before = bytesOf(map);
  auto bytes = bytesOf(CBGKMap(0.3));
  bytes[bytes.size() - 5] ^= 1;
  mrpt::io::CMemoryStream stream;
  stream.assignMemoryNotOwn(bytes.data(), bytes.size());
  auto archive = mrpt::serialization::archiveFrom(stream);
  EXPECT_THROW(archive.ReadObject(&map), std::exception);
  EXPECT_EQ(bytesOf(map), before);
}

/// The map of the golden file: a fixed scan with fixed options, none of which is left to a default that may
/// change.
CBGKMap goldenMap()
{
  mrpt::maps::TSetOfMetricMapInitializers definitions;
  definitions.loadFromConfigFile(mrpt::config::CConfigFileMemory(R"(
[map]
bgkMap_count = 1
[map_bgkMap_00_creationOpts]
resolution = 0.125
blockDepth = 4
pruning = lossless
planar = false
planarHeight = 0
priorAlpha = 0.003
priorBeta = 0.003
maxEvidence = 0
enableSaveAs3DObject = false
[map_bgkMap_00_insertOpts]
freeSpace = samples
freeResolution = 0.125
freeMargin = 0.125
freeWeight = 0.5
freeDownsampling = 0
trainingPoints = cells
hitDownsampling = 0.125
protectHits = 2
kernel = sparse
kernelSupport = 0.25
kernelScale = 1.5
usePoseCovariance = false
minRange = 0
maxRange = 0
considerInvalidRangesAsFreeSpace = true
rayDecimation = 1
freeThreshold = 0.3
occupiedThreshold = 0.7
varianceThreshold = 0
[map_bgkMap_00_likelihoodOpts]
decimation = 3
outlierProb = 0.25
endPointStd = 0.125
freeBefore = 0
unobservedProb = 0.5
independence = 0.75
[map_bgkMap_00_renderOpts]
generateOccupiedVoxels = true
visibleOccupiedVoxels = true
generateFreeVoxels = true
visibleFreeVoxels = false
generateGridLines = true
hideBuriedVoxels = true
colourBy = variance
freeOpacity = 0.25
)"),
                                 "map");
  mrpt::maps::CMultiMetricMap maps;
  maps.setListOfMaps(definitions);
  auto map = dynamic_cast<CBGKMap&>(*maps.maps.at(0));
  map.insertScan(smallScan());
  return map;
}

TEST(Serialization, TheFileOfVersion1LoadsAsItWas)
{
  const auto loaded = goldenMapOf<CBGKMap>("bgk_map_v1", nullptr);
  ASSERT_TRUE(loaded);
  // What the file's map said when it was written.
  size_t cells = 0;
  double alpha = 0;
  loaded->visitCells(
      [&](const CellIndex&, const CellEstimate& estimate)
      {
        ++cells;
        alpha += estimate.evidence[0];
      });
  EXPECT_EQ(cells, 1628U);
  EXPECT_NEAR(alpha, 90.4180003967287, 1e-9);
  expectSavesTheSameAgain(*loaded);
}

TEST(Serialization, TheFileOfVersion2LoadsWithTheOptionsThatItLacksOff)
{
  const auto loaded = goldenMapOf<CBGKMap>("bgk_map_v2", nullptr);
  ASSERT_TRUE(loaded);
  expectSameCells(*loaded, goldenMap());
  EXPECT_EQ(loaded->likelihoodOptions.freeBefore, 0);
  EXPECT_EQ(loaded->creationOptions().maxEvidence, 0);
  EXPECT_EQ(loaded->likelihoodOptions.independence, 0.75);
  expectSavesTheSameAgain(*loaded);
}

TEST(Serialization, TheFileOfVersion3HoldsWhatIsLearnedTodayAndSavesToTheSameBytes)
{
  const CBGKMap today = goldenMap();
  const auto loaded = goldenMapOf("bgk_map_v3", &today);
  ASSERT_TRUE(loaded);
  expectSameCells(*loaded, today);
  EXPECT_EQ(bytesOf(*loaded), bytesOf(today));
  expectSavesAs(*loaded, "bgk_map_v3");
}

TEST(Serialization, SavingTheRepresentationWritesThreeWholeFiles)
{
  const TemporaryFolder folder;
  CBGKMap map;
  map.insertScan(smallScan());
  map.saveMetricMapRepresentationToFile(folder.file("map"));
  const auto loaded = std::dynamic_pointer_cast<CBGKMap>(lamap::loadMapFile(folder.file("map.lamap.gz")));
  ASSERT_TRUE(loaded);
  EXPECT_EQ(bytesOf(*loaded), bytesOf(map));

  mrpt::opengl::COpenGLScene scene;
  ASSERT_TRUE(scene.loadFromFile(folder.file("map.3Dscene")));
  EXPECT_TRUE(scene.getByClass<mrpt::opengl::COctoMapVoxels>());

  mrpt::maps::CSimplePointsMap points;
  ASSERT_TRUE(points.loadFromPlyFile(folder.file("map.ply")));
  EXPECT_EQ(points.size(), map.getAsSimplePointsMap()->size());
  EXPECT_GT(points.size(), 0u);

  EXPECT_EQ(
      std::distance(
          std::filesystem::directory_iterator(std::filesystem::path(folder.file("map")).parent_path()), {}),
      3);
  EXPECT_THROW(map.saveMetricMapRepresentationToFile("/no/such/folder/map"), std::runtime_error);
}

TEST(Serialization, PlyAndSceneKeepCellsApartInUtmCoordinates)
{
  const TemporaryFolder folder;
  for (const Eigen::Vector3d& first :
       {Eigen::Vector3d(448123.45, 5412345.65, 310.25), Eigen::Vector3d(-5e6 + 0.05, 0.05, 0.05),
        Eigen::Vector3d(0.05, 0.15, 0.25)})
  {
    SCOPED_TRACE(first.x());
    CBGKMap map;
    constexpr size_t kCells = 5;
    for (size_t i = 0; i < kCells; ++i)
      map.updateVoxel(first.x() + 0.1 * static_cast<double>(i), first.y(), first.z(), true);
    map.saveMetricMapRepresentationToFile(folder.file("utm"));

    std::ifstream file(folder.file("utm.ply"), std::ios::binary);
    const std::string ply{std::istreambuf_iterator<char>(file), {}};
    const std::string end = "property double z\nend_header\n";
    const size_t begin = ply.find(end) + end.size();
    ASSERT_EQ(ply.size(), begin + 24 * kCells);
    for (size_t i = 0; i < kCells; ++i)
    {
      Eigen::Vector3d centre;
      std::memcpy(centre.data(), ply.data() + begin + 24 * i, 24);
      EXPECT_LT((centre - first - 0.1 * static_cast<double>(i) * Eigen::Vector3d::UnitX()).norm(), 1e-6) << i;
    }

    mrpt::opengl::COpenGLScene scene;
    ASSERT_TRUE(scene.loadFromFile(folder.file("utm.3Dscene")));
    const auto voxels = scene.getByClass<mrpt::opengl::COctoMapVoxels>();
    ASSERT_TRUE(voxels);
    ASSERT_EQ(voxels->getVoxelCount(mrpt::opengl::VOXEL_SET_OCCUPIED), kCells);
    std::set<int64_t> steps;  // the order of voxels is none
    for (size_t i = 0; i < kCells; ++i)
    {
      const mrpt::math::TPoint3D coords(voxels->getVoxel(mrpt::opengl::VOXEL_SET_OCCUPIED, i).coords);
      const auto centre = voxels->getPose() + mrpt::math::TPose3D(coords);
      const auto step = std::llround((centre.x - first.x()) / 0.1);
      EXPECT_NEAR(centre.x, first.x() + 0.1 * static_cast<double>(step), 1e-5) << i;
      EXPECT_NEAR(centre.y, first.y(), 1e-5) << i;
      EXPECT_NEAR(centre.z, first.z(), 1e-5) << i;
      steps.insert(step);
    }
    EXPECT_EQ(steps, (std::set<int64_t>{0, 1, 2, 3, 4}));
  }
}

}  // namespace
