// lamap info, query, export and render as a user calls them: exit codes, and what stands on which stream.
#include <gtest/gtest.h>
#include <lamap_mrpt/files/map_file.h>
#include <lamap_mrpt/maps/CBGKMap.h>

#include <nlohmann/json.hpp>

#include "program.h"

namespace
{
using namespace lamap;

class MapCommands : public test::CommandLine
{
 protected:
  MapCommands()
  {
    CBGKMap map(0.1);
    for (int i = 0; i < 20; ++i)
    {
      map.updateVoxel(0.1 * i + 0.05, 0.05, 0.05, true);
      map.updateVoxel(0.1 * i + 0.05, 0.55, 0.05, false);
    }
    saveMapFile(map, folder_ / "a.lamap.gz");
  }
};

TEST_F(MapCommands, InfoTellsPeopleAndScriptsTheSame)
{
  ASSERT_EQ(run("info $/a.lamap.gz"), 0) << err_;
  EXPECT_NE(out_.find("lamap::CBGKMap"), std::string::npos);
  EXPECT_NE(out_.find("insertOpts.kernelSupport"), std::string::npos);
  ASSERT_EQ(run("info --json $/a.lamap.gz"), 0) << err_;
  const auto json = nlohmann::json::parse(out_);
  EXPECT_EQ(json["resolution"], 0.1);
  EXPECT_GE(json["cells"]["occupied"], 20);
  EXPECT_EQ(err_, "");
}

TEST_F(MapCommands, QueryAnswersEveryPointInItsOrder)
{
  ASSERT_EQ(run("query $/a.lamap.gz --at 0.05,0.05,0.05 --at -5,-5,-5"), 0) << err_;
  EXPECT_EQ(out_.rfind("x,y,z,prob,variance,state,alpha,beta\n0.05,0.05,0.05,0.", 0), 0U) << out_;
  EXPECT_NE(out_.find(",occupied,"), std::string::npos);
  EXPECT_NE(out_.find("\n-5,-5,-5,,,unobserved,,\n"), std::string::npos) << out_;

  folder_.write("points.txt", "# two\n0.05 0.05 0.05\n0.05 0.55 0.05\n");
  ASSERT_EQ(run("query --json --points $/points.txt $/a.lamap.gz"), 0) << err_;
  const auto answers = nlohmann::json::parse(out_);
  ASSERT_EQ(answers.size(), 2U);
  EXPECT_EQ(answers[0]["state"], "occupied");
  EXPECT_EQ(answers[1]["state"], "free");
  ASSERT_EQ(run("query $/a.lamap.gz --points - "), 0) << "an empty input has no points";
  EXPECT_NE(err_.find("the standard input holds no point"), std::string::npos) << err_;
  for (const char* empty : {"", "x,y,z\n", "# nothing\n\n"})
  {
    folder_.write("empty.csv", empty);
    EXPECT_EQ(run("query $/a.lamap.gz --points $/empty.csv"), 1) << empty;
    EXPECT_NE(err_.find("empty.csv: holds no point"), std::string::npos) << err_;
  }
}

TEST_F(MapCommands, MrptIsLoadedOnlyWhereACommandIsRun)
{
  for (const char* arguments : {"--version", "--help", "build --help", "", "biuld", "build",
                                "query --at 0,0,0", "render $/a.lamap.gz -o $/a.png --view side", "run"})
  {
    const std::string libraries = librariesOf(arguments);
    EXPECT_NE(libraries.find("libstdc++"), std::string::npos) << arguments;
    EXPECT_EQ(libraries.find("libmrpt"), std::string::npos) << arguments;
  }
  EXPECT_NE(librariesOf("info $/a.lamap.gz").find("libmrpt-maps"), std::string::npos);
}

TEST_F(MapCommands, OutputThatIsLostIsNoSuccess)
{
  std::string points = "x,y,z\n";
  for (int i = 0; i < 2000; ++i) points += "0.05,0.05,0.05\n";
  folder_.write("points.csv", points);
  folder_.write("truth.csv", "x,y,z,label\n0.05,0.05,0.05,1\n0.05,0.55,0.05,0\n");
  for (const char* arguments :
       {"query $/a.lamap.gz --points $/points.csv", "query $/a.lamap.gz --at 0,0,0",
        "query --json $/a.lamap.gz --at 0,0,0", "info $/a.lamap.gz", "info --json $/a.lamap.gz",
        "eval $/a.lamap.gz --truth $/truth.csv", "eval --json $/a.lamap.gz --truth $/truth.csv", "--help",
        "info --help", "--version"})
  {
    EXPECT_EQ(runIntoFullDisk(arguments), 1) << arguments;
    EXPECT_NE(err_.find("standard output"), std::string::npos) << arguments << err_;
  }
  for (const char* name : {"f.csv", "f.ply", "f.pcd", "f.ot", "f.bt", "f.3Dscene", "f.png"})
  {
    std::filesystem::create_symlink("/dev/full", folder_ / name);
    EXPECT_EQ(run(std::string("export $/a.lamap.gz -o $/") + name), 1) << name << err_;
  }
  EXPECT_EQ(run("render $/a.lamap.gz -o $/f.png"), 1) << err_;
}

TEST_F(MapCommands, QueryNamesTheBadLineAndAnswersNothing)
{
  folder_.write("points.txt", "1,2,3\n1,2,three\n");
  EXPECT_EQ(run("query $/a.lamap.gz --points $/points.txt"), 1);
  EXPECT_NE(err_.find("points.txt:2: z is 'three'"), std::string::npos) << err_;
  EXPECT_EQ(out_, "");
}

TEST_F(MapCommands, ExportWritesEveryFormat)
{
  for (const char* name : {"m.csv", "m.ply", "m.pcd", "m.bt", "m.ot", "m.3Dscene", "m.png", "m.yaml"})
  {
    EXPECT_EQ(run(std::string("export $/a.lamap.gz -o $/") + name), 0) << name << ": " << err_;
    EXPECT_TRUE(exists(name)) << name;
  }
  EXPECT_TRUE(exists("m.pgm"));
  EXPECT_EQ(run("info $/m.ot"), 0) << err_;
  EXPECT_EQ(run("query $/m.bt --at 0.05,0.05,0.05"), 0) << err_;
  EXPECT_EQ(run("export $/m.ot -o $/again.csv"), 0) << err_;
}

TEST_F(MapCommands, RenderDrawsEveryViewWithoutADisplay)
{
  unsetenv("DISPLAY");
  for (const char* view : {"top", "slice", "3d"})
    EXPECT_EQ(
        run(std::string("render $/a.lamap.gz --size 640x480 --view ") + view + " -o $/" + view + ".png"), 0)
        << err_;
  EXPECT_TRUE(exists("3d.png"));
}

TEST_F(MapCommands, WrongUsageEndsWith2)
{
  for (const char* wrong :
       {"info", "query $/a.lamap.gz", "query $/a.lamap.gz --at 1,2",
        "query $/a.lamap.gz --at 1,2,3 --points x", "export $/a.lamap.gz", "export $/a.lamap.gz -o $/m.obj",
        "export $/a.lamap.gz -o $/m.csv --states most", "render $/a.lamap.gz -o $/m.png --azimuth 30",
        "render $/a.lamap.gz -o $/m.png --view slice --elevation 30",
        "export $/a.lamap.gz -o $/m.yaml --z-min 2 --z-max 1", "render $/a.lamap.gz -o $/m.png --view side",
        "render $/a.lamap.gz -o $/m.png --size 7", "render $/a.lamap.gz -o $/m.gif",
        "render $/a.lamap.gz -o $/m.png --view slice --z nan"})
  {
    EXPECT_EQ(run(wrong), 2) << wrong;
    EXPECT_NE(err_, "") << wrong;
  }
  EXPECT_FALSE(exists("m.png"));
  EXPECT_FALSE(exists("m.csv"));
}

TEST_F(MapCommands, NamesCannotCommandTheTerminal)
{
  const std::string name =
      "a\x1b[31m\x7f\xc2\x9b"
      "b\xc3\xa9\xc2\xb0.ot";
  EXPECT_EQ(run("info '" + name + "'"), 1);
  EXPECT_NE(err_.find("a\\x1b[31m\\x7f\\x9b"
                      "b\xc3\xa9\xc2\xb0.ot: "),
            std::string::npos)
      << err_;
  std::filesystem::copy_file(folder_ / "a.lamap.gz", folder_ / "b\rc.lamap.gz");
  ASSERT_EQ(run("info '$/b\rc.lamap.gz'"), 0) << err_;
  EXPECT_NE(out_.find("/b\\x0dc.lamap.gz\n"), std::string::npos) << out_;
}

TEST_F(MapCommands, MissingAndForeignFilesEndWith1AndAreNamed)
{
  folder_.write("text.lamap.gz", "this is no map");
  folder_.write("text.ot", "this is no tree");
  for (const char* command :
       {"info $/none.lamap.gz", "query $/none.ot --at 1,2,3", "export $/text.lamap.gz -o $/m.csv",
        "render $/text.ot -o $/m.png", "export $/a.lamap.gz -o $/no/such/m.csv"})
  {
    EXPECT_EQ(run(command), 1) << command;
    EXPECT_TRUE(err_.find("none") != std::string::npos || err_.find("text") != std::string::npos ||
                err_.find("no/such") != std::string::npos)
        << command << ": " << err_;
    EXPECT_EQ(out_, "") << command;
  }
  EXPECT_FALSE(exists("m.csv"));
  EXPECT_FALSE(exists("m.png"));
}
}  // namespace
