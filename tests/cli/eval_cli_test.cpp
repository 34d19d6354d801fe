// lamap eval and tune as a user calls them: exit codes, and what stands on which stream.
#include <gtest/gtest.h>
#include <lamap_mrpt/files/map_file.h>
#include <lamap_mrpt/maps/CBGKMap.h>
#include <mrpt/maps/CSimplePointsMap.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "program.h"
#include "support/small_logs.h"

namespace
{
using namespace lamap;

class EvalCommand : public test::CommandLine
{
 protected:
  EvalCommand()
  {
    CBGKMap map(0.1);
    std::string truth = "x,y,z,label\n";
    for (int i = 0; i < 20; ++i)
    {
      const double x = 0.1 * i + 0.05;
      map.updateVoxel(x, 0.05, 0.05, true);
      map.updateVoxel(x, 0.55, 0.05, false);
      truth += std::to_string(x) + ",0.05,0.05,1\n" + std::to_string(x) + ",0.55,0.05,0\n";
    }
    saveMapFile(map, folder_ / "a.lamap.gz");
    saveMapFile(CBGKMap(0.1), folder_ / "empty.lamap.gz");
    saveMapFile(mrpt::maps::CSimplePointsMap(), folder_ / "points.lamap.gz");
    folder_.write("t.csv", truth);
    test::Objects log;
    for (int i = 0; i < 6; ++i)
    {
      log.push_back(test::odometry(test::at(i), 0.01 * i, 0, 0));
      log.push_back(test::laser(test::at(i), 2));
    }
    test::writeLog(folder_ / "log.rawlog", log);
  }

