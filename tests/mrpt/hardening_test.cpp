// Files and scans that claim too much, and changes that fail half-way: a map is as before or as after.
#include <gtest/gtest.h>
#include <lamap_mrpt/files/atomic_file.h>
#include <lamap_mrpt/files/byte_stream.h>
#include <lamap_mrpt/files/environment.h>
#include <lamap_mrpt/files/grid_content.h>
#include <lamap_mrpt/files/map_file.h>
#include <lamap_mrpt/maps/CBGKMap.h>
#include <lamap_mrpt/maps/CGPMap.h>
#include <lamap_mrpt/maps/CHilbertMap.h>
#include <lamap_mrpt/maps/COverlappingHilbertMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/opengl/CSetOfObjects.h>
#include <zlib.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>
#include <set>

#include <support/small_maps.h>

namespace
{
using namespace lamap;
using namespace lamap::test;
using mrpt::math::TPoint3D;
using mrpt::poses::CPose3D;
namespace fs = std::filesystem;

/// Points so far apart that the rays to them cross too many cells of 0.1 m.
mrpt::obs::CObservationPointCloud farCloud()
{
  auto points = mrpt::maps::CSimplePointsMap::Create();
  std::mt19937 generator(3);
  std::uniform_real_distribution<float> coordinate(-1800, 1800);
  for (int i = 0; i < 3000; ++i)
  {
    const float x = coordinate(generator);
    const float y = coordinate(generator);
    points->insertPoint(x, y, coordinate(generator));
  }
  mrpt::obs::CObservationPointCloud cloud;
  cloud.pointcloud = points;
  return cloud;
}

template <typename Map>
class EveryMap : public testing::Test
{
};
using Maps = testing::Types<CBGKMap, CGPMap, CHilbertMap, COverlappingHilbertMap>;
TYPED_TEST_SUITE(EveryMap, Maps);

TYPED_TEST(EveryMap, LeavesOutAnObservationThatItCannotLearn)
{
  TypeParam map;
  map.setMinLoggingLevel(mrpt::system::LVL_ERROR);
  map.logging_enable_console_output = false;
  map.insertRay(1, 0.2f, 0.1f, 0, 0, 0);
  const auto before = bytesOf(map);
  const auto cloud = farCloud();
  EXPECT_THROW((void)map.learnObservation(cloud, CPose3D()), std::length_error);
  EXPECT_EQ(bytesOf(map), before);
  EXPECT_FALSE(map.insertObservation(cloud));
  EXPECT_EQ(bytesOf(map), before);
  EXPECT_NE(map.asString().find("observations that could not be read or learned 1"), std::string::npos)
      << map.asString();
  map.insertRay(1.5f, 0.2f, 0.1f, 0, 0, 0);
  EXPECT_NE(bytesOf(map), before);
  // What is wrong with the map's own options is no fault of the observation.
  map.insertionOptions.minRange = -1;
  EXPECT_THROW((void)map.insertObservation(cloud), std::invalid_argument);
}

TYPED_TEST(EveryMap, ATooLongScanIsRefusedBeforeMostOfTheWork)
{
  TypeParam map;
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_THROW((void)map.learnObservation(farCloud(), CPose3D()), std::length_error);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  EXPECT_LT(seconds, 30) << "on a busy machine; without the check, minutes and gigabytes";
}

TYPED_TEST(EveryMap, SaysHowLongARayMayBe)
{
  TypeParam map;
  map.logging_enable_console_output = false;
  std::string said;
  map.logRegisterCallback([&](std::string_view message, auto&&...) { said += message; });
  Scan scan;
  scan.fans.emplace_back().addReturn({4000, 0, 0});
  scan.fans.emplace_back().addReturn({0.1, 17000, 0.1});
  EXPECT_FALSE(map.insertScan(scan));
  EXPECT_NE(
      said.find("2; they are longer than 32768 cells of 0.1 m, up to 17000 m; set insertOpts.maxRange, or a "
                "larger creationOpts.resolution"),
      std::string::npos)
      << said;
  EXPECT_NE(map.asString().find("rays left out, too long for the cells 2"), std::string::npos)
      << map.asString();
  EXPECT_TRUE(map.isEmpty());
  map.insertionOptions.maxRange = 3;
  EXPECT_TRUE(map.insertScan(scan));
}

TEST(OverlappingWaiting, NoQuestionFailsForAScanThatWaits)
{
  COverlappingHilbertMap map;
  map.logging_enable_console_output = false;
  map.insertionOptions.scansPerModel = 3;
  map.insertRay(1, 0.2f, 0.1f, 0, 0, 0);
  map.insertRay(1, 0.3f, 0.1f, 0, 0, 0);
  const auto known = map.estimateAt({1, 0.2, 0.1});
  ASSERT_TRUE(known);
  const auto saved = bytesOf(map);

  // Samples at every tenth of a millimetre of a long ray: more than one scan may have.
  map.insertionOptions.trainingPoints = HilbertPoints::Points;
  map.insertionOptions.freeResolution = 0.001;
  EXPECT_THROW((void)map.insertScan(
                   [&]
                   {
                     Scan scan;
                     RayFan& fan = scan.fans.emplace_back();
                     for (int i = 0; i < 12000; ++i) fan.addReturn({3000, 0.1 * i, 1});
                     return scan;
                   }()),
               std::length_error);
  EXPECT_TRUE(map.estimateAt({1, 0.2, 0.1}));
  map.insertionOptions.trainingPoints = HilbertPoints::Cells;
  map.insertionOptions.freeResolution = 0.3;
  EXPECT_EQ(bytesOf(map), saved);
  EXPECT_EQ(map.estimateAt({1, 0.2, 0.1})->prob, known->prob);
}

// ---- Files

TEST(GridContent, BlocksAtTheEndsOfTheIndicesAreRefused)
{
  for (const bool planar : {false, true})
  {
    const BlockShape shape(3, planar);
    const auto isRefused = [&](const BlockIndex& index)
    {
      Evidence grid(shape);
      DenseBlock dense(shape);
      dense.set(0, {5, 7});
      grid.findOrCreate(index).pack(shape, dense, {});
      ByteWriter out;
      writeGrid(grid, out);
      ByteReader in(out.bytes());
      try
      {
        const Evidence read =
            readGrid(Evidence(shape), planar ? std::optional<int32_t>(0) : std::nullopt, in);
        EXPECT_EQ(read.blockCount(), 1u);
        return false;
      }
      catch (const std::runtime_error&)
      {
        return true;
      }
    };
    constexpr int32_t kMost = std::numeric_limits<int32_t>::max() >> 3;
    EXPECT_FALSE(isRefused({267500000, -267500000, 0})) << "insertion reaches it";
    EXPECT_FALSE(isRefused({kLastCell / 8 - 1, -kLastCell / 8, 0})) << "the outermost ones";
    EXPECT_TRUE(isRefused({kLastCell / 8, 0, 0}));
    EXPECT_TRUE(isRefused({0, -kLastCell / 8 - 1, 0}));
    for (const int32_t end : {kMost, -kMost - 1, kMost - 1, std::numeric_limits<int32_t>::max(),
                              std::numeric_limits<int32_t>::min()})
    {
      EXPECT_TRUE(isRefused({end, 0, 0})) << end;
      EXPECT_TRUE(isRefused({0, end, 0})) << end;
      EXPECT_TRUE(isRefused({0, 0, end})) << end;
    }
  }
}

TEST(EdgeCells, TheLastCellsThatPointsAreInCanBeSavedAndDrawn)
{
  CBGKMap map(0.1);
  const double edge = 213999999.85;
  for (int i = 0; i < 50; ++i) map.updateVoxel(edge, -edge, edge, true);
  const auto before = bytesOf(map);
  const TemporaryFolder folder;
  saveMapFile(map, folder.file("edge.lamap.gz"));
  const auto loaded = std::dynamic_pointer_cast<CBGKMap>(loadMapFile(folder.file("edge.lamap.gz")));
  ASSERT_TRUE(loaded);
  EXPECT_EQ(bytesOf(*loaded), before);
  const auto objects = mrpt::opengl::CSetOfObjects::Create();
  loaded->getVisualizationInto(*objects);
  loaded->insertRay(1, 0, 0, 0, 0, 0);
}

/// A file of one member, as gzip would write it.
void writeGzip(const std::string& path, const std::string& content)
{
  gzFile file = gzopen(path.c_str(), "wb9");
  ASSERT_NE(file, nullptr);
  ASSERT_EQ(gzwrite(file, content.data(), static_cast<unsigned>(content.size())),
            static_cast<int>(content.size()));
  ASSERT_EQ(gzclose(file), Z_OK);
}

std::string refusalOf(const std::string& path)
{
  try
  {
    (void)loadMapFile(path);
  }
  catch (const std::runtime_error& error)
  {
    return error.what();
  }
  return "";
}

TEST(ContentLimit, AFileIsRefusedForWhatItClaimsBeforeItIsInflated)
{
  const TemporaryFolder folder;
  const std::string name = "lamap::CHilbertMap";
  const auto fileWith = [&](uint64_t claimed, size_t zeros)
  {
    std::string content = static_cast<char>(0x80 | name.size()) + name + '\x02';
    for (int byte = 0; byte < 8; ++byte) content += static_cast<char>(claimed >> (8 * byte) & 0xFF);
    content.append(4 + zeros, '\0');
    writeGzip(folder.file("bomb.lamap.gz"), content);
    return folder.file("bomb.lamap.gz");
  };
  constexpr uint64_t kMiB = 1 << 20;
  for (const uint64_t claimed : {300 * kMiB, 3000 * kMiB, std::numeric_limits<uint64_t>::max()})
  {
    const std::string said = refusalOf(fileWith(claimed, 8 * kMiB));
    EXPECT_NE(said.find("claims"), std::string::npos) << said;
    EXPECT_NE(said.find("LAMAP_MAX_CONTENT_MIB"), std::string::npos) << said;
  }
  EXPECT_EQ(refusalOf(fileWith(8 * kMiB, 8 * kMiB)).find("claims"), std::string::npos)
      << "it is damaged otherwise";

  EXPECT_EQ(mostContentOf(1000), 48 * kMiB + 40000);
  EXPECT_EQ(mostContentOf(10 * kMiB), std::min<uint64_t>(448 * kMiB, memoryForContent()));
  EXPECT_EQ(mostContentOf(std::numeric_limits<uint64_t>::max()), memoryForContent());
  setenv("LAMAP_MAX_CONTENT_MIB", "4", 1);
  EXPECT_EQ(mostContentOf(1000), 4 * kMiB);
  EXPECT_NE(refusalOf(fileWith(8 * kMiB, 8 * kMiB)).find("claims"), std::string::npos);
  setenv("LAMAP_MAX_CONTENT_MIB", "99999999999", 1);
  EXPECT_EQ(mostContentOf(1000), memoryForContent() / kMiB * kMiB);
  unsetenv("LAMAP_MAX_CONTENT_MIB");
}

TEST(Environment, AMalformedLimitIsRefusedByName)
{
  const char* const name = "LAMAP_MAX_CONTENT_MIB";
  for (const char* bad : {"", "seven", "7 ", "7MiB", "-1", "0", "nan", "inf", "1e400"})
  {
    SCOPED_TRACE(bad);
    setenv(name, bad, 1);
    std::string said;
    try
    {
      (void)mostContentOf(1000);
    }
    catch (const std::runtime_error& error)
    {
      said = error.what();
    }
    EXPECT_NE(said.find(name), std::string::npos) << said;
    EXPECT_NE(said.find("'" + std::string(bad) + "'"), std::string::npos) << said;
  }
  for (const auto& [text, number] : std::vector<std::pair<const char*, uint64_t>>{
           {"1", 1},
           {"7", 7},
           {"2e9", 2000000000},
           {"18446744073709551615", std::numeric_limits<uint64_t>::max()},
           {"1e300", std::numeric_limits<uint64_t>::max()}})
  {
    setenv(name, text, 1);
    EXPECT_EQ(limitFromEnvironment(name), number);
  }
  unsetenv(name);
  EXPECT_EQ(limitFromEnvironment(name), std::nullopt);
}

TEST(MapFile, SaysHowMuchOfACutContentIsThere)
{
  const TemporaryFolder folder;
  CBGKMap map(0.1);
  map.updateVoxel(0.5, 0.5, 0.5, true);
  const auto bytes = bytesOf(map);
  const std::string whole(bytes.begin(), bytes.end());
  const size_t header = std::string("-lamap::CBGKMap-").size() + sizeof(uint64_t) + sizeof(uint32_t);
  const size_t payload = whole.size() - 1 - header;
  for (const size_t there : {size_t{0}, size_t{1}, payload / 2, payload - 1})
  {
    writeGzip(folder.file("cut.lamap.gz"), whole.substr(0, header + there));
    const std::string said = refusalOf(folder.file("cut.lamap.gz"));
    EXPECT_NE(said.find(" " + std::to_string(there) + " of " + std::to_string(payload) + " bytes are there"),
              std::string::npos)
        << said;
  }
}

// ---- Rays through empty space

TEST(RayCasting, SkipsEmptySpaceBetweenCellsThatAreFarApart)
{
  CBGKMap map(0.1);
  map.updateVoxel(0.05, 0.05, 0.05, true);
  map.updateVoxel(2e7 + 0.05, 0.05, 0.05, true);
  const auto begin = std::chrono::steady_clock::now();
  TPoint3D end;
  EXPECT_TRUE(map.castRay({0.15, 0.05, 0.05}, {1, 0, 0}, end, true));
  EXPECT_NEAR(end.x, 2e7 + 0.05, 1e-6);
  EXPECT_TRUE(map.castRay({1e7, 0.05, 0.05}, {-1, 0, 0}, end, true));
  EXPECT_NEAR(end.x, 0.05, 1e-6);
  EXPECT_FALSE(map.castRay({0.15, 0.05, 0.05}, {1, 0, 0}, end, true, 1e7));
  EXPECT_NEAR(end.x, 1e7 + 0.15, 0.11) << "the last cell on the ray";
  EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(), 5);
}

