// Inputs that claim too much: what is refused is refused before work, and one bad scan does not end a run.
#include <gtest/gtest.h>
#include <lamap_tools/cells/cell_map.h>
#include <lamap_tools/commands/map_build.h>
#include <lamap_tools/commands/map_info.h>

#include <chrono>
#include <cstdlib>
#include <random>
#include <sstream>

#include "support/temporary_folder.h"

namespace
{
using namespace lamap;
using namespace lamap::tools;
using lamap::test::TemporaryFolder;

/// A .bt of one leaf below so many inner nodes: it stands for 8^(16 − depth) cells.
std::string oneLeaf(int depth, const std::string& resolution = "0.1")
{
  std::string file = "# Octomap OcTree binary file\nid OcTree\nsize " + std::to_string(depth + 1) + "\nres " +
                     resolution + "\ndata\n";
  for (int level = 0; level + 1 < depth; ++level) file += std::string("\x03\x00", 2);
  return file + std::string("\x01\x00", 2);  // the first child is a leaf
}

TEST(OctreeLimits, WhatInfoCostsDoesNotGrowWithTheSizeOfLeaves)
{
  const TemporaryFolder folder;
  const auto begin = std::chrono::steady_clock::now();
  for (const int depth : {1, 5, 12})
  {
    SCOPED_TRACE(depth);
    const MapInfo info = readMapInfo(folder.write("leaf.bt", oneLeaf(depth)));
    ASSERT_TRUE(info.cells);
    EXPECT_EQ(info.cells->observed(), uint64_t{1} << (3 * (16 - depth)));
    const int32_t edge = 1 << (16 - depth);
    ASSERT_TRUE(info.cells->extent);
    EXPECT_EQ(info.cells->extent->first, (CellIndex{-32768, -32768, -32768}));
    EXPECT_EQ(info.cells->extent->last, (CellIndex{-32769 + edge, -32769 + edge, -32769 + edge}));
  }
  EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(), 10);
}

TEST(OctreeLimits, TooManyCellsAreNotReadOneByOne)
{
  const TemporaryFolder folder;
  size_t visited = 0;
  for (const int depth : {5, 9})  // 2^33 and 2^21 cells
  {
    const auto huge = openCellMap(folder.write("leaf.bt", oneLeaf(depth)));
    try
    {
      huge->visitCells([&](const CellIndex&, const CellEstimate&) { ++visited; });
      FAIL() << depth;
    }
    catch (const std::runtime_error& error)
    {
      EXPECT_NE(std::string(error.what()).find("LAMAP_MAX_CELLS"), std::string::npos) << error.what();
      EXPECT_EQ(std::string(error.what()).rfind(folder / "leaf.bt: ", 0), 0u) << error.what();
    }
    EXPECT_EQ(visited, 0u);
  }
  const auto small = openCellMap(folder.write("small.bt", oneLeaf(13)));
  small->visitCells([&](const CellIndex&, const CellEstimate&) { ++visited; });
  EXPECT_EQ(visited, 512u);
  setenv("LAMAP_MAX_CELLS", "511", 1);
  EXPECT_THROW(small->visitCells([](const CellIndex&, const CellEstimate&) {}), std::runtime_error);
  setenv("LAMAP_MAX_CELLS", "many", 1);
  EXPECT_THROW(small->visitCells([](const CellIndex&, const CellEstimate&) {}), std::runtime_error);
  setenv("LAMAP_MAX_CELLS", "512", 1);
  EXPECT_NO_THROW(small->visitCells([](const CellIndex&, const CellEstimate&) {}));
  unsetenv("LAMAP_MAX_CELLS");
}

TEST(OctreeLimits, ResolutionsThatCellsCannotHaveAreRefused)
{
  const TemporaryFolder folder;
  for (const char* resolution : {"1e-300", "1e-7", "0", "-1", "nan", "inf", "1e300"})
    EXPECT_THROW((void)openCellMap(folder.write("a.bt", oneLeaf(13, resolution))), std::runtime_error)
        << resolution;
  const auto map = openCellMap(folder.write("a.bt", oneLeaf(13, "1e-6")));
  for (const double far : {0.0, 1.0, 1e10, -1e10, 1e300, -1e300})
    EXPECT_FALSE(map->estimateAt({far, far, far})) << far;
  EXPECT_TRUE(map->estimateAt({-0.032767, -0.032767, -0.032767}));
}

