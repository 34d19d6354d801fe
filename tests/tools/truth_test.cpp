#include <gtest/gtest.h>
#include <lamap_tools/cells/octomap_file.h>
#include <lamap_tools/cells/truth.h>
#include <lamap_tools/files/file_input.h>

#include <sstream>
#include <stdexcept>

#include "support/temporary_folder.h"
#include "tools/hand_made_cells.h"

namespace
{
using namespace lamap;
using namespace lamap::tools;

Truth truth(const std::string& text)
{
  std::istringstream in(text);
  return readTruthCsv(in, "t.csv");
}

std::string errorOf(const std::string& text)
{
  try
  {
    (void)truth(text);
  }
  catch (const std::runtime_error& error)
  {
    return error.what();
  }
  return "";
}

TEST(TruthCsv, TakesColumnsInAnyOrderOrNoHeader)
{
  const std::string lines[] = {
      "x,y,z,label\n0.05,0.15,-0.25,1\n0.15,0.15,-0.25,0\n",
      "\xEF\xBB\xBFlabel,name,z,y,x\r\n1,a,-0.25,0.15,0.05\r\n0,b,-0.25,0.15,0.15\r\n",
      "# four numbers\n0.05, 0.15 ,-0.25,1\n\n+0.15,1.5e-1,-0.25,0"};
  for (const std::string& text : lines)
  {
    const Truth cells = truth(text);
    ASSERT_EQ(cells.cells.size(), 2U) << text;
    EXPECT_EQ(cells.cells[0].centre_map, Eigen::Vector3d(0.05, 0.15, -0.25));
    EXPECT_TRUE(cells.cells[0].occupied);
    EXPECT_FALSE(cells.cells[1].occupied);
    EXPECT_EQ(cells.occupiedCount(), 1U);
    EXPECT_NEAR(*cells.spacing_m, 0.1, 1e-12);
    EXPECT_TRUE(cells.isOneLayer());
  }
}

TEST(TruthCsv, NamesTheBadLine)
{
  EXPECT_EQ(errorOf("x,y,z,label\n1,2,3\n"), "t.csv:2: has 3 fields, expected 4 (x,y,z,label)");
  EXPECT_EQ(errorOf("x,y,z,label\n\n1,b,3,0\n"), "t.csv:3: y is 'b', expected a finite number [m]");
  EXPECT_EQ(errorOf("1,2,3,0\n1,2,inf,0\n"), "t.csv:2: z is 'inf', expected a finite number [m]");
  EXPECT_EQ(errorOf("1,2,3,0\n1,2,4,2\n"), "t.csv:2: label is '2', expected 1 (occupied) or 0 (free)");
  EXPECT_EQ(errorOf("1,2,3,0\n1,2,4,\n"), "t.csv:2: label is '', expected 1 (occupied) or 0 (free)");
  EXPECT_EQ(errorOf("x,y,z,prob\n1,2,3,0\n"),
            "t.csv:1: the header names no column label, expected x,y,z,label");
  EXPECT_EQ(errorOf("x,y,z,label\n1,2,3,0\n2,2,3,0\n1,2,3,1\n"),
            "t.csv:4: the cell stands in line 2 already");
  EXPECT_EQ(errorOf("x,y,z,label\n"), "t.csv: holds no cell; expected lines x,y,z,label");
}

TEST(Truth, KnowsOnWhichGridItIs)
{
  const Truth cells = truth("0.05,0.05,0.05,1\n0.15,0.05,0.05,0\n0.15,0.25,0.35,0\n");
  EXPECT_TRUE(cells.isOnGrid(0.1));
  EXPECT_FALSE(cells.isOnGrid(0.2));
  EXPECT_FALSE(cells.isOnGrid(0.05));
  EXPECT_FALSE(truth("0,0,0,1\n0.1,0,0.1,0\n").isOnGrid(0.1)) << "corners are no centres";
  EXPECT_TRUE(truth("0.05,0.05,0,1\n0.15,0.05,0,0\n").isOnGrid(0.1))
      << "of one layer the height does not count";
  EXPECT_FALSE(truth("0.05,0.05,0.05,1\n").spacing_m.has_value());
}

TEST(Truth, IsReadFromMapsToo)
{
  const test::TemporaryFolder folder;
  test::HandMadeCells map(0.5);
  map.put({3, -2, 1}, 0.9, CellState::Occupied).put({0, 0, 0}, 0.1, CellState::Free);
  map.put({5, 5, 5}, 0.5, CellState::Unknown);
  writeOctomapFile(map, folder / "t.bt");
  const Truth cells = readTruth(folder / "t.bt");
  ASSERT_EQ(cells.cells.size(), 2U);
  EXPECT_EQ(cells.spacing_m, 0.5);
  EXPECT_EQ(cells.occupiedCount(), 1U);
  for (const TrueCell& cell : cells.cells)
    EXPECT_EQ(cell.centre_map,
              cell.occupied ? Eigen::Vector3d(1.75, -0.75, 0.75) : Eigen::Vector3d(0.25, 0.25, 0.25));
}

TEST(Truth, MissingFilesAndFoldersAreNamed)
{
  const test::TemporaryFolder folder;
  for (const std::string& path : {folder / "none.csv", folder / "none.bt", folder.path()})
  {
    try
    {
      (void)readTruth(path);
      ADD_FAILURE() << path;
    }
    catch (const std::runtime_error& error)
    {
      EXPECT_NE(std::string(error.what()).find(path), std::string::npos) << error.what();
    }
  }
}

TEST(FileInput, SaysWhyAFileIsNotOpened)
{
  const test::TemporaryFolder folder;
  const auto complaint = [](const std::string& path)
  {
    try
    {
      (void)openedFile(path, "a truth");
    }
    catch (const std::runtime_error& error)
    {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(complaint(folder.path()), folder.path() + ": is a folder, not a truth");
  EXPECT_EQ(complaint(folder / "none"), folder / "none" + ": cannot be opened: No such file or directory");
  EXPECT_EQ(complaint(folder.write("t.csv", "1")), "");
}
}  // namespace
