#include <gtest/gtest.h>
#include <lamap_tools/files/usage_error.h>
#include <lamap_tools/inputs/ping_file.h>
#include <lamap_tools/inputs/scan_inserter.h>
#include <lamap_tools/inputs/scan_source.h>

#include <mrpt/maps/COctoMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>

#include <cmath>
#include <functional>
#include <stdexcept>

#include "support/temporary_folder.h"

namespace
{
using namespace lamap::tools;
using lamap::DetectedEcho;
using lamap::RayEnd;
using lamap::test::TemporaryFolder;

const auto kGoOn = [] { return false; };

/// @return what the call throws; empty if nothing
template <class Error>
std::string complaintOf(const std::function<void()>& call)
{
  try
  {
    call();
  }
  catch (const Error& error)
  {
    return error.what();
  }
  return "";
}

bool says(const std::string& text, const std::string& words)
{
  return text.find(words) != std::string::npos;
}

/// Of bins that are a metre long.
PingRules rules()
{
  PingRules rules;
  rules.threshold = {20, 20};
  rules.deadZone_m = 1;
  return rules;
}

class Pings : public testing::Test
{
 protected:
  PingFile read(const std::string& content, const PingRules& by = rules())
  {
    return PingFile::read(folder_.write("pings.csv", content), by, kGoOn);
  }
  std::string complaintAbout(const std::string& content)
  {
    return complaintOf<std::runtime_error>([&] { (void)read(content); });
  }