TEST(RayCasting, FindsTheSameCellsAsAWalkOfAllCells)
{
  CBGKMap map(1.0);
  std::mt19937 generator(11);
  std::uniform_int_distribution<int> cell(-150, 150);
  std::set<std::array<int, 3>> occupied;
  for (int i = 0; i < 300; ++i)
  {
    const int x = cell(generator);
    const int y = cell(generator);
    const int z = cell(generator) / 40;
    // Blobs, so that rays meet some.
    for (int dx = 0; dx < 6; ++dx)
      for (int dy = 0; dy < 6; ++dy)
      {
        map.updateVoxel(x + dx + 0.5, y + dy + 0.5, z + 0.5, true);
        occupied.insert({x + dx, y + dy, z});
      }
  }
  int hits = 0;
  for (int i = 0; i < 400; ++i)
  {
    SCOPED_TRACE(i);
    const TPoint3D origin(cell(generator) + 0.37, cell(generator) + 0.21, cell(generator) / 40 + 0.43);
    TPoint3D direction(cell(generator) + 0.3, cell(generator) + 0.7, cell(generator) / 200.0);
    if (i % 10 == 0) direction = {1, 1, 0};
    TPoint3D end;
    const double range = i % 3 == 0 ? 100 : 0;
    const bool met = map.castRay(origin, direction, end, true, range);
    // By brute force: the nearest of the occupied cells that the ray pierces.
    const double length = direction.norm();
    double nearest = std::numeric_limits<double>::infinity();
    double nearestSure = nearest;
    for (const std::array<int, 3>& corner : occupied)
    {
      const auto entry = [&](double margin)
      {
        double first = 0;
        double last = range > 0 ? range : std::numeric_limits<double>::infinity();
        const double low[] = {corner[0] + margin, corner[1] + margin, corner[2] + margin};
        for (int axis = 0; axis < 3; ++axis)
        {
          const double a = (low[axis] - origin[axis]) / (direction[axis] / length);
          const double b = (low[axis] + 1 - 2 * margin - origin[axis]) / (direction[axis] / length);
          if (direction[axis] == 0)
          {
            if (origin[axis] < low[axis] || origin[axis] > low[axis] + 1 - 2 * margin) return -1.0;
            continue;
          }
          first = std::max(first, std::min(a, b));
          last = std::min(last, std::max(a, b));
        }
        return first <= last ? first : -1.0;
      };
      if (const double t = entry(-1e-9); t >= 0) nearest = std::min(nearest, t);
      if (const double t = entry(1e-9); t >= 0) nearestSure = std::min(nearestSure, t);
    }
    if (nearest != nearestSure && std::abs(nearest - nearestSure) > 1e-6) continue;  // a corner is touched
    EXPECT_EQ(met, std::isfinite(nearest));
    if (!met) continue;
    ++hits;
    const double reached = (end - origin).norm();
    EXPECT_NEAR(reached, nearest, 1.0) << "the centre of the cell that is entered there";
  }
  EXPECT_GT(hits, 30);
}