/// Points around the origin, as an ASCII PCD.
std::string cloud(double reach_m, int count)
{
  std::mt19937 generator(5);
  std::uniform_real_distribution<double> coordinate(-reach_m, reach_m);
  std::ostringstream out;
  out << "VERSION .7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nCOUNT 1 1 1\nWIDTH " << count
      << "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " << count << "\nDATA ascii\n";
  for (int i = 0; i < count; ++i)
  {
    const double x = coordinate(generator);
    const double y = coordinate(generator);
    out << x << " " << y << " " << coordinate(generator) << "\n";
  }
  return out.str();
}

BuildOptions optionsFor(const std::string& kind, const std::string& input, const std::string& out)
{
  BuildOptions options;
  options.inputs.paths = {input};
  options.map.mapName = kind;
  options.outPath = out;
  options.threads = 1;
  return options;
}

TEST(BuildStrictly, OneScanThatCannotBeLearnedIsLeftOutByName)
{
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "clouds");
  folder.write("clouds/0.pcd", cloud(2, 50));
  folder.write("clouds/1.pcd", cloud(1800, 3000));
  folder.write("clouds/2.pcd", cloud(3, 50));
  for (const std::string kind : {"bgkMap", "hilbertMap", "overlappingHilbertMap", "gpMap"})
  {
    SCOPED_TRACE(kind);
    BuildOptions options = optionsFor(kind, folder / "clouds", folder / (kind + ".lamap.gz"));
    const BuildReport report = buildMap(options);
    EXPECT_TRUE(report.saved);
    EXPECT_EQ(report.scans.usedCount(), 2u);
    EXPECT_EQ(report.scans.failed, 1u);
    std::ostringstream text;
    printReport(report, text);
    EXPECT_NE(text.str().find("left out: 1 PCD file: " + (folder / "clouds/1.pcd")), std::string::npos)
        << text.str();
    EXPECT_TRUE(std::filesystem::exists(options.outPath));

    options.strict = true;
    options.outPath = folder / "strict.lamap.gz";
    EXPECT_THROW((void)buildMap(options), std::runtime_error);
    EXPECT_FALSE(std::filesystem::exists(options.outPath));
  }
}

TEST(BuildReports, RaysThatAreTooLongAndWhatToSet)
{
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "clouds");
  folder.write("clouds/0.pcd", cloud(2, 50));
  folder.write("clouds/1.pcd", cloud(20000, 20));
  for (const std::string kind : {"bgkMap", "hilbertMap", "overlappingHilbertMap", "gpMap"})
  {
    SCOPED_TRACE(kind);
    const BuildReport report = buildMap(optionsFor(kind, folder / "clouds", folder / (kind + ".lamap.gz")));
    EXPECT_TRUE(report.saved);
    EXPECT_EQ(report.rays.tooLong, 20u);
    std::ostringstream text;
    printReport(report, text);
    EXPECT_NE(text.str().find("rays not used: 20 longer than 32768 cells, up to "), std::string::npos)
        << text.str();
    EXPECT_NE(text.str().find(" m; set maxRange, or a larger resolution"), std::string::npos) << text.str();
    EXPECT_EQ(reportJson(report)["rays"]["too_long"], 20);
  }
}

TEST(BuildStrictly, StopsAtAFileThatCannotBeRead)
{
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "clouds");
  folder.write("clouds/0.pcd", cloud(2, 50));
  folder.write("clouds/1.pcd", "no cloud");
  BuildOptions options = optionsFor("bgkMap", folder / "clouds", folder / "map.lamap.gz");
  options.strict = true;
  EXPECT_THROW((void)buildMap(options), std::runtime_error);
  EXPECT_FALSE(std::filesystem::exists(options.outPath));
  options.strict = false;
  EXPECT_TRUE(buildMap(options).saved);
}
}  // namespace