  TemporaryFolder folder_;
};

TEST_F(Pings, AreReadLineByLine)
{
  const PingFile file = read(
      "time, azimuth, maximum range, intensities\n"
      "# a remark\n"
      "1000.5, 90, 5, 99, 0, 40, 0, 25\n"
      "\n"
      "1001, -45, 10, 0, 0, 0, 0, 30\n");
  ASSERT_EQ(file.pings.size(), 2U);
  EXPECT_DOUBLE_EQ(mrpt::Clock::toDouble(file.pings[0].time), 1000.5);
  EXPECT_NEAR(file.pings[0].azimuth_rad, M_PI / 2, 1e-15);
  EXPECT_EQ(file.pings[0].rangeMax_m, 5);
  EXPECT_EQ(file.pings[0].echoes, (std::vector<DetectedEcho>{{2.5, 40}, {4.5, 25}}));
  EXPECT_NEAR(file.pings[1].azimuth_rad, -M_PI / 4, 1e-15);
  EXPECT_EQ(file.pings[1].echoes, (std::vector<DetectedEcho>{{9, 30}}));
}

TEST_F(Pings, MayBeSeparatedInSeveralWays)
{
  for (const std::string line :
       {"1,0,3,0,50,0", "1;0;3;0;50;0;", "1 0\t3 0  50 0", "1 , 0 , 3 , 0 , 50 , 0\r"})
  {
    SCOPED_TRACE(line);
    const PingFile file = read(line + "\n");
    ASSERT_EQ(file.pings.size(), 1U);
    EXPECT_EQ(file.pings[0].echoes, (std::vector<DetectedEcho>{{1.5, 50}}));
  }
}

TEST_F(Pings, AzimuthsHaveTheUnitThatIsAskedFor)
{
  PingRules by = rules();
  by.azimuthUnit = AngleUnit::Gradians;
  EXPECT_NEAR(read("1,100,3,0,50,0\n", by).pings[0].azimuth_rad, M_PI / 2, 1e-15);
  by.azimuthUnit = AngleUnit::Radians;
  EXPECT_EQ(read("1,1.25,3,0,50,0\n", by).pings[0].azimuth_rad, 1.25);
}

TEST_F(Pings, WithoutAThresholdHalfOfTheHighestIntensityIsIt)
{
  PingRules by = rules();
  by.threshold.reset();
  // The 200 lies in the dead zone.
  const PingFile file = read("1,0,4,200,0,60,0\n2,0,4,0,80,0,39\n3,0,4,0,0,0,40\n", by);
  EXPECT_EQ(file.rules.nearThreshold, 40);
  EXPECT_EQ(file.pings[0].echoes.size(), 1U);
  EXPECT_EQ(file.pings[1].echoes.size(), 1U);
  EXPECT_EQ(file.pings[2].echoes.size(), 1U);
}

TEST_F(Pings, ABadLineIsNamedWithWhatWouldBeRight)
{
  const std::string good = "1,0,3,0,50,0\n";
  for (const auto& [line, words] : std::vector<std::pair<std::string, std::string>>{
           {"2,0,3\n",
            "has 3 columns; expected time [s], azimuth, maximum range [m] and at least one intensity"},
           {"2,0,three,0,50\n", "column 3, \"three\": must be a maximum range in metres, above 0"},
           {"2,0,0,0,50\n", "column 3, \"0\": must be a maximum range in metres, above 0"},
           {"2,0,-3,0,50\n", "must be a maximum range in metres, above 0"},
           {"noon,0,3,0,50\n", "column 1, \"noon\": must be a time in seconds"},
           {"1e15,0,3,0,50\n", "column 1, \"1e15\": must be a time in seconds"},
           {"-1,0,3,0,50,0\n", "must be a time in seconds since 1970, of at least 0"},
           {"2,0,3,0,50\n", "intensities: 2; of the ping before, to the same range: 3"},
           {"2,east,3,0,50\n", "column 2, \"east\": must be an azimuth"},
           {"2,0,3,0,nan\n", "column 5, \"nan\": must be an intensity"},
           {"2,0,3,0,,5\n", "column 5, \"\": must be an intensity"}})
  {
    SCOPED_TRACE(line);
    const std::string complaint = complaintAbout(good + "# remark\n" + line);
    EXPECT_TRUE(says(complaint, "pings.csv:3: ")) << complaint;
    EXPECT_TRUE(says(complaint, words)) << complaint;
  }
  EXPECT_TRUE(says(complaintAbout("time,azimuth,range,bins\n"), "pings.csv: holds no ping"));
  const std::string ofPoints = complaintAbout("x,y,z,label\n0.05,0.05,3,1\n");
  EXPECT_TRUE(says(ofPoints, "pings.csv:1: column 1, \"x\"")) << ofPoints;
  EXPECT_TRUE(says(ofPoints, "a .csv holds the pings of a scanning sonar, one a line: time [s]")) << ofPoints;
  // Without any intensity there is nothing to choose a threshold by: each flat profile would be an echo.
  const std::string silent = complaintOf<std::runtime_error>(
      [&] { (void)read("1, 0, 10, 0, 0, 0\n2, 9, 10, 0, 0, 0\n", PingRules{}); });
  EXPECT_TRUE(says(silent, "pings.csv: no intensity")) << silent;
  EXPECT_TRUE(says(silent, "give --ping-threshold")) << silent;
  EXPECT_TRUE(says(complaintOf<std::runtime_error>([] { (void)PingFile::read("/none.csv", rules(), kGoOn); }),
                   "/none.csv: cannot be opened"));
}

TEST(Ping, BecomesARayForEachEcho)
{
  PingRules by = rules();
  by.beamWidth_deg = 2;
  by.beamHeight_deg = 20;
  Ping ping{{}, M_PI / 2, 10, {{3, 50}, {6, 30}}};
  const lamap::RayFan fan = fanOf(ping, by);
  EXPECT_NEAR(fan.beam.halfWidth_rad, M_PI / 180, 1e-12);
  EXPECT_NEAR(fan.beam.halfHeight_rad, M_PI / 18, 1e-12);
  EXPECT_EQ(fan.statedRangeMax_m, 10);
  ASSERT_EQ(fan.rays.size(), 2U);
  EXPECT_LT((fan.rays[0].end - Eigen::Vector3d(0, 3, 0)).norm(), 1e-12);
  EXPECT_EQ(fan.rays[0].echo, 0);
  EXPECT_EQ(fan.rays[1].echo, 1);
  ping.echoes.clear();
  ASSERT_EQ(fanOf(ping, by).rays.size(), 1U);
  EXPECT_EQ(fanOf(ping, by).rays[0].meaning, RayEnd::NoReturn);
}

TEST(Ping, RefusesIllegalRules)
{
  const auto complaintAbout = [](const std::function<void(PingRules&)>& change)
  {
    PingRules rules;
    change(rules);
    return complaintOf<UsageError>([&] { rules.validate(); });
  };
  EXPECT_EQ(complaintAbout([](PingRules&) {}), "");
  for (const double angle : {-1.0, 180.0, std::nan("")})
  {
    EXPECT_TRUE(says(complaintAbout([&](PingRules& rules) { rules.beamWidth_deg = angle; }), "--ping-beam"));
    EXPECT_TRUE(says(complaintAbout([&](PingRules& rules) { rules.beamHeight_deg = angle; }),
                     "at least 0 and less than 180 degrees"));
  }
  EXPECT_TRUE(says(complaintAbout([](PingRules& rules) { rules.deadZone_m = -1; }), "--ping-dead-zone -1"));
  EXPECT_TRUE(
      says(complaintAbout([](PingRules& rules) { rules.separation_m = -1; }), "--ping-separation -1"));
  EXPECT_TRUE(says(complaintAbout([](PingRules& rules) { rules.mostEchoes = 0; }), "--ping-echoes 0"));
  EXPECT_TRUE(says(complaintAbout(
                       [](PingRules& rules) {
                         rules.threshold = {0, INFINITY};
                       }),
                   "--ping-threshold"));
}

class PingInput : public testing::Test
{
 protected:
  void SetUp() override
  {
    options_.paths = {folder_.write(
        "pings.csv", "10,0,5,0,0,50,0,0\n11,90,5,0,0,0,0,0\n12,0,5,0,0,0,50,0\n13,0,5,0,0,0,50,0\n")};
    options_.posesPath = folder_.write("poses.tum", "10 0 0 1 0 0 0 1\n12 4 0 1 0 0 0 1\n");
    options_.pings = rules();
  }

