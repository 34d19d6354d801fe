#include <gtest/gtest.h>
#include <lamap_mrpt/files/map_file.h>
#include <lamap_tools/cells/cell_table.h>
#include <lamap_tools/cells/octomap_file.h>
#include <lamap_tools/export/export_map.h>
#include <lamap_tools/files/usage_error.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/maps/COctoMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/opengl/COctoMapVoxels.h>
#include <mrpt/opengl/COpenGLScene.h>
#include <octomap/OcTree.h>

#include <cmath>
#include <cstring>
#include <random>
#include <sstream>

#include "support/temporary_folder.h"
#include "tools/cell_rows.h"
#include "tools/hand_made_cells.h"

namespace
{
using namespace lamap;
using namespace lamap::tools;
using lamap::test::CellTable;
using lamap::test::readCellTable;
using test::HandMadeCells;
using test::TemporaryFolder;

std::string messageOf(const std::function<void()>& action)
{
  try
  {
    action();
  }
  catch (const std::exception& error)
  {
    return error.what();
  }
  return "";
}

bool contains(const std::string& text, const std::string& part)
{
  return text.find(part) != std::string::npos;
}

/// Cells around the origin with probabilities of every size, and all three states.
HandMadeCells randomCells(unsigned seed)
{
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> index(-20, 20);
  std::uniform_real_distribution<double> uniform(0, 1);
  HandMadeCells map(0.05);
  std::vector<CellIndex> taken;
  for (int i = 0; i < 500; ++i)
  {
    const CellIndex cell{index(random), index(random), index(random)};
    if (std::find(taken.begin(), taken.end(), cell) != taken.end()) continue;
    taken.push_back(cell);
    const double prob = uniform(random);
    map.put(cell, prob,
            prob > 0.7   ? CellState::Occupied
            : prob < 0.3 ? CellState::Free
                         : CellState::Unknown,
            uniform(random) < 0.5 ? std::optional(prob / 7) : std::nullopt);
  }
  return map;
}

TEST(ExportCsv, IsTheContractWordForWord)
{
  const TemporaryFolder folder;
  HandMadeCells map(0.5);
  map.put({0, 0, 1}, 0.875, CellState::Occupied, 0.0625)
      .put({-3, 1, 0}, 0.25, CellState::Free)
      .put({-1, -1, 0}, 0.5, CellState::Unknown, 0.125);
  exportMap(map, folder / "map.csv");
  EXPECT_EQ(test::fileContent(folder / "map.csv"),
            "x,y,z,prob,variance,state,alpha,beta\n"
            "-0.25,-0.25,0.25,0.5,0.125,unknown,5,5\n"
            "-1.25,0.75,0.25,0.25,,free,2.5,7.5\n"
            "0.25,0.25,0.75,0.875,0.0625,occupied,8.75,1.25\n");
  EXPECT_EQ(folder.size(), 1U) << "nothing is left beside the file";
}

TEST(ExportCsv, NumbersReadBackAsTheSameDoubles)
{
  const TemporaryFolder folder;
  const HandMadeCells map = randomCells(1);
  exportMap(map, folder / "map.csv");
  const CellTable table = readCellTable(map);
  std::istringstream lines(test::fileContent(folder / "map.csv"));
  std::string line;
  std::getline(lines, line);
  for (const CellRow& row : table.rows)
  {
    ASSERT_TRUE(std::getline(lines, line));
    std::istringstream fields(line);
    std::vector<std::string> field(8);
    for (std::string& text : field) std::getline(fields, text, ',');
    const Eigen::Vector3d centre = cellCentre(row.index, 0.05);
    for (size_t axis = 0; axis < 3; ++axis) EXPECT_EQ(std::stod(field[axis]), centre[static_cast<int>(axis)]);
    EXPECT_EQ(std::stod(field[3]), row.estimate.prob);
    EXPECT_EQ(field[4].empty(), !row.estimate.variance);
    if (row.estimate.variance)
    {
      EXPECT_EQ(std::stod(field[4]), *row.estimate.variance);
    }
    EXPECT_EQ(field[5], stateName(row.estimate.state));
    EXPECT_EQ(std::stod(field[6]), row.estimate.evidence[0]);
  }
  EXPECT_FALSE(std::getline(lines, line));
}

TEST(ExportCsv, HoldsOnlyTheStatesAskedFor)
{
  const TemporaryFolder folder;
  HandMadeCells map;
  map.put({0, 0, 0}, 0.9, CellState::Occupied)
      .put({1, 0, 0}, 0.1, CellState::Free)
      .put({2, 0, 0}, 0.5, CellState::Unknown);
  ExportOptions options;
  options.states = parseStates("occupied,unknown");
  exportMap(map, folder / "map.csv", options);
  const std::string content = test::fileContent(folder / "map.csv");
  EXPECT_TRUE(contains(content, "occupied"));
  EXPECT_TRUE(contains(content, "unknown"));
  EXPECT_FALSE(contains(content, "free"));
}

TEST(ExportPly, MrptReadsTheOccupiedCells)
{
  const TemporaryFolder folder;
  HandMadeCells map(0.1);
  map.put({1, 2, 3}, 0.9, CellState::Occupied, 0.01)
      .put({-5, 0, 9}, 0.8, CellState::Occupied)
      .put({0, 0, 0}, 0.1, CellState::Free);
  exportMap(map, folder / "map.ply");
  mrpt::maps::CSimplePointsMap points;
  ASSERT_TRUE(points.loadFromPlyFile(folder / "map.ply")) << points.getLoadPLYErrorString();
  ASSERT_EQ(points.size(), 2U);
  float x = 0, y = 0, z = 0;
  points.getPoint(0, x, y, z);
  EXPECT_FLOAT_EQ(x, 0.15F);
  EXPECT_FLOAT_EQ(y, 0.25F);
  EXPECT_FLOAT_EQ(z, 0.35F);
  points.getPoint(1, x, y, z);
  EXPECT_FLOAT_EQ(x, -0.45F);
}

// Read by hand what the header describes: properties in their order, no padding.
TEST(ExportPly, HoldsProbabilityVarianceAndState)
{
  const TemporaryFolder folder;
  HandMadeCells map(0.1);
  map.put({10'000'000, 0, 0}, 0.9, CellState::Occupied, 0.0625).put({0, 0, 1}, 0.25, CellState::Free);
  ExportOptions options;
  options.states = parseStates("all");
  exportMap(map, folder / "map.ply", options);
  const std::string content = test::fileContent(folder / "map.ply");
  EXPECT_TRUE(contains(content, "element vertex 2\n"));
  const size_t start = content.find("end_header\n") + 11;
  constexpr size_t kRow = 3 * 8 + 3 + 2 * 4 + 1;
  ASSERT_EQ(content.size() - start, 2 * kRow);
  const auto number = [&](size_t at, auto type)
  {
    std::memcpy(&type, &content[start + at], sizeof(type));
    return type;
  };
  EXPECT_EQ(number(0, double()), 10'000'000.5 * 0.1) << "1,000 km away, to the last bit";
  EXPECT_EQ(number(27, float()), 0.9F);
  EXPECT_EQ(number(31, float()), 0.0625F);
  EXPECT_EQ(number(35, uint8_t()), 2);
  EXPECT_EQ(number(kRow + 27, float()), 0.25F);
  EXPECT_TRUE(std::isnan(number(kRow + 31, float())));
  EXPECT_EQ(number(kRow + 35, uint8_t()), 1);
}

TEST(ExportPcd, IsBinaryWithPositionColourAndIntensity)
{
  const TemporaryFolder folder;
  HandMadeCells map(0.1);
  map.put({1, 2, 3}, 0.9, CellState::Occupied).put({0, 0, 0}, 0.1, CellState::Free);
  exportMap(map, folder / "map.pcd");
  const std::string content = test::fileContent(folder / "map.pcd");
  EXPECT_TRUE(contains(content, "FIELDS x y z rgb intensity\nSIZE 4 4 4 4 4\nTYPE F F F F F\n"));
  EXPECT_TRUE(contains(content, "POINTS 1\nDATA binary\n"));
  const size_t start = content.find("DATA binary\n") + 12;
  ASSERT_EQ(content.size() - start, 20U);
  float row[5];
  std::memcpy(row, &content[start], sizeof(row));
  EXPECT_FLOAT_EQ(row[0], 0.15F);
  EXPECT_FLOAT_EQ(row[1], 0.25F);
  EXPECT_FLOAT_EQ(row[2], 0.35F);
  EXPECT_FLOAT_EQ(row[4], 0.9F);
}

TEST(ExportPcd, RefusesWhereFloatMixesCellsUp)
{
  const TemporaryFolder folder;
  HandMadeCells map(0.1);
  map.put({10'000'000, 0, 0}, 0.9, CellState::Occupied);
  const std::string message = messageOf([&] { exportMap(map, folder / "map.pcd"); });
  EXPECT_TRUE(contains(message, "1000000.05 m")) << message;
  EXPECT_EQ(folder.size(), 0U);
}

TEST(ExportOctomap, OtHoldsEveryCellsProbability)
{
  const TemporaryFolder folder;
  HandMadeCells map = randomCells(2);
  map.put({100, 0, 0}, 1e-6, CellState::Free)
      .put({101, 0, 0}, 1 - 1e-6, CellState::Occupied);  // beyond OctoMap's clamps
  exportMap(map, folder / "map.ot");
  const CellTable table = readCellTable(map);

  std::unique_ptr<octomap::AbstractOcTree> read(octomap::AbstractOcTree::read(folder / "map.ot"));
  auto* tree = dynamic_cast<octomap::OcTree*>(read.get());
  ASSERT_NE(tree, nullptr);
  EXPECT_EQ(tree->getResolution(), 0.05);
  for (const CellRow& row : table.rows)
  {
    const Eigen::Vector3d centre = cellCentre(row.index, 0.05);
    const auto* node = tree->search(centre.x(), centre.y(), centre.z());
    ASSERT_NE(node, nullptr);
    EXPECT_NEAR(node->getOccupancy(), row.estimate.prob, 1e-7);
    EXPECT_EQ(tree->coordToKey(centre.x()), static_cast<octomap::key_type>(row.index.x + 32768));
  }
  const CellTable back = readCellTable(folder / "map.ot");
  ASSERT_EQ(back.rows.size(), table.rows.size());
  for (size_t i = 0; i < back.rows.size(); ++i)
  {
    EXPECT_EQ(back.rows[i].index, table.rows[i].index);
    EXPECT_NEAR(back.rows[i].estimate.prob, table.rows[i].estimate.prob, 1e-7);
  }
}

TEST(ExportOctomap, BtHoldsOccupiedAndFreeCellsOnly)
{
  const TemporaryFolder folder;
  const HandMadeCells map = randomCells(3);
  exportMap(map, folder / "map.bt");
  octomap::OcTree tree(folder / "map.bt");
  EXPECT_EQ(tree.getResolution(), 0.05);
  const CellTable back = readCellTable(folder / "map.bt");
  size_t known = 0;
  for (const CellRow& row : readCellTable(map).rows)
  {
    const Eigen::Vector3d centre = cellCentre(row.index, 0.05);
    const auto* node = tree.search(centre.x(), centre.y(), centre.z());
    ASSERT_EQ(node == nullptr, row.estimate.state == CellState::Unknown);
    if (node == nullptr) continue;
    ++known;
    EXPECT_EQ(tree.isNodeOccupied(node), row.estimate.state == CellState::Occupied);
    ASSERT_NE(back.find(row.index), nullptr);
    EXPECT_EQ(back.find(row.index)->estimate.state, row.estimate.state);
  }
  EXPECT_EQ(back.rows.size(), known);
}

TEST(ExportOctomap, JoinsEqualSiblingsAndExpandsThemAgain)
{
  const TemporaryFolder folder;
  HandMadeCells map(0.1);
  for (int x = -4; x < 4; ++x)
    for (int y = -4; y < 4; ++y)
      for (int z = -4; z < 4; ++z) map.put({x, y, z}, 0.125, CellState::Free);
  exportMap(map, folder / "map.ot");
  EXPECT_LT(std::filesystem::file_size(folder / "map.ot"), 1500U);
  EXPECT_EQ(readCellTable(folder / "map.ot").rows.size(), 512U);
}

TEST(ExportOctomap, ResolutionIsExact)
{
  const TemporaryFolder folder;
  HandMadeCells map(1.0 / 7);
  map.put({20000, 1, 2}, 0.9, CellState::Occupied);
  for (const char* name : {"a.ot", "a.bt"})
  {
    exportMap(map, folder / name);
    EXPECT_EQ(readCellTable(folder / name).resolution_m, 1.0 / 7);
    EXPECT_NE(readCellTable(folder / name).find({20000, 1, 2}), nullptr);
  }
}

TEST(ExportOctomap, RefusesCellsBeyondItsKeysNamingTheExtent)
{
  const TemporaryFolder folder;
  HandMadeCells reaches(0.1);
  reaches.put({32767, 0, 0}, 0.9, CellState::Occupied).put({-32768, 0, 0}, 0.9, CellState::Occupied);
  exportMap(reaches, folder / "map.ot");
  EXPECT_EQ(readCellTable(folder / "map.ot").rows.size(), 2U);
  for (const CellIndex& cell : {CellIndex{32768, 0, 0}, {0, -32769, 0}, {0, 0, 40000}})
  {
    HandMadeCells beyond(0.1);
    beyond.put({0, 0, 0}, 0.9, CellState::Occupied).put(cell, 0.9, CellState::Occupied);
    for (const char* name : {"beyond.ot", "beyond.bt"})
    {
      const std::string message = messageOf([&] { exportMap(beyond, folder / name); });
      EXPECT_TRUE(contains(message, "32,768 cells")) << message;
      EXPECT_TRUE(contains(message, "x 0 .. 3276.9 m") || contains(message, "y -3276.9 .. 0.1 m") ||
                  contains(message, "z 0 .. 4000.1 m"))
          << message;
      EXPECT_FALSE(std::filesystem::exists(folder / name));
    }
  }
}

// A whole tree in one leaf: right by its format, but nobody can wait for 2^48 cells.
TEST(ReadOctomap, RefusesToExpandWithoutEnd)
{
  const TemporaryFolder folder;
  const std::string header = "# Octomap OcTree file\nid OcTree\nsize 1\nres 0.1\ndata\n";
  const std::string path = folder.write("one.ot", header + std::string(5, '\0'));
  EXPECT_TRUE(contains(messageOf([&] { (void)readCellTable(path); }), "2.81e+14 finest cells"));
  EXPECT_TRUE(openCellMap(path)->estimateAt({1, 2, 3})) << "a point can be asked for";
}

TEST(ReadOctomap, RefusesLogoddsThatAreNotFinite)
{
  const TemporaryFolder folder;
  for (const float bad : {std::nanf(""), HUGE_VALF, -HUGE_VALF})
  {
    octomap::OcTree tree(0.1);
    tree.updateNode(1, 2, 3, true);
    tree.search(1.0, 2.0, 3.0)->setLogOdds(bad);
    std::ostringstream text;
    tree.write(text);
    const std::string path = folder.write("bad.ot", text.str());
    EXPECT_TRUE(contains(messageOf([&] { (void)openCellMap(path); }), "bad.ot")) << bad;
    EXPECT_TRUE(contains(messageOf([&] { (void)openCellMap(path); }), "log-odds")) << bad;
  }
}

TEST(ReadOctomap, ReadsATreeWhoseHeaderStatesNoSize)
{
  const TemporaryFolder folder;
  const HandMadeCells map = randomCells(4);
  for (const std::string extension : {".ot", ".bt"})
  {
    SCOPED_TRACE(extension);
    exportMap(map, folder / ("whole" + extension));
    const std::string whole = test::fileContent(folder / ("whole" + extension));
    const size_t cells = readCellTable(folder / ("whole" + extension)).rows.size();
    ASSERT_GT(cells, 0U);
    const size_t begin = whole.find("size ");
    const size_t end = whole.find('\n', begin);
    for (const std::string& line : {std::string("#"), std::string("size"), std::string("# size 12")})
    {
      const std::string unsized = whole.substr(0, begin) + line + whole.substr(end);
      EXPECT_EQ(readCellTable(folder.write("unsized" + extension, unsized)).rows.size(), cells) << line;
      const std::string path = folder.write("cut" + extension, unsized.substr(0, unsized.size() - 3));
      EXPECT_TRUE(contains(messageOf([&] { (void)openCellMap(path); }),
                           "its header says no size, its tree does not end well"));
    }
    const std::string header = whole.substr(0, begin) + whole.substr(end + 1, whole.find("data\n") + 4 - end);
    EXPECT_EQ(readCellTable(folder.write("empty" + extension, header)).rows.size(), 0U);
  }
}

TEST(ReadOctomap, RefusesDamagedFilesByName)
{
  const TemporaryFolder folder;
  const HandMadeCells map = randomCells(4);
  for (const std::string extension : {".ot", ".bt"})
  {
    exportMap(map, folder / ("whole" + extension));
    const std::string whole = test::fileContent(folder / ("whole" + extension));
    // Cut anywhere; every bit flip of a byte in the tree. Refused, or read as some tree: never a crash.
    for (size_t length = 0; length < whole.size(); length += 97)
    {
      const std::string path = folder.write("cut" + extension, whole.substr(0, length));
      EXPECT_TRUE(contains(messageOf([&] { (void)readCellTable(path); }), "cut" + extension)) << length;
    }
    for (size_t at = whole.find("data\n") + 5; at < whole.size(); at += 13)
    {
      std::string flipped = whole;
      flipped[at] = static_cast<char>(flipped[at] ^ 0xFF);
      (void)messageOf([&] { (void)openCellMap(folder.write("flipped" + extension, flipped)); });
    }
    EXPECT_TRUE(contains(messageOf([&] { (void)openCellMap(folder.write("other" + extension, "hello\n")); }),
                         "is not an OctoMap " + extension + " file"));
    EXPECT_TRUE(
        contains(messageOf([&] { (void)openCellMap(folder / ("none" + extension)); }), "cannot be opened"));
  }
}

TEST(ExportScene, HoldsStockObjectsWithEveryOccupiedCell)
{
  const TemporaryFolder folder;
  HandMadeCells map(0.5);
  map.put({1, 2, 3}, 0.9, CellState::Occupied)
      .put({4, 4, 8}, 0.9, CellState::Occupied)
      .put({0, 0, 0}, 0.1, CellState::Free);
  exportMap(map, folder / "map.3Dscene");
  mrpt::opengl::COpenGLScene scene;
  ASSERT_TRUE(scene.loadFromFile(folder / "map.3Dscene"));
  const auto voxels = std::dynamic_pointer_cast<mrpt::opengl::COctoMapVoxels>(scene.getByName("cells"));
  ASSERT_TRUE(voxels);
  ASSERT_EQ(voxels->getVoxelCount(0), 2U);
  EXPECT_EQ(voxels->getVoxelCount(1), 0U);
  const auto centre =
      voxels->getPose() + mrpt::math::TPose3D(mrpt::math::TPoint3D(voxels->getVoxel(0, 0).coords));
  EXPECT_NEAR(centre.x, 0.75, 1e-6);
  EXPECT_NEAR(centre.y, 1.25, 1e-6);
  EXPECT_NEAR(centre.z, 1.75, 1e-6);
  EXPECT_EQ(voxels->getVoxel(0, 0).side_length, 0.5);
}

// A file holds the pose of an object as floats, which are 0.5 m apart there.
TEST(ExportScene, HoldsCellsAtTheirPlacesInUtmCoordinates)
{
  const TemporaryFolder folder;
  HandMadeCells map(0.1);
  for (int i = 0; i < 5; ++i) map.put({4481234 + i, 54123456, 3102}, 0.9, CellState::Occupied);
  exportMap(map, folder / "map.3Dscene");
  mrpt::opengl::COpenGLScene scene;
  ASSERT_TRUE(scene.loadFromFile(folder / "map.3Dscene"));
  const auto voxels = std::dynamic_pointer_cast<mrpt::opengl::COctoMapVoxels>(scene.getByName("cells"));
  ASSERT_TRUE(voxels);
  ASSERT_EQ(voxels->getVoxelCount(0), 5U);
  for (size_t i = 0; i < 5; ++i)
  {
    const auto centre =
        voxels->getPose() + mrpt::math::TPose3D(mrpt::math::TPoint3D(voxels->getVoxel(0, i).coords));
    EXPECT_NEAR(centre.x, 448123.45 + 0.1 * static_cast<double>(i), 1e-5);
    EXPECT_NEAR(centre.y, 5412345.65, 1e-5);
    EXPECT_NEAR(centre.z, 310.25, 1e-5);
  }
}

struct Pgm
{
  size_t width = 0;
  size_t height = 0;
  std::string grey;

