#include <gtest/gtest.h>
#include <lamap_mrpt/files/map_file.h>
#include <lamap_mrpt/maps/CBGKMap.h>
#include <lamap_tools/commands/map_info.h>
#include <lamap_tools/commands/query_map.h>
#include <lamap_tools/files/point_list.h>
#include <lamap_tools/files/usage_error.h>
#include <mrpt/maps/CSimplePointsMap.h>

#include <sstream>

#include "support/temporary_folder.h"
#include "tools/hand_made_cells.h"

namespace
{
using namespace lamap;
using namespace lamap::tools;
using mrpt::math::TPoint3D;
using test::HandMadeCells;

std::vector<TPoint3D> points(const std::string& text)
{
  std::istringstream in(text);
  return readPoints(in, "p.txt");
}

std::string errorOf(const std::string& text)
{
  try
  {
    (void)points(text);
  }
  catch (const std::runtime_error& error)
  {
    return error.what();
  }
  return "";
}

TEST(ReadPoints, TakesCommasSemicolonsBlanksCommentsAndEmptyLines)
{
  const std::vector<TPoint3D> expected = {{1, 2, 3}, {-1.5, 2e3, 0.25}, {4, 5, 6}};
  EXPECT_EQ(points("1,2,3\n# a comment\n\n -1.5 ; +2e3 ;0.25\r\n4\t5  6"), expected);
  EXPECT_TRUE(points("").empty());
}

TEST(ReadPoints, HeaderNamesTheColumns)
{
  const std::vector<TPoint3D> expected = {{1, 2, 3}};
  EXPECT_EQ(points("# as exported\nx,y,z,prob,variance,state\n1,2,3,0.5,,free\n"), expected);
  EXPECT_EQ(points("label,z,y,x\n0,3,2,1\n"), expected);
}

TEST(ReadPoints, NamesTheBadLine)
{
  EXPECT_EQ(errorOf("1,2,3\n# c\n1,2\n"), "p.txt:3: has 2 fields, expected x,y,z");
  EXPECT_EQ(errorOf("1,2,3\n1,b,3\n"), "p.txt:2: y is 'b', expected a finite number [m]");
  EXPECT_EQ(errorOf("1,2,nan\n"), "p.txt:1: z is 'nan', expected a finite number [m]");
  EXPECT_EQ(errorOf("1,2,3,4\n"), "p.txt:1: has 4 fields, expected x,y,z");
  EXPECT_EQ(errorOf("1,2,3\nx,y,z\n"), "p.txt:2: x is 'x', expected a finite number [m]");
  EXPECT_NE(errorOf("east,north,up\n1,2,3\n"), "");
}

TEST(ParsePoint, RefusesWhatIsNoPoint)
{
  EXPECT_EQ(parsePoint("1,-2.5,3"), TPoint3D(1, -2.5, 3));
  for (const char* text : {"", "1,2", "1,2,3,4", "1,2,x", "inf,0,0", "1,,2"})
    EXPECT_THROW((void)parsePoint(text), UsageError) << text;
}

HandMadeCells twoCells()
{
  HandMadeCells map(0.5);
  map.put({0, 0, 0}, 0.75, CellState::Occupied, 0.0625).put({1, 0, 0}, 0.25, CellState::Free);
  return map;
}

TEST(Query, AnswersAsCsv)
{
  std::ostringstream out;
  writeAnswersCsv(twoCells(), {{0.1, 0.1, 0.1}, {0.5, 0, 0}, {-0.1, 0, 0}}, out);
  EXPECT_EQ(out.str(),
            "x,y,z,prob,variance,state,alpha,beta\n"
            "0.1,0.1,0.1,0.75,0.0625,occupied,7.5,2.5\n"
            "0.5,0,0,0.25,,free,2.5,7.5\n"
            "-0.1,0,0,,,unobserved,,\n");
}

TEST(Query, AnswersAsJson)
{
  const auto answers = answersJson(twoCells(), {{0.1, 0.1, 0.1}, {-0.1, 0, 0}});
  ASSERT_EQ(answers.size(), 2U);
  EXPECT_EQ(answers[0]["prob"], 0.75);
  EXPECT_EQ(answers[0]["variance"], 0.0625);
  EXPECT_EQ(answers[0]["alpha"], 7.5);
  EXPECT_EQ(answers[1]["state"], "unobserved");
  EXPECT_TRUE(answers[1]["prob"].is_null());
  EXPECT_TRUE(answers[1]["alpha"].is_null());
}

TEST(Info, CountsCellsAndSumsEvidence)
{
  const CellSummary summary = summarizeCells(twoCells());
  EXPECT_EQ(summary.occupied, 1U);
  EXPECT_EQ(summary.free, 1U);
  EXPECT_EQ(summary.unknown, 0U);
  EXPECT_DOUBLE_EQ(summary.evidenceSums[0], 10.0);
  EXPECT_EQ(summary.extent->last, (CellIndex{1, 0, 0}));
}

TEST(Info, JsonHasEveryOptionAndNumbersAsNumbers)
{
  const test::TemporaryFolder folder;
  CBGKMap map(0.2);
  map.insertionOptions.maxRange = 12.5;
  map.updateVoxel(1, 1, 1, true);
  saveMapFile(map, folder / "a.lamap.gz");
  const MapInfo info = readMapInfo(folder / "a.lamap.gz");
  const auto json = mapInfoJson(info);
  EXPECT_EQ(json["class"], "lamap::CBGKMap");
  EXPECT_EQ(json["alias"], "bgkMap");
  EXPECT_EQ(json["resolution"], 0.2);
  EXPECT_TRUE(json["formatVersion"].is_number_integer());
  EXPECT_EQ(json["options"]["insertOpts"]["maxRange"], 12.5);
  EXPECT_EQ(json["options"]["creationOpts"]["planar"], false);
  EXPECT_EQ(json["options"]["creationOpts"]["pruning"], "lossless");
  size_t options = 0;
  for (const auto& group : json["options"]) options += group.size();
  EXPECT_EQ(options, map.optionValues().size());
  EXPECT_GT(json["cells"]["observed"], 0);
  std::ostringstream text;
  printMapInfo(info, text);
  EXPECT_NE(text.str().find("insertOpts.maxRange"), std::string::npos);
}

TEST(Info, EmptyMapAndForeignMapAreDescribed)
{
  const test::TemporaryFolder folder;
  saveMapFile(CBGKMap(), folder / "empty.lamap.gz");
  const auto empty = mapInfoJson(readMapInfo(folder / "empty.lamap.gz"));
  EXPECT_EQ(empty["cells"]["observed"], 0);
  EXPECT_TRUE(empty["extent"].is_null());

  mrpt::maps::CSimplePointsMap cloud;
  cloud.insertPoint(1, 2, 3);
  saveMapFile(cloud, folder / "points.lamap.gz");
  const auto foreign = mapInfoJson(readMapInfo(folder / "points.lamap.gz"));
  EXPECT_EQ(foreign["class"], "mrpt::maps::CSimplePointsMap");
  EXPECT_EQ(foreign["facts"]["points"], 1);
  EXPECT_FALSE(foreign.contains("cells"));
}
}  // namespace