  std::vector<PointScan> scans()
  {
    std::vector<PointScan> scans;
    leftOut_.clear();
    notes_.clear();
    for (const auto& source : openInputs(options_))
    {
      while (const auto item = source->next())
      {
        if (const auto* scan = std::get_if<PointScan>(&*item)) scans.push_back(*scan);
        if (const auto* left = std::get_if<LeftOutScan>(&*item)) leftOut_.push_back(left->reason);
      }
      for (const auto* notes : {&source->notes(), &source->readingNotes()})
        for (const std::string& note : *notes) notes_ += note + "\n";
    }
    return scans;
  }
  template <class Error>
  std::string complaint()
  {
    return complaintOf<Error>([&] { (void)scans(); });
  }

  TemporaryFolder folder_;
  InputOptions options_;
  std::vector<std::string> leftOut_;
  std::string notes_;
};

TEST_F(PingInput, TakesThePosesOfItsTimes)
{
  options_.sensorOrigin = {0.5, 0, 0};
  const auto all = scans();
  ASSERT_EQ(all.size(), 3U);
  // The ping at 11 s was made halfway.
  EXPECT_LT((all[1].scan.sensorPose_map.translation() - Eigen::Vector3d(2, 0, 1)).norm(), 1e-9);
  EXPECT_EQ(all[1].scan.fans.at(0).rays.at(0).meaning, RayEnd::NoReturn);
  EXPECT_LT(
      (all[2].scan.inMap(all[2].scan.fans[0].rays[0].end) - Eigen::Vector3d(4 + 0.5 + 3.5, 0, 1)).norm(),
      1e-9);
  EXPECT_LT((all[2].scan.inMap(all[2].scan.fans[0].centre) - Eigen::Vector3d(4.5, 0, 1)).norm(), 1e-9);
  ASSERT_TRUE(all[2].time);
  EXPECT_DOUBLE_EQ(mrpt::Clock::toDouble(*all[2].time), 12);
  EXPECT_EQ(leftOut_, std::vector<std::string>{"made at a time that the poses do not cover"});
  EXPECT_TRUE(says(notes_, "4 pings, 3 echoes of at least 20; 1 ping without an echo")) << notes_;
  EXPECT_TRUE(says(notes_, "--ping-beam")) << notes_;
}

TEST_F(PingInput, IsChosenFromByTime)
{
  options_.choice.from = LogTime("--from", "1");
  options_.choice.to = LogTime("--to", "2");
  EXPECT_EQ(scans().size(), 2U);
  options_.choice = {};
  options_.choice.every = 2;
  EXPECT_EQ(scans().size(), 2U);
}

TEST_F(PingInput, NeedsPosesUnlessTheSonarStoodStill)
{
  options_.posesPath.clear();
  EXPECT_TRUE(says(complaint<UsageError>(), "--poses: pings in a .csv need poses by time"));
  options_.standingStill = true;
  EXPECT_EQ(scans().size(), 4U);
  EXPECT_TRUE(says(notes_, "the robot stood still at the origin"));
  options_.standingStill = false;
  options_.evenWithoutPoses = true;
  EXPECT_EQ(scans().size(), 4U);
  EXPECT_TRUE(says(notes_, "a build needs --poses")) << notes_;
}

TEST_F(PingInput, PosesOfAnotherTimeAreAnError)
{
  options_.posesPath = folder_.write("other.tum", "110 0 0 1 0 0 0 1\n112 4 0 1 0 0 0 1\n");
  const std::string text = complaint<std::runtime_error>();
  EXPECT_TRUE(says(text, "begin at 10.000 s")) << text;
  EXPECT_TRUE(says(text, "from 110.000 to 112.000 s")) << text;
}

TEST(Octree, GetsASingleBeamAsThePointOfItsEcho)
{
  mrpt::maps::COctoMap map(0.1);
  ScanInserter inserter(map);
  auto ping = mrpt::obs::CObservation2DRangeScan::Create();
  ping->maxRange = 10;
  ping->resizeScan(1);
  ping->setScanRange(0, 2.05F);
  ping->setScanRangeValidity(0, true);
  const ScanItem item = ObservedScan{ping, mrpt::poses::CPose3D(1, 0.05, 0.05, 0, 0, 0)};
  inserter.insert(item);
  EXPECT_EQ(inserter.tally().usedCount(), 1U);
  double prob = 0;
  ASSERT_TRUE(map.getPointOccupancy(3.05F, 0.05F, 0.05F, prob));
  EXPECT_GT(prob, 0.5);
  ASSERT_TRUE(map.getPointOccupancy(2.05F, 0.05F, 0.05F, prob));
  EXPECT_LT(prob, 0.5);
}

TEST_F(PingInput, ItsFlagsAreForItAlone)
{
  options_.paths = {folder_.path()};
  folder_.write("0.pcd", "");
  options_.posesPath.clear();
  EXPECT_TRUE(says(complaint<UsageError>(), "--ping-"));
}

}  // namespace
