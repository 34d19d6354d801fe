// Logs: one that contains our map, and one written by rawlog-grabber.
#include <gtest/gtest.h>

#include "map_checks.h"
#include "program.h"

namespace
{
using namespace lamap::test;
namespace fs = std::filesystem;

const std::string kOffice = "localization_demo.simplemap.gz";
const std::string kDepthCamera = "tests_rgbd.rawlog";

class EachMapInALog : public ::testing::TestWithParam<MapKind>
{
};
FOR_EACH_KIND_OF_MAP(EachMapInALog);

TEST_P(EachMapInALog, IsReadByRawlogEditWithThePlugin)
{
  SKIP_WITHOUT_PROGRAM("rawlog-edit");
  SKIP_WITHOUT_DATASET(kOffice);
  const fs::path folder = freshFolder();
  const Outcome built = run({lamapTool(), "build", "-i", *dataset(kOffice), "-c",
                             configFile("build", GetParam()), "-o", "map.lamap.gz"},
                            folder);
  ASSERT_TRUE(built.succeeded()) << built.output;
  writeLogWithMap(folder / "map.lamap.gz", folder / "with_map.rawlog");

  // The map and the odometry readings around it; without the plug-in, rawlog-edit stops at the map.
  const std::string count = "Overall number of objects         : ";
  const Outcome with = run({"rawlog-edit", "-p", pluginFile(), "-i", "with_map.rawlog", "--info"}, folder);
  EXPECT_TRUE(with.succeeded()) << with.output;
  EXPECT_NE(with.output.find(count + "3"), std::string::npos) << with.output;
  EXPECT_EQ(with.output.find("xception"), std::string::npos) << with.output;

  const Outcome without = run({"rawlog-edit", "-i", "with_map.rawlog", "--info"}, folder);
  EXPECT_NE(without.output.find("'" + GetParam().className + "' which is not registered"), std::string::npos)
      << without.output;
  EXPECT_NE(without.output.find(count + "1"), std::string::npos) << without.output;
}

TEST(RawlogGrabber, WritesLogsThatBecomeMaps)
{
  for (const char* program : {"rawlog-grabber", "rawlog-edit"}) SKIP_WITHOUT_PROGRAM(program);
  SKIP_WITHOUT_DATASET(kDepthCamera);
  const fs::path folder = freshFolder();
  // Its camera driver replays the pictures of another log as those of a camera.
  repeatObservation(*dataset(kDepthCamera), 8, 0.1, folder / "camera.rawlog");
  writeFile(
      folder / "grabber.ini",
      "[global]\nrawlog_prefix = grabbed\ntime_between_launches = 300\nuse_sensoryframes = 0\n"
      "GRABBER_PERIOD_MS = 200\n[CAMERA]\ndriver = CCameraSensor\nprocess_rate = 5\nsensorLabel = CAMERA\n"
      "grabber_type = rawlog\nrawlog_file = camera.rawlog\npreview_decimation = 0\n");
  // It ends at the end of that log, with an error from its driver.
  Program grabber({"rawlog-grabber", "-p", pluginFile(), "grabber.ini"}, folder, {}, Keys::Terminal);
  const Outcome grabbed = grabber.wait(std::chrono::seconds(60));
  ASSERT_NE(grabbed.output.find("objects."), std::string::npos) << grabbed.output;

  fs::path log;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().filename().string().rfind("grabbed", 0) == 0 && entry.path().extension() == ".rawlog")
      log = entry.path();
  ASSERT_FALSE(log.empty()) << grabbed.output;

  // The camera stands still.
  writeFile(folder / "poses.txt",
            "1462879442 0 0 0 0 0 0 1\n"
            "1462879460 0 0 0 0 0 0 1\n");
  // As it is, and with ranges and pictures in separate files.
  const Outcome external =
      run({"rawlog-edit", "--externalize", "-i", log.string(), "-o", "external.rawlog"}, folder);
  ASSERT_TRUE(external.succeeded()) << external.output;
  std::vector<SavedMap> maps;
  for (const std::string& input : {log.string(), std::string("external.rawlog")})
  {
    const Outcome built = run({lamapTool(), "build", "-i", input, "--poses", "poses.txt", "-m", "bgkMap",
                               "-s", "creationOpts.resolution=0.05", "-o", "grabbed.lamap.gz"},
                              folder);
    ASSERT_TRUE(built.succeeded()) << built.output;
    maps.push_back(loadSavedMap(folder / "grabbed.lamap.gz"));
    EXPECT_GT(maps.back().occupied.size(), 1000u);
    EXPECT_GT(maps.back().free, maps.back().occupied.size());
    // The camera looks along x and sees at most 5 m.
    for (const Point& cell : maps.back().occupied)
    {
      EXPECT_GT(cell.x, 0.2);
      EXPECT_LT(cell.x, 8.0);
    }
  }
  EXPECT_EQ(maps[0].occupied.size(), maps[1].occupied.size());
}

}  // namespace
