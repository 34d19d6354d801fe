// lamap simulate as a user calls it: exit codes, what is written and what is not.
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "program.h"

namespace
{
using namespace lamap::test;

class SimulateCommand : public testing::Test
{
 protected:
  [[nodiscard]] Program start(const std::vector<std::string>& arguments) const
  {
    return {streams_, arguments};
  }
  [[nodiscard]] Outcome run(const std::vector<std::string>& arguments) const
  {
    return start(arguments).wait();
  }

  TemporaryFolder folder_;
  TemporaryFolder streams_;
};

TEST_F(SimulateCommand, WritesALogThatBuildAndEvalTake)
{
  const Outcome outcome = run({"simulate", "structured", "-o", folder_ / "a.rawlog", "--truth",
                               folder_ / "a.csv", "--truth", folder_ / "a.bt", "--seed", "3", "--range-noise",
                               "0.01", "--pose-noise", "0.01,0.5", "--scans", "6"});
  ASSERT_EQ(outcome.exitCode, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("structured, seed 3: 6 scans of a sector-laser up to 8 m"), std::string::npos)
      << outcome.out;
  EXPECT_EQ(folder_.size(), 5U);
  const Outcome built = run({"build", "-i", folder_ / "a.rawlog", "-c", folder_ / "a.ini", "-m", "bgkMap",
                             "--poses", folder_ / "a.tum", "-o", folder_ / "a.lamap.gz"});
  EXPECT_EQ(built.exitCode, 0) << built.err;
  EXPECT_NE(built.out.find("6 CObservationPointCloud"), std::string::npos) << built.out;
  const Outcome scored = run({"eval", folder_ / "a.lamap.gz", "--truth", folder_ / "a.csv"});
  EXPECT_EQ(scored.exitCode, 0) << scored.err;
}

TEST_F(SimulateCommand, ATruthOfSurfacesScoresTheShapeOfMaps)
{
  const Outcome outcome = run({"simulate", "poles", "-o", folder_ / "a.rawlog", "--truth", folder_ / "a.csv",
                               "--truth-of", "surfaces", "--surface", folder_ / "s.csv", "--scans", "6",
                               "--missing", "0.1", "--missing-as", "nan", "--missing-burst", "9"});
  ASSERT_EQ(outcome.exitCode, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("truth of surfaces: "), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find(" got lost"), std::string::npos) << outcome.out;
  for (const std::string map : {"octoMap", "bgkMap"})
  {
    const std::string file = folder_ / (map == "octoMap" ? "a.ot" : "a.lamap.gz");
    ASSERT_EQ(
        run({"build", "-i", folder_ / "a.rawlog", "-c", folder_ / "a.ini", "-m", map, "-o", file}).exitCode,
        0);
  }
  const Outcome scored = run({"eval", folder_ / "a.lamap.gz", folder_ / "a.ot", "--truth", folder_ / "a.csv",
                              "--surface", folder_ / "s.csv", "--json"});
  ASSERT_EQ(scored.exitCode, 0) << scored.err;
  const auto maps = nlohmann::json::parse(scored.out).at("maps");
  for (const auto& map : maps)
  {
    const auto& shape = map.at("geometry");
    EXPECT_EQ(shape.at("distancesTo"), "points");
    EXPECT_GT(shape.at("covered"), 0.5);
    EXPECT_LT(shape.at("meanDistance"), 0.1);
  }
  // OctoMap's occupied cells are those in which rays ended, all of them on surfaces.
  EXPECT_LT(maps.at(1).at("geometry").at("distance95"), 0.0867) << "half the diagonal of a cell";
  const Outcome compared = run({"compare", "-i", folder_ / "a.rawlog", "-c", folder_ / "a.ini", "-m",
                                "octoMap", "--truth", folder_ / "a.csv", "--surface", folder_ / "s.csv"});
  EXPECT_EQ(compared.exitCode, 0) << compared.err;
  EXPECT_NE(compared.out.find("surface called free"), std::string::npos) << compared.out;
}

TEST_F(SimulateCommand, WrongUsageEndsWith2AndWritesNothing)
{
  const std::string out = folder_ / "a.rawlog";
  const std::vector<std::pair<std::vector<std::string>, std::string>> wrong{
      {{"simulate"}, "world"},
      {{"simulate", "structured"}, "--output"},
      {{"simulate", "atlantis", "-o", out}, "flatland"},
      {{"simulate", "coridor", "-o", out}, "corridor"},
      {{"simulate", "structured", "-o", folder_ / "a.txt"}, ".rawlog"},
      {{"simulate", "structured", "-o", out, "--sensor", "sonr"}, "sonar"},
      {{"simulate", "structured", "-o", out, "--scans", "0"}, "--scans 0"},
      {{"simulate", "structured", "-o", out, "--scans", "2.5"}, "--scans"},
      {{"simulate", "structured", "-o", out, "--resolution", "nan"}, "--resolution nan"},
      {{"simulate", "structured", "-o", out, "--resolution", "-1"}, "--resolution -1"},
      {{"simulate", "structured", "-o", out, "--at", "-0.4,1,0.5"}, "stand"},
      {{"simulate", "structured", "-o", out, "--seed", "-1"}, "--seed"},
      {{"simulate", "structured", "-o", out, "--truth-depth", "0.5"}, "--truth FILE"},
      {{"simulate", "structured", "-o", out, "--truth-of", "surfaces"}, "--truth FILE"},
      {{"simulate", "structured", "-o", out, "--missing-as", "nan"}, "--missing SHARE"},
      {{"simulate", "structured", "-o", out, "--missing-burst", "4"}, "--missing SHARE"},
      {{"simulate", "structured", "-o", out, "--missing", "0.1", "--missing-as", "null"}, "invalid"},
      {{"simulate", "structured", "-o", out, "--pose-noise", "1"}, "--pose-noise"}};
  for (const auto& [arguments, word] : wrong)
  {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exitCode, 2) << arguments.back() << "\n" << outcome.err;
    EXPECT_NE(outcome.err.find(word), std::string::npos) << outcome.err;
  }
  EXPECT_EQ(folder_.size(), 0U);
}

