// Logs of simulated worlds in stock programs.
#include <gtest/gtest.h>

#include "map_checks.h"
#include "program.h"

namespace
{
using namespace lamap::test;
namespace fs = std::filesystem;

TEST(RawlogEdit, ReadsSimulatedLogs)
{
  SKIP_WITHOUT_PROGRAM("rawlog-edit");
  const fs::path folder = freshFolder();
  // World, number of entries in its log, a label in it.
  const std::vector<std::tuple<std::string, int, std::string>> logs{
      {"structured", 6, "sector-laser"}, {"flatland", 6, "planar-laser"}, {"pier", 720, "SONAR/echo2"}};
  for (const auto& [world, entries, label] : logs)
  {
    const Outcome made = run({lamapTool(), "simulate", world, "-o", "a.rawlog", "--scans", "3"}, folder);
    ASSERT_TRUE(made.succeeded()) << made.output;
    const Outcome read = run({"rawlog-edit", "-i", "a.rawlog", "--info"}, folder);
    EXPECT_TRUE(read.succeeded()) << read.output;
    EXPECT_NE(read.output.find("Overall number of objects         : " + std::to_string(entries) + "\n"),
              std::string::npos)
        << read.output;
    EXPECT_NE(read.output.find(label), std::string::npos) << read.output;
    EXPECT_EQ(read.output.find("xception"), std::string::npos) << read.output;
  }
}

TEST(Observations2Map, MakesAMapOfASimulatedSimplemap)
{
  SKIP_WITHOUT_PROGRAM("observations2map");
  const fs::path folder = freshFolder();
  const Outcome made = run({lamapTool(), "simulate", "structured", "-o", "a.simplemap", "--pose-noise",
                            "0.01,0.5", "--scans", "3"},
                           folder);
  ASSERT_TRUE(made.succeeded()) << made.output;
  const Outcome built =
      run({lamapTool(), "run", "--", "observations2map", "a.ini", "a.simplemap", "map", "-s", "map"}, folder);
  EXPECT_TRUE(built.succeeded()) << built.output;
  bool ours = false;
  for (const auto& entry : fs::directory_iterator(folder))
    ours = ours || entry.path().filename().string().find(".lamap.gz") != std::string::npos;
  EXPECT_TRUE(ours) << built.output;
}
}  // namespace
