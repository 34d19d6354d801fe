// The scripts of share/experiments as a user starts them. What is checked comes from the maps that they
// leave.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "support/temporary_folder.h"

namespace
{
using namespace lamap;

class Experiment : public testing::Test
{
 protected:
  /// @return exit code
  int run(const std::string& command)
  {
    const int status = std::system((command + " > " + log() + " 2>&1 < /dev/null").c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  int runScript(const std::string& name, const std::string& arguments)
  {
    return run("LAMAP='" LAMAP_PROGRAM "' '" LAMAP_EXPERIMENTS "/" + name + "' " + arguments);
  }
  [[nodiscard]] std::string log() const { return folder_ / "log.txt"; }
  [[nodiscard]] std::string said() const { return test::fileContent(log()); }

  /// Scores over all cells of the truth, by the name of each map.
  nlohmann::json scoresOf(const std::string& maps)
  {
    EXPECT_EQ(run("cd " + folder_.path() + "/out && '" LAMAP_PROGRAM "' eval " + maps +
                  " --truth truth.csv --json"),
              0)
        << said();
    nlohmann::json byName;
    const auto table = nlohmann::json::parse(said());
    for (const auto& map : table.at("maps")) byName[map.at("map").get<std::string>()] = map.at("all");
    return byName;
  }

  test::TemporaryFolder folder_;
};

void expectPicture(const std::string& path)
{
  SCOPED_TRACE(path);
  const std::string picture = test::fileContent(path);
  EXPECT_GT(picture.size(), 5000u);
  EXPECT_EQ(picture.substr(0, 4), "\x89PNG");
}

// Figure 3.1 of the thesis: the map grows from scan to scan, and knows the world ever better.
TEST_F(Experiment, Figure31KnowsTheWorldBetterWithEachStop)
{
  ASSERT_EQ(runScript("figure_3_1.sh", (folder_ / "out") + " --quick"), 0) << said();
  expectPicture(folder_ / "out/figure_3_1.png");
  for (const std::string preset : {"thesis", "default"})
  {
    std::string maps;
    for (const char* scans : {"1", "7", "14", "20"})
    {
      expectPicture(folder_ / ("out/" + preset + "_" + scans + ".png"));
      maps += preset + "_" + scans + ".lamap.gz ";
    }
    const nlohmann::json scores = scoresOf(maps);
    const auto score = [&](const char* scans, const char* name)
    { return scores.at(preset + "_" + scans + ".lamap.gz").at(name).get<double>(); };
    for (const auto& [before, after] : {std::pair{"1", "7"}, {"7", "14"}, {"14", "20"}})
    {
      EXPECT_GT(score(after, "auc"), score(before, "auc")) << preset << " after scan " << after;
      EXPECT_LT(score(after, "brier"), score(before, "brier")) << preset << " after scan " << after;
      // The thesis's sums of log-odds become overconfident: its log loss may rise from one stop to the next.
      if (preset == "default")
      {
        EXPECT_LT(score(after, "logLoss"), score(before, "logLoss")) << " after scan " << after;
      }
    }
    EXPECT_GE(score("20", "auc"), 0.97) << preset;
    EXPECT_LT(score("20", "logLoss"), score("7", "logLoss")) << preset;
  }
}

TEST_F(Experiment, WrongArgumentsAreRefused)
{
  EXPECT_EQ(runScript("figure_3_1.sh", ""), 2);
  EXPECT_NE(said().find("usage: figure_3_1.sh OUTDIR [--quick]"), std::string::npos) << said();
  EXPECT_EQ(runScript("figure_3_1.sh", (folder_ / "out") + " --quik"), 2);
  EXPECT_NE(said().find("--quik"), std::string::npos) << said();
  EXPECT_EQ(run("LAMAP=/no/lamap '" LAMAP_EXPERIMENTS "/figure_3_1.sh' " + (folder_ / "out")), 1);
  EXPECT_NE(said().find("/no/lamap"), std::string::npos) << said();
}

}  // namespace