// ---- What a killed run leaves

TEST(AtomicFileLeftOvers, AreRemovedByTheNextWriterUnlessSomebodyWritesThem)
{
  const TemporaryFolder folder;
  const auto left = [&](const std::string& name)
  {
    std::ofstream(folder.file(name)) << "half";
    return folder.file(name);
  };
  const std::string dead = left(".partial-0badcafe3-map.lamap.gz");
  const std::string other = left(".partial-0badcafe3-other.lamap.gz");
  const std::string longer = left(".partial-0badcafe3-my-map.lamap.gz");
  const std::string foreign = left(".partial-by hand-map.lamap.gz");
  AtomicFile first(folder.file("map.lamap.gz"));
  EXPECT_FALSE(fs::exists(dead));
  EXPECT_TRUE(fs::exists(other));
  EXPECT_TRUE(fs::exists(longer));
  EXPECT_TRUE(fs::exists(foreign));
  {
    AtomicFile second(folder.file("map.lamap.gz"));
    EXPECT_TRUE(fs::exists(first.temporaryPath())) << "the first one is being written";
    second.write("second");
    second.commit();
  }
  first.write("first");
  first.commit();
  std::string content;
  std::ifstream(folder.file("map.lamap.gz")) >> content;
  EXPECT_EQ(content, "first");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.file("")), {}), 4);
}

TEST(AtomicFileDevices, TakeWhatWritersThatMindNoErrorsWrote)
{
  AtomicFile full("/dev/full");
  EXPECT_NE(full.temporaryPath(), "/dev/full");
  std::ofstream(full.temporaryPath()) << "content";
  EXPECT_THROW(full.commit(), std::runtime_error);
  AtomicFile none("/dev/null");
  std::ofstream(none.temporaryPath()) << "content";
  EXPECT_NO_THROW(none.commit());
}
}  // namespace
