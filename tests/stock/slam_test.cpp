// Stock programs that fill our map while they run.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "map_checks.h"
#include "program.h"

namespace
{
using namespace lamap::test;
namespace fs = std::filesystem;

const std::string kSena = "2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog";
const std::string kOffice = "localization_demo.simplemap.gz";
constexpr size_t kPartOfSena = 160;  // 80 scans

void expectNoComplaints(const std::string& output)
{
  for (const std::string word : {"rror", "xception", "MRPT_ERR", "what()"})
    EXPECT_EQ(output.find(word), std::string::npos) << output;
}

class EachMap : public ::testing::TestWithParam<MapKind>
{
};
FOR_EACH_KIND_OF_MAP(EachMap);

TEST_P(EachMap, IsFilledAndSavedByIcpSlamAlongWithItsOwn)
{
  SKIP_WITHOUT_PROGRAM("icp-slam");
  SKIP_WITHOUT_DATASET(kSena);
  const fs::path folder = freshFolder();
  cutLog(*dataset(kSena), kPartOfSena, folder / "part.rawlog");
  const Outcome outcome =
      run(withPlugin({"icp-slam", configFile("icp-slam", GetParam()), "part.rawlog"}), folder);
  ASSERT_TRUE(outcome.succeeded()) << outcome.output;
  expectNoComplaints(outcome.output);
  const fs::path logs = folder / "LOG_ICP-SLAM";
  const std::string saved = "_finalmaps_.txt_" + savedName(GetParam());
  const SavedMap map = loadSavedMap(logs / (saved + ".lamap.gz"));
  EXPECT_EQ(map.className, GetParam().className);
  expectSameWalls(map, readPoints(logs / "_finalmaps_.txt_mrpt__maps__CSimplePointsMap_01.txt"));
  EXPECT_GT(fs::file_size(logs / (saved + ".3Dscene")), 1000u);
  EXPECT_GT(fs::file_size(logs / (saved + ".ply")), 1000u);
}

// On its own, icp-slam silently ignores both.
TEST(IcpSlam, DoesNotStartWithAMistypedCountOrKey)
{
  SKIP_WITHOUT_PROGRAM("icp-slam");
  const fs::path folder = freshFolder();
  const std::string right = readFile(configFile("icp-slam/bgk.ini"));
  const std::vector<std::pair<std::string, std::string>> mistakes{
      {"bgkMap_count", "bkgMap_count"}, {"maxRange", "maxRnage"}, {"00_insertOpts", "00_insertOptions"}};
  for (const auto& [correct, mistyped] : mistakes)
  {
    std::string wrong = right;
    wrong.replace(wrong.rfind(correct), correct.size(), mistyped);
    writeFile(folder / "wrong.ini", wrong);
    const Outcome outcome = run(withPlugin({"icp-slam", "wrong.ini", "any.rawlog"}), folder);
    EXPECT_TRUE(outcome.exitCode == 1 || outcome.exitCode == 2) << outcome.output;
    EXPECT_NE(outcome.output.find(mistyped), std::string::npos) << outcome.output;
    EXPECT_NE(outcome.output.find(correct), std::string::npos) << outcome.output;
    EXPECT_NE(outcome.output.find("wrong.ini"), std::string::npos) << outcome.output;
    EXPECT_EQ(outcome.output.find("Part of the MRPT"), std::string::npos) << "icp-slam has started";
  }
}

// It reads a file that is not one of its arguments.
TEST(MapPartition, DoesNotStartWithAMistypedCount)
{
  SKIP_WITHOUT_PROGRAM("map-partition");
  const fs::path folder = freshFolder();
  std::string wrong = readFile(configFile("map-partition/bgk.ini"));
  wrong.replace(wrong.rfind("bgkMap_count"), 3, "bkg");
  writeFile(folder / "MAP-PARTITION_CONFIG.ini", wrong);
  const Outcome outcome = run(withPlugin({"map-partition", "any.simplemap"}), folder);
  EXPECT_EQ(outcome.exitCode, 1);
  EXPECT_NE(outcome.output.find("bkgMap_count"), std::string::npos) << outcome.output;
  EXPECT_EQ(outcome.output.find("Part of the MRPT"), std::string::npos) << "map-partition has started";
}

TEST_P(EachMap, WeightsTheParticlesOfRbpfSlamAlone)
{
  SKIP_WITHOUT_PROGRAM("rbpf-slam");
  SKIP_WITHOUT_PROGRAM("icp-slam");
  SKIP_WITHOUT_DATASET(kSena);
  const fs::path folder = freshFolder();
  cutLog(*dataset(kSena), kPartOfSena, folder / "part.rawlog");
  std::string config = readFile(configFile("rbpf-slam", GetParam()));
  const std::string section = "[MappingApplication]\n";
  config.insert(config.find(section) + section.size(), "RANDOM_SEED = 1\n");
  writeFile(folder / "seeded.ini", config);
  const Outcome outcome = run(withPlugin({"rbpf-slam", "seeded.ini", "part.rawlog"}), folder);
  ASSERT_TRUE(outcome.succeeded()) << outcome.output;
  expectNoComplaints(outcome.output);
  const fs::path logs = folder / "LOG_RBPF-SLAM";
  const SavedMap map = loadSavedMap(logs / ("finalMap_" + savedName(GetParam()) + ".lamap.gz"));

  // The same log by icp-slam's own points map.
  const Outcome icp = run({"icp-slam", configFile("icp-slam/bgk.ini"), "part.rawlog"}, folder);
  ASSERT_TRUE(icp.succeeded()) << icp.output;
  const auto points = readPoints(folder / "LOG_ICP-SLAM/_finalmaps_.txt_mrpt__maps__CSimplePointsMap_00.txt");
  EXPECT_GT(map.occupied.size(), 100u);
  EXPECT_GT(map.free, map.occupied.size());
  EXPECT_GE(shareNear(map.occupied, points, 0.4), 0.55);  // two SLAM methods, which drift differently
}

TEST_P(EachMap, IsMadeFromASimpleMapByObservations2map)
{
  SKIP_WITHOUT_PROGRAM("observations2map");
  SKIP_WITHOUT_DATASET(kOffice);
  const fs::path folder = freshFolder();
  const Outcome outcome = run(withPlugin({"observations2map", configFile("observations2map", GetParam()),
                                          *dataset(kOffice), "out", "-s", "MetricMap"}),
                              folder);
  ASSERT_TRUE(outcome.succeeded()) << outcome.output;
  expectNoComplaints(outcome.output);
  expectSameWalls(loadSavedMap(folder / ("out_" + savedName(GetParam()) + ".lamap.gz")),
                  readPoints(folder / "out_mrpt__maps__CSimplePointsMap_01.txt"));
}

/// A run may end away from the robot; one of two must not. localize_often.sh counts them.
void expectToLocate(const std::vector<std::string>& command, const fs::path& folder)
{
  constexpr double kGoal_m = 0.3;
  Point end;
  for (int attempt = 0; attempt < 2; ++attempt)
  {
    const Outcome outcome = run(command, folder);
    ASSERT_TRUE(outcome.succeeded()) << outcome.output;
    expectNoComplaints(outcome.output);
    const std::string mark = "PDF estimation: (";
    const size_t last = outcome.output.rfind(mark);
    ASSERT_NE(last, std::string::npos) << outcome.output;
    ASSERT_EQ(std::sscanf(outcome.output.c_str() + last + mark.size(), "%lf,%lf", &end.x, &end.y), 2);
    if (std::hypot(end.x - 15.9, end.y + 10.0) < kGoal_m) return;
  }
  FAIL() << "the last run ended at (" << end.x << ", " << end.y << "), not near (15.9, -10.0)";
}

TEST_P(EachMap, LocatesTheRobotAloneInPfLocalization)
{
  SKIP_WITHOUT_PROGRAM("pf-localization");
  SKIP_WITHOUT_DATASET(kOffice);
  expectToLocate(withPlugin({"pf-localization", configFile("pf-localization", GetParam()),
                             *dataset("localization_demo.rawlog")}),
                 freshFolder());
}

// Without the plug-in: the map is MRPT's own.
TEST(ExportedGrid, LocatesTheRobotInPfLocalization)
{
  SKIP_WITHOUT_PROGRAM("pf-localization");
  SKIP_WITHOUT_DATASET(kOffice);
  const fs::path folder = freshFolder();
  const Outcome build =
      run({lamapTool(), "build", "-i", *dataset(kOffice), "-m", "bgkMap", "-s", "creationOpts.planar=true",
           "-s", "creationOpts.resolution=0.05", "-s", "insertOpts.maxRange=10", "-s",
           "insertOpts.beamWidth=none", "-o", "office.lamap.gz"},
          folder);
  ASSERT_TRUE(build.succeeded()) << build.output;
  const Outcome exported = run({lamapTool(), "export", "office.lamap.gz", "-o", "office.gridmap.gz"}, folder);
  ASSERT_TRUE(exported.succeeded()) << exported.output;
  expectToLocate({"pf-localization", configFile("pf-localization/exported-grid.ini")}, folder);
}

}  // namespace