TEST_F(SimulateCommand, FailuresEndWith1)
{
  const Outcome noFolder = run({"simulate", "structured", "-o", folder_ / "none/a.rawlog"});
  EXPECT_EQ(noFolder.exitCode, 1);
  EXPECT_NE(noFolder.err.find("none"), std::string::npos) << noFolder.err;
  const std::string way = folder_.write("way.tum", "1 -0.4 2 0.5 0 0 0 1\n");
  const Outcome inWall = run({"simulate", "structured", "-o", folder_ / "a.rawlog", "--trajectory", way});
  EXPECT_EQ(inWall.exitCode, 1);
  EXPECT_NE(inWall.err.find("way.tum: pose 1"), std::string::npos) << inWall.err;
  EXPECT_EQ(folder_.size(), 1U);
}

TEST_F(SimulateCommand, AStopLeavesNothingAndEndsWith130)
{
  for (const int signal : {SIGINT, SIGTERM})
  {
    const Program program = start({"simulate", "corridor", "-o", folder_ / "a.rawlog", "--truth",
                                   folder_ / "a.csv", "--scans", "3000"});
    // It catches signals before it makes its first file.
    for (int i = 0; i < 600 && folder_.size() == 0; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    EXPECT_GT(folder_.size(), 0U);
    kill(program.process(), signal);
    const Outcome outcome = program.wait();
    EXPECT_EQ(outcome.exitCode, 130) << outcome.err;
    EXPECT_NE(outcome.err.find("nothing is written"), std::string::npos) << outcome.err;
    EXPECT_EQ(folder_.size(), 0U);
  }
}
}  // namespace