  int run(const std::string& arguments, const std::string& subcommand = "eval")
  {
    return CommandLine::run(subcommand + " " + arguments);
  }
};

TEST_F(EvalCommand, RefusesAMapWithoutCellsByItsClass)
{
  EXPECT_EQ(run("$/points.lamap.gz --truth $/t.csv"), 1);
  EXPECT_NE(err_.find("points.lamap.gz: its map is a mrpt::maps::CSimplePointsMap, which has no cells"),
            std::string::npos)
      << err_;
}

TEST_F(EvalCommand, ScoresSeveralMapsInOneTable)
{
  ASSERT_EQ(std::system((std::string(LAMAP_PROGRAM) + " export " + (folder_ / "a.lamap.gz") + " -o " +
                         (folder_ / "a.ot") + " > /dev/null")
                            .c_str()),
            0);
  ASSERT_EQ(
      run("$/a.lamap.gz $/a.ot --truth $/t.csv --thresholds 0.5,0.7 --roc $/r.csv --calibration $/c.csv"), 0)
      << err_;
  EXPECT_NE(out_.find("t.csv: 40 cells, 20 of them occupied"), std::string::npos) << out_;
  EXPECT_NE(out_.find("lamap::CBGKMap"), std::string::npos);
  EXPECT_NE(out_.find("octomap::OcTree"), std::string::npos);
  EXPECT_NE(out_.find("p > 0.5"), std::string::npos);
  EXPECT_EQ(err_, "");
  EXPECT_TRUE(exists("r.csv") && exists("c.csv"));
}

TEST_F(EvalCommand, GivesJson)
{
  ASSERT_EQ(run("$/a.lamap.gz --truth $/t.csv --json"), 0) << err_;
  const auto json = nlohmann::json::parse(out_);
  EXPECT_EQ(json["truth"]["cells"], 40);
  EXPECT_EQ(json["maps"][0]["all"]["auc"], 1.0);
  EXPECT_EQ(json["maps"][0]["observedShare"], 1.0);
}

TEST_F(EvalCommand, ScoresAgainstScansHeldOut)
{
  for (const std::string map : {"bgkMap", "octoMap"})
  {
    ASSERT_EQ(run("--held-out 3 -i $/log.rawlog -m " + map + " --json --max-range 5 --calibration $/c.csv"),
              0)
        << err_;
    const auto json = nlohmann::json::parse(out_);
    EXPECT_EQ(json["heldOut"]["scans"], 2);
    EXPECT_GT(json["maps"][0]["all"]["cells"], 20);
    EXPECT_GT(json["maps"][0]["all"]["auc"], 0.7);
    EXPECT_EQ(json["scoresOfReturned"]["all"]["cells"], json["maps"][0]["all"]["cells"])
        << "every ray of this log returned";
  }
  ASSERT_EQ(run("--held-out 3 -i $/log.rawlog -m bgkMap"), 0) << err_;
  EXPECT_NE(out_.find("2 scans held out, 4 in the map"), std::string::npos) << out_;
  EXPECT_NE(out_.find("without the rays that had no return"), std::string::npos) << out_;
}

TEST_F(EvalCommand, ALogThatWasCutShortIsScoredAndReported)
{
  std::filesystem::resize_file(folder_ / "log.rawlog",
                               std::filesystem::file_size(folder_ / "log.rawlog") - 20);
  EXPECT_EQ(run("--held-out 2 -i $/log.rawlog -m bgkMap"), 1);
  EXPECT_NE(out_.find("scans held out"), std::string::npos) << out_ << err_;
  EXPECT_NE(err_.find("log.rawlog"), std::string::npos) << err_;
  EXPECT_EQ(run("--held-out 2 -i $/log.rawlog -m bgkMap --allow-truncated"), 0);
}

TEST_F(EvalCommand, WrongUsageEndsWith2)
{
  for (const char* wrong :
       {"", "$/a.lamap.gz", "--truth $/t.csv", "--held-out 1 -i $/log.rawlog -m bgkMap",
        "--held-out x -i $/log.rawlog -m bgkMap", "--held-out 3 -m bgkMap", "--held-out 3 -i $/log.rawlog",
        "$/a.lamap.gz --truth $/t.csv -m bgkMap", "$/a.lamap.gz --truth $/t.csv --held-out 3 -i $/log.rawlog",
        "--held-out 3 -i $/log.rawlog -m bgkMop",
        "--held-out 3 -i $/log.rawlog -m bgkMap -s insertOpts.maxrnge=3",
        "$/a.lamap.gz --truth $/t.csv --thresholds 1.5", "$/a.lamap.gz --truth $/t.csv --thresholds nan",
        "$/a.lamap.gz --truth $/t.csv --roc $/r.gif", "--held-out 3 -i $/log.rawlog -m bgkMap --max-range -1",
        "--held-out 3 -i $/log.rawlog -m bgkMap --surface $/s.csv"})
  {
    EXPECT_EQ(run(wrong), 2) << wrong;
    EXPECT_NE(err_, "") << wrong;
    EXPECT_EQ(out_, "") << wrong;
  }
}

TEST_F(EvalCommand, WhatCannotBeScoredEndsWith1AndIsNamed)
{
  folder_.write("bad.csv", "x,y,z,label\n0.05,0.05,0.05,1\n0.15,0.05,0.05,maybe\n");
  folder_.write("far.csv", "x,y,z,label\n70.05,0.05,0.05,1\n70.15,0.05,0.05,0\n");
  folder_.write("one.csv", "x,y,z,label\n0.05,0.05,0.05,1\n0.15,0.05,0.05,1\n");
  const std::pair<const char*, const char*> cases[] = {
      {"$/a.lamap.gz --truth $/none.csv", "none.csv"},
      {"$/none.lamap.gz --truth $/t.csv", "none.lamap.gz"},
      {"$/a.lamap.gz --truth $/bad.csv", "bad.csv:3: label is 'maybe'"},
      {"$/a.lamap.gz --truth $/far.csv", "none of the cells of"},
      {"$/empty.lamap.gz --truth $/t.csv", "empty.lamap.gz: is empty"},
      {"$/a.lamap.gz --truth $/one.csv --roc $/r.csv", "no ROC curve"},
      {"$/a.lamap.gz --truth $/t.csv --roc $/no/r.csv", "does not exist"},
      {"--held-out 7 -i $/log.rawlog -m bgkMap", "6 usable scans"},
      {"--held-out 2 -i $/none.rawlog -m bgkMap", "none.rawlog"}};
  for (const auto& [arguments, message] : cases)
  {
    EXPECT_EQ(run(arguments), 1) << arguments;
    EXPECT_NE(err_.find(message), std::string::npos) << arguments << ": " << err_;
    EXPECT_EQ(out_, "") << arguments;
  }
  EXPECT_FALSE(exists("r.csv"));
  EXPECT_EQ(run("$/a.lamap.gz --truth $/one.csv"), 0) << "the other scores are given";
  EXPECT_NE(out_.find("AUC and average precision are undefined"), std::string::npos) << out_;
}

TEST_F(EvalCommand, ComparesMapsOfOneLog)
{
  ASSERT_EQ(
      run("-i $/log.rawlog -m bgkMap -m octoMap --held-out 3 -o $/page.html --roc $/roc.csv", "compare"), 0)
      << err_;
  EXPECT_NE(out_.find("ms per scan"), std::string::npos) << out_;
  EXPECT_NE(out_.find("pictures: "), std::string::npos) << out_;
  EXPECT_TRUE(exists("page.html") && exists("roc.csv"));
  ASSERT_EQ(run("-i $/log.rawlog -m bgkMap -m occupancyGrid --json", "compare"), 0) << err_;
  const auto json = nlohmann::json::parse(out_);
  EXPECT_EQ(json["maps"][1]["class"], "mrpt::maps::COccupancyGridMap2D");
  EXPECT_TRUE(json["maps"][0]["scores"].is_null());
  for (const char* wrong :
       {"", "-i $/log.rawlog -m bgkMap --roc $/r.csv", "-i $/log.rawlog -m bgkMap --max-range 3",
        "-i $/log.rawlog -m bgkMap --thresholds 0.5", "-i $/log.rawlog --held-out 3 --truth $/t.csv",
        "-i $/log.rawlog -o $/page.png"})
    EXPECT_EQ(run(wrong, "compare"), 2) << wrong << ": " << err_;
}

TEST_F(EvalCommand, NoCommandWritesOverWhatItReadsOrAFileTwice)
{
  const std::string tune = "-i $/log.rawlog -m bgkMap --held-out 3 -s insertOpts.freeWeight=0.5,1 ";
  folder_.write("c.ini", "[map]\nbgkMap_count = 1\n");
  std::filesystem::create_symlink(folder_ / "t.csv", folder_ / "link.csv");
  std::map<std::string, std::string> before;
  for (const char* file : {"log.rawlog", "t.csv", "a.lamap.gz", "c.ini"})
    before[file] = test::fileContent(folder_ / file);
  const std::pair<const char*, std::string> cases[] = {
      {"eval", "$/a.lamap.gz --truth $/t.csv --roc $/t.csv"},
      {"eval", "$/a.lamap.gz --truth $/t.csv --roc $/link.csv"},
      {"eval", "$/a.lamap.gz --truth $/t.csv --roc $/r.csv --calibration $/./r.csv"},
      {"compare", "-i $/log.rawlog -m bgkMap --truth $/t.csv --table $/t.csv"},
      {"compare", "-i $/log.rawlog -m bgkMap --held-out 3 --table $/r.csv --roc $/r.csv"},
      {"tune", tune + "-o $/log.rawlog"},
      {"tune", tune + "-c $/c.ini -o $/c.ini"},
      {"thin", "-i $/log.rawlog -o $/log.rawlog --keep-every 2"},
      {"build", "-i $/log.rawlog -m bgkMap -o $/log.rawlog"},
      {"build", "-i $/log.rawlog -c $/c.ini -o $/c.ini"},
      {"export", "$/a.lamap.gz -o $/a.lamap.gz"},
      {"render", "$/a.lamap.gz -o $/a.lamap.gz"}};
  for (const auto& [command, arguments] : cases)
  {
    EXPECT_EQ(run(arguments, command), 2) << command << " " << arguments << ": " << err_;
    const bool named = err_.find("is an input, and would be overwritten") != std::string::npos ||
                       err_.find("would be written twice") != std::string::npos;
    EXPECT_TRUE(named) << command << " " << arguments << ": " << err_;
  }
  for (const auto& [file, content] : before) EXPECT_EQ(test::fileContent(folder_ / file), content) << file;
  EXPECT_FALSE(exists("r.csv"));
  EXPECT_EQ(run("-i $/log.rawlog --onto $/a.lamap.gz -o $/a.lamap.gz", "build"), 0)
      << "a map is gone on with in its place: " << err_;
}

TEST_F(EvalCommand, TuneRanksSettingsAndSavesTheBest)
{
  const std::string log = "-i $/log.rawlog -m bgkMap --held-out 3 -s insertOpts.freeWeight=0.25,0.5,1 ";
  ASSERT_EQ(run(log + "-s insertOpts.maxRange=5 -o $/best.ini", "tune"), 0) << err_;
  EXPECT_NE(out_.find("3 settings of bgkMap, scored by 2 scans"), std::string::npos) << out_;
  EXPECT_NE(out_.find("insertOpts.freeWeight=0.25"), std::string::npos) << out_;
  EXPECT_EQ(run("-i $/log.rawlog -c $/best.ini -o $/best.lamap.gz", "build"), 0) << err_;
  ASSERT_EQ(run("-i $/log.rawlog -m octoMap --prequential -s insertOpts.probHit=0.6,0.8 --json", "tune"), 0)
      << err_;
  EXPECT_EQ(nlohmann::json::parse(out_)["scoredScans"], 5);
  for (const char* wrong :
       {"-i $/log.rawlog -m bgkMap", "-i $/log.rawlog -m bgkMap -s insertOpts.freeWeight=1",
        "-i $/log.rawlog -m bgkMap -s creationOpts.resolution=0.1,0.2",
        "-i $/log.rawlog -m bgkMap -s insertOpts.freeWeight=0.5,1 --prequential --held-out 3"})
    EXPECT_EQ(run(wrong, "tune"), 2) << wrong << ": " << err_;
}
}  // namespace