  explicit Pgm(const std::string& path)
  {
    std::istringstream content(test::fileContent(path));
    std::string magic, comment;
    int greatest = 0;
    std::getline(content, magic);
    std::getline(content, comment);
    content >> width >> height >> greatest;
    content.get();
    grey.assign(std::istreambuf_iterator<char>(content), {});
  }
  /// From the top left.
  int at(size_t column, size_t row) const { return static_cast<unsigned char>(grey[row * width + column]); }
};

/// Occupied above free, free above nothing, unknown, two layers.
HandMadeCells smallFloor()
{
  HandMadeCells map(0.5);
  map.put({-2, 3, 0}, 0.1, CellState::Free).put({-2, 3, 1}, 0.9, CellState::Occupied);
  map.put({0, 3, 0}, 0.1, CellState::Free).put({0, 4, 1}, 0.5, CellState::Unknown);
  return map;
}

TEST(ExportRosMap, ProjectionShowsOccupiedElseFreeElseUnknown)
{
  const TemporaryFolder folder;
  exportMap(smallFloor(), folder / "floor.yaml");
  const std::string yaml = test::fileContent(folder / "floor.yaml");
  for (const char* line :
       {"image: 'floor.pgm'\n", "mode: trinary\n", "resolution: 0.5\n", "origin: [-1, 1.5, 0.0]\n",
        "negate: 0\n", "occupied_thresh: 0.65\n", "free_thresh: 0.196\n"})
    EXPECT_TRUE(contains(yaml, line)) << line << "not in\n" << yaml;
  const Pgm image(folder / "floor.pgm");
  ASSERT_EQ(image.width, 3U);
  ASSERT_EQ(image.height, 2U);
  ASSERT_EQ(image.grey.size(), 6U);
  // The top row is the greatest y.
  EXPECT_EQ(image.at(2, 0), 205);
  EXPECT_EQ(image.at(0, 0), 205);
  EXPECT_EQ(image.at(0, 1), 0);
  EXPECT_EQ(image.at(1, 1), 205);
  EXPECT_EQ(image.at(2, 1), 254);
}

// As map_server decides: p = (255 - grey) / 255; occupied if p > 0.65, free if p < 0.196.
TEST(ExportRosMap, GreysReadBackAsTheirStates)
{
  const auto p = [](int grey) { return (255 - grey) / 255.0; };
  EXPECT_GT(p(0), 0.65);
  EXPECT_LT(p(254), 0.196);
  EXPECT_GT(p(205), 0.196);
  EXPECT_LT(p(205), 0.65);
}

TEST(ExportRosMap, SliceAndLimitsTakeTheirLayersOnly)
{
  const TemporaryFolder folder;
  ExportOptions slice;
  slice.z_m = 0.3;
  exportMap(smallFloor(), folder / "low.yaml", slice);
  const Pgm low(folder / "low.pgm");
  ASSERT_EQ(low.width, 3U);
  ASSERT_EQ(low.height, 1U);
  EXPECT_EQ(low.at(0, 0), 254) << "the occupied cell stands in the layer above";

  ExportOptions above;
  above.zMin_m = 0.6;
  exportMap(smallFloor(), folder / "high.yaml", above);
  const Pgm high(folder / "high.pgm");
  EXPECT_EQ(high.at(0, 1), 0);
  EXPECT_EQ(high.at(2, 1), 205) << "the free cell lies below";

  slice.z_m = 7;
  EXPECT_TRUE(contains(messageOf([&] { exportMap(smallFloor(), folder / "none.yaml", slice); }),
                       "no cell at the heights"));
  EXPECT_FALSE(std::filesystem::exists(folder / "none.pgm"));
}

TEST(ExportRosMap, WritesBothFilesOrNone)
{
  const TemporaryFolder folder;
  std::filesystem::create_symlink("/dev/full", folder / "map.yaml");
  EXPECT_TRUE(contains(messageOf([&] { exportMap(smallFloor(), folder / "map.yaml"); }), "No space left"));
  EXPECT_FALSE(std::filesystem::exists(folder / "map.pgm"));
  folder.write("map.pgm", "of before");
  EXPECT_TRUE(contains(messageOf([&] { exportMap(smallFloor(), folder / "map.yaml"); }), "No space left"));
  EXPECT_EQ(test::fileContent(folder / "map.pgm"), "of before");
  EXPECT_EQ(folder.size(), 2U);
}

/// The map of MRPT's own in a file.
template <class Map>
std::shared_ptr<Map> stockMap(const std::string& path)
{
  return std::dynamic_pointer_cast<Map>(loadMapFile(path));
}

TEST(ExportStockMaps, AGridHoldsTheProjectionOfEachColumn)
{
  const TemporaryFolder folder;
  const HandMadeCells map = randomCells(7);
  for (const char* name : {"map.gridmap", "map.gridmap.gz"})
  {
    exportMap(map, folder / name);
    const auto grid = stockMap<mrpt::maps::COccupancyGridMap2D>(folder / name);
    ASSERT_TRUE(grid) << name;
    EXPECT_FLOAT_EQ(grid->getResolution(), 0.05F);
    size_t occupied = 0;
    for (int x = -20; x <= 20; ++x)
      for (int y = -20; y <= 20; ++y)
      {
        double mostOccupied = -1;
        double mostFree = -1;
        map.visitCells(
            [&](const CellIndex& cell, const CellEstimate& estimate)
            {
              if (cell.x != x || cell.y != y) return;
              if (estimate.state == CellState::Occupied) mostOccupied = std::max(mostOccupied, estimate.prob);
              if (estimate.state == CellState::Free) mostFree = std::max(mostFree, estimate.prob);
            });
        const double expected = mostOccupied >= 0 ? mostOccupied : mostFree >= 0 ? mostFree : 0.5;
        occupied += mostOccupied >= 0;
        const double is =
            1 - grid->getPos(static_cast<float>((x + 0.5) * 0.05), static_cast<float>((y + 0.5) * 0.05));
        EXPECT_NEAR(is, expected, 0.02) << x << " " << y;
      }
    EXPECT_GT(occupied, 50U);
  }
}

TEST(ExportStockMaps, AGridTakesASliceOrLimits)
{
  const TemporaryFolder folder;
  ExportOptions slice;
  slice.z_m = 0.3;
  exportMap(smallFloor(), folder / "low.gridmap.gz", slice);
  const auto low = stockMap<mrpt::maps::COccupancyGridMap2D>(folder / "low.gridmap.gz");
  ASSERT_TRUE(low);
  EXPECT_EQ(low->getSizeX(), 3U);
  EXPECT_EQ(low->getSizeY(), 1U);
  EXPECT_NEAR(low->getPos(-0.75F, 1.75F), 0.9, 0.02) << "the occupied cell stands in the layer above";
}

TEST(ExportStockMaps, AProjectionOfAllHeightsIsToldAndWhatHeightsThereAre)
{
  const TemporaryFolder folder;
  ExportOptions options;
  for (const char* name : {"m.yaml", "m.gridmap.gz", "m.metricmap"})
    EXPECT_TRUE(contains(remarkOn(smallFloor(), name, options), "z = 0 to 1 m")) << name;
  for (const char* name : {"m.ply", "m.pts.gz", "m.png"})
    EXPECT_EQ(remarkOn(smallFloor(), name, options), "");
  options.zMin_m = 0.5;
  EXPECT_EQ(remarkOn(smallFloor(), "m.yaml", options), "");
  options.zMin_m = 5;
  EXPECT_TRUE(contains(messageOf([&] { exportMap(smallFloor(), folder / "m.yaml", options); }),
                       "it has cells from z = 0 to 1 m"));
  EXPECT_TRUE(
      contains(messageOf([&] { exportMap(HandMadeCells(), folder / "m.yaml"); }), "the map is empty"));
  HandMadeCells flat;
  flat.put({0, 0, 3}, 0.1, CellState::Free).put({1, 0, 3}, 0.9, CellState::Occupied);
  EXPECT_EQ(remarkOn(flat, "m.yaml", {}), "") << "a planar map";
}

TEST(ExportStockMaps, PointsAreTheCentresOfOccupiedCells)
{
  const TemporaryFolder folder;
  const HandMadeCells map = randomCells(8);
  exportMap(map, folder / "map.pts.gz");
  const auto points = stockMap<mrpt::maps::CSimplePointsMap>(folder / "map.pts.gz");
  ASSERT_TRUE(points);
  size_t occupied = 0;
  map.visitCells([&](const CellIndex&, const CellEstimate& estimate)
                 { occupied += estimate.state == CellState::Occupied; });
  ASSERT_EQ(points->size(), occupied);
  for (size_t i = 0; i < points->size(); ++i)
  {
    float x = 0, y = 0, z = 0;
    points->getPoint(i, x, y, z);
    const auto there = map.estimateAt({x, y, z});
    ASSERT_TRUE(there);
    EXPECT_EQ(there->state, CellState::Occupied);
    for (const float at : {x, y, z}) EXPECT_NEAR(std::fmod(std::abs(at), 0.05F), 0.025F, 1e-5);
  }
}

TEST(ExportStockMaps, AnOctreeHoldsEachFreeAndOccupiedCell)
{
  const TemporaryFolder folder;
  const HandMadeCells map = randomCells(9);
  ExportOptions options;
  options.as = parseStockMaps("octomap");
  exportMap(map, folder / "tree.gz", options);
  const auto tree = cellsOf(loadMapFile(folder / "tree.gz"));
  ASSERT_TRUE(tree);
  EXPECT_EQ(tree->resolution(), 0.05);
  size_t expected = 0, held = 0;
  map.visitCells(
      [&](const CellIndex& cell, const CellEstimate& estimate)
      {
        const Eigen::Vector3d centre = cellCentre(cell, 0.05);
        const auto there = tree->estimateAt({centre.x(), centre.y(), centre.z()});
        ASSERT_EQ(there.has_value(), estimate.state != CellState::Unknown);
        if (there)
        {
          EXPECT_EQ(there->state, estimate.state);
        }
        expected += there.has_value();
      });
  tree->visitCells([&](const CellIndex&, const CellEstimate&) { ++held; });
  EXPECT_EQ(held, expected);
}

TEST(ExportStockMaps, AMetricmapHoldsSeveralInOrder)
{
  const TemporaryFolder folder;
  exportMap(randomCells(10), folder / "all.metricmap");
  const auto all = stockMap<mrpt::maps::CMultiMetricMap>(folder / "all.metricmap");
  ASSERT_TRUE(all);
  ASSERT_EQ(all->maps.size(), 3U);
  EXPECT_TRUE(all->mapByClass<mrpt::maps::CSimplePointsMap>());
  EXPECT_TRUE(all->mapByClass<mrpt::maps::COccupancyGridMap2D>());
  EXPECT_TRUE(all->mapByClass<mrpt::maps::COctoMap>());
  ExportOptions options;
  options.as = parseStockMaps("octomap,points");
  exportMap(randomCells(10), folder / "two.metricmap", options);
  const auto two = stockMap<mrpt::maps::CMultiMetricMap>(folder / "two.metricmap");
  ASSERT_TRUE(two);
  ASSERT_EQ(two->maps.size(), 2U);
  EXPECT_TRUE(std::dynamic_pointer_cast<mrpt::maps::COctoMap>(two->maps[0]));
}

TEST(ExportStockMaps, WhatDoesNotGoTogetherIsRefused)
{
  const TemporaryFolder folder;
  const HandMadeCells map = randomCells(11);
  ExportOptions options;
  EXPECT_TRUE(
      contains(messageOf([&] { exportMap(map, folder / "map.gz"); }), "--as grid, points or octomap"));
  options.as = parseStockMaps("points");
  EXPECT_TRUE(contains(messageOf([&] { exportMap(map, folder / "map.gridmap", options); }), "another map"));
  EXPECT_TRUE(contains(messageOf([&] { exportMap(map, folder / "map.ply", options); }), "takes no --as"));
  options.z_m = 1;
  EXPECT_TRUE(contains(messageOf([&] { exportMap(map, folder / "map.pts.gz", options); }), "takes no --z"));
  EXPECT_THROW((void)parseStockMaps("grid,grids"), UsageError);
  EXPECT_THROW((void)parseStockMaps("grid,grid"), UsageError);
  EXPECT_THROW((void)parseStockMaps(""), UsageError);
  HandMadeCells far;
  far.put({40'000'000, 0, 0}, 0.9, CellState::Occupied);
  for (const char* name : {"far.gridmap", "far.pts.gz"})
    EXPECT_TRUE(contains(messageOf([&] { exportMap(far, folder / name); }), "float coordinates")) << name;
  options = {};
  options.as = parseStockMaps("octomap");
  EXPECT_TRUE(contains(messageOf([&] { exportMap(far, folder / "far.gz", options); }), "32,768 cells"));
  EXPECT_EQ(folder.size(), 0U);
}

TEST(Export, RefusesWhatItCannotDoAndLeavesTheOldFile)
{
  const TemporaryFolder folder;
  HandMadeCells map;
  map.put({0, 0, 0}, 0.1, CellState::Free);
  EXPECT_THROW(exportMap(map, folder / "map.obj"), UsageError);
  EXPECT_TRUE(contains(messageOf([&] { exportMap(map, folder / "map.obj"); }),
                       ".csv .ply .pcd .bt .ot .3Dscene .png .yaml"));
  ExportOptions options;
  options.z_m = 1;
  EXPECT_THROW(exportMap(map, folder / "map.csv", options), UsageError);
  EXPECT_THROW((void)parseStates("occupied,fre"), UsageError);
  EXPECT_THROW((void)parseStates(""), UsageError);
  EXPECT_TRUE(contains(messageOf([&] { exportMap(map, folder / "no/such/map.csv"); }), "no/such"));

  folder.write("old.ply", "as it was");
  EXPECT_TRUE(contains(messageOf([&] { exportMap(map, folder / "old.ply"); }), "no cell of the states"));
  EXPECT_EQ(test::fileContent(folder / "old.ply"), "as it was");
  for (const char* name : {"empty.ot", "empty.bt", "empty.pcd", "empty.3Dscene", "empty.yaml", "empty.png"})
  {
    EXPECT_NE(messageOf([&] { exportMap(HandMadeCells(), folder / name); }), "") << name;
    EXPECT_FALSE(std::filesystem::exists(folder / name)) << name;
  }
  EXPECT_EQ(folder.size(), 1U);
}
}  // namespace
