#include <gtest/gtest.h>
#include <lamap_tools/files/usage_error.h>
#include <lamap_tools/inputs/scan_source.h>
#include <lamap_tools/inputs/trial_run.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationComment.h>
#include <mrpt/obs/CRawlog.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>
#include <octomap/ScanGraph.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <random>
#include <stdexcept>

#include "support/small_logs.h"
#include "support/temporary_folder.h"

namespace
{
using namespace lamap::tools;
using namespace lamap::test;
using mrpt::poses::CPose3D;

std::vector<ScanItem> allItems(ScanSource& source)
{
  std::vector<ScanItem> items;
  while (auto item = source.next()) items.push_back(std::move(*item));
  return items;
}

std::unique_ptr<ScanSource> openOne(const InputOptions& options)
{
  auto sources = openInputs(options);
  EXPECT_EQ(sources.size(), 1U);
  return std::move(sources.at(0));
}

std::vector<ScanItem> read(const InputOptions& options)
{
  return allItems(*openOne(options));
}

std::vector<ScanItem> read(const std::string& path)
{
  InputOptions options;
  options.paths = {path};
  return read(options);
}

template <class Error>
std::string complaint(const InputOptions& options)
{
  try
  {
    for (const auto& source : openInputs(options)) (void)allItems(*source);
  }
  catch (const Error& error)
  {
    return error.what();
  }
  return "";
}

void expectPose(const ScanItem& item, const CPose3D& expected)
{
  const auto* scan = std::get_if<ObservedScan>(&item);
  ASSERT_NE(scan, nullptr);
  const Eigen::Matrix4d difference =
      scan->robotPose_map.getHomogeneousMatrixVal<mrpt::math::CMatrixDouble44>().asEigen() -
      expected.getHomogeneousMatrixVal<mrpt::math::CMatrixDouble44>().asEigen();
  EXPECT_LT(difference.cwiseAbs().maxCoeff(), 1e-6)
      << scan->robotPose_map.asString() << ", not " << expected.asString();
}

CPose3D planar(double x, double y, double phi)
{
  return CPose3D(x, y, 0, phi, 0, 0);
}
constexpr double kQuarterTurn = 1.57079632679489662;

// The robot goes 1 m, turns left by 90 degrees on the way, and goes 2 m: it ends at (1, 2), looking along y.
// MRPT stamps an action in the middle between two frames; that must not shift a pose by half a step.
TEST(RawlogActions, In2DAreComposedFromTheIdentity)
{
  const TemporaryFolder folder;
  for (const bool compressed : {true, false})
  {
    SCOPED_TRACE(compressed);
    writeLog(folder / "a.rawlog",
             {frame({laser(at(0))}), move2D(at(0.5), 1, 0, kQuarterTurn), frame({laser(at(1))}),
              move2D(at(1.5), 2, 0, 0), frame({laser(at(2))})},
             compressed);
    const auto items = read(folder / "a.rawlog");
    ASSERT_EQ(items.size(), 3U);
    expectPose(items[0], planar(0, 0, 0));
    expectPose(items[1], planar(1, 0, kQuarterTurn));
    expectPose(items[2], planar(1, 2, kQuarterTurn));
  }
}

// icp-slam numbers its steps, one for each frame that follows an action: here those at 1 and 2 s.
TEST(GivenPoses, ThatCountStepsAreThoseOfTheFramesAfterAnAction)
{
  const TemporaryFolder folder;
  const std::string log = folder / "a.rawlog";
  const Objects objects{frame({laser(at(0))}), move2D(at(0.5), 1, 0, 0), frame({laser(at(1))}),
                        move2D(at(1.5), 1, 0, 0), frame({laser(at(2))})};
  writeLog(log, objects);
  InputOptions options;
  options.paths = {log};
  options.posesPath = folder.write("log_estimated_path.txt", "0 5 0 0\n1 6 0 0.5\n");
  const auto source = openOne(options);
  EXPECT_FALSE(source->posesAreOdometry());
  EXPECT_NE(source->notes().at(0).find("counts the steps"), std::string::npos) << source->notes().at(0);
  const auto items = allItems(*source);
  ASSERT_EQ(items.size(), 3U);
  EXPECT_TRUE(std::holds_alternative<LeftOutScan>(items[0])) << "before the first step";
  expectPose(items[1], planar(5, 0, 0));
  expectPose(items[2], planar(6, 0, 0.5));

  options.posesPath = folder.write("longer.txt", "0 5 0 0\n1 6 0 0\n2 7 0 0\n");
  const std::string text = complaint<std::runtime_error>(options);
  EXPECT_NE(text.find("3 poses and 2 such steps"), std::string::npos) << text;
  EXPECT_NE(text.find("_finalmap_.simplemap"), std::string::npos) << text;
}

TEST(GivenPoses, ThatCountStepsAreThoseOfAllObservationsWhereThereAreNoFrames)
{
  const TemporaryFolder folder;
  writeLog(folder / "a.rawlog",
           {odometry(at(0), 0, 0, 0), laser(at(1)), odometry(at(2), 9, 0, 0), laser(at(3))});
  InputOptions options;
  options.paths = {folder / "a.rawlog"};
  options.posesPath = folder.write("log_estimated_path.txt", "0 5 0 0\n1 6 0 0\n2 7 0 0\n3 8 0 0\n");
  const auto items = read(options);
  ASSERT_EQ(items.size(), 2U);
  expectPose(items[0], planar(6, 0, 0));
  expectPose(items[1], planar(8, 0, 0));
}

TEST(GivenPoses, AreTakenByTheirTimesWhereTheLogHasThese)
{
  const TemporaryFolder folder;
  const auto early = [](double seconds) { return mrpt::Clock::fromDouble(seconds); };
  writeLog(folder / "a.rawlog",
           {frame({laser(early(0.5))}), move2D(early(1), 1, 0, 0), frame({laser(early(1.5))})});
  InputOptions options;
  options.paths = {folder / "a.rawlog"};
  options.posesPath = folder.write("path.txt", "0 0 0 0\n1 2 0 0\n2 4 0 0\n");
  const auto items = read(options);
  ASSERT_EQ(items.size(), 2U);
  expectPose(items[0], planar(1, 0, 0));
  expectPose(items[1], planar(3, 0, 0));
}

// Up by a pitch of -90 degrees: what was forward is now along z.
TEST(RawlogActions, In3DAreComposedFromTheIdentity)
{
  const TemporaryFolder folder;
  writeLog(folder / "a.rawlog", {move3D(at(0), CPose3D(1, 0, 0, 0, -kQuarterTurn, 0)), frame({laser(at(0))}),
                                 move3D(at(1), CPose3D(2, 0, 0, 0, 0, 0)), frame({laser(at(1))})});
  const auto items = read(folder / "a.rawlog");
  ASSERT_EQ(items.size(), 2U);
  expectPose(items[0], CPose3D(1, 0, 0, 0, -kQuarterTurn, 0));
  expectPose(items[1], CPose3D(1, 0, 2, 0, -kQuarterTurn, 0));
}

// Frames at 0, 4 and 8 s, 4 m apart; in each a second observation 1 s later, a quarter of the way to the
// next.
TEST(RawlogActions, LaterObservationsOfAFrameAreInterpolatedAndTheLastOneHeld)
{
  const TemporaryFolder folder;
  writeLog(folder / "a.rawlog",
           {frame({laser(at(0)), laser(at(1))}), move2D(at(2), 4, 0, 0), frame({laser(at(4)), laser(at(5))}),
            move2D(at(6), 4, 0, 0), frame({laser(at(8)), laser(at(9))})});
  InputOptions options;
  options.paths = {folder / "a.rawlog"};
  const auto source = openOne(options);
  EXPECT_EQ(source->expectedItems(), 6U);
  const auto items = allItems(*source);
  ASSERT_EQ(items.size(), 6U);
  for (size_t i = 0; i < 5; ++i) expectPose(items[i], planar(std::vector<double>{0, 1, 4, 5, 8}[i], 0, 0));
  expectPose(items[5], planar(8, 0, 0));  // nothing is extrapolated
  ASSERT_EQ(source->notes().size(), 2U);
  EXPECT_NE(source->notes()[1].find("1 observation before"), std::string::npos) << source->notes()[1];
}

TEST(RawlogActions, WithTimesThatGoBackwardsEveryObservationTakesItsFramesPose)
{
  const TemporaryFolder folder;
  writeLog(folder / "a.rawlog", {frame({laser(at(5)), laser(at(6))}), move2D(at(7), 1, 0, 0),
                                 frame({laser(at(2)), laser(at(5.5))})});
  const auto items = read(folder / "a.rawlog");
  ASSERT_EQ(items.size(), 4U);
  expectPose(items[1], planar(0, 0, 0));
  expectPose(items[3], planar(1, 0, 0));
}

TEST(RawlogOdometry, GivesAbsolutePosesThatAreInterpolated)
{
  const TemporaryFolder folder;
  writeLog(folder / "a.rawlog",
           {laser(at(-1)), odometry(at(0), 1, 1, 0), laser(at(0)), laser(at(0.25)), laser(at(0.75)),
            odometry(at(1), 5, 1, kQuarterTurn), laser(at(1)), laser(at(1.01)), laser(INVALID_TIMESTAMP)});
  InputOptions options;
  options.paths = {folder / "a.rawlog"};
  const auto source = openOne(options);
  const auto items = allItems(*source);
  EXPECT_EQ(source->expectedItems(), 7U);
  ASSERT_EQ(items.size(), 7U);
  EXPECT_NE(std::get<LeftOutScan>(items[0]).reason.find("before the first or after the last pose"),
            std::string::npos);
  expectPose(items[1], planar(1, 1, 0));
  expectPose(items[2], planar(2, 1, kQuarterTurn / 4));
  expectPose(items[3], planar(4, 1, 3 * kQuarterTurn / 4));
  expectPose(items[4], planar(5, 1, kQuarterTurn));
  EXPECT_TRUE(std::holds_alternative<LeftOutScan>(items[5]));
  EXPECT_EQ(std::get<LeftOutScan>(items[6]).reason, "it has no time stamp");
}

TEST(RawlogOdometry, IsFoundInsideFramesToo)
{
  const TemporaryFolder folder;
  writeLog(folder / "a.rawlog",
           {frame({odometry(at(0), 3, 0, 0), laser(at(0))}), frame({odometry(at(1), 4, 0, 0)})});
  const auto items = read(folder / "a.rawlog");
  ASSERT_EQ(items.size(), 1U);
  expectPose(items[0], planar(3, 0, 0));
}

TEST(RawlogOdometry, WithoutTimesIsToldAsSuch)
{
  const TemporaryFolder folder;
  const auto none = INVALID_TIMESTAMP;
  const std::vector<Objects> logs{
      {odometry(none, 0, 0, 0), laser(at(0)), odometry(none, 1, 0, 0), laser(at(1))},
      {odometry(none, 0, 0, 0), laser(none), odometry(none, 1, 0, 0), laser(none)},
      {frame({odometry(none, 0, 0, 0), laser(at(0))}), frame({odometry(none, 1, 0, 0), laser(at(1))})}};
  InputOptions options;
  options.paths = {folder / "a.rawlog"};
  for (const Objects& log : logs)
  {
    writeLog(folder / "a.rawlog", log);
    const std::string text = complaint<std::runtime_error>(options);
    EXPECT_NE(text.find("a.rawlog: holds 2 observations or frames and 2 CObservationOdometry, but without a "
                        "valid time stamp"),
              std::string::npos)
        << text;
  }
  options.evenWithoutPoses = true;
  EXPECT_NE(openOne(options)->notes().at(0).find("none (it holds 2 CObservationOdometry, but without"),
            std::string::npos);
  options.standingStill = true;
  EXPECT_EQ(read(options).size(), 2U);
}

TEST(RawlogOdometry, InPartWithoutTimesIsUsedInPart)
{
  const TemporaryFolder folder;
  writeLog(folder / "a.rawlog", {odometry(at(0), 1, 0, 0), laser(at(0)), odometry(INVALID_TIMESTAMP, 9, 9, 9),
                                 odometry(at(1), 2, 0, 0), laser(at(1))});
  InputOptions options;
  options.paths = {folder / "a.rawlog"};
  const auto source = openOne(options);
  const auto items = allItems(*source);
  ASSERT_EQ(items.size(), 2U);
  expectPose(items[1], planar(2, 0, 0));
  ASSERT_EQ(source->notes().size(), 2U);
  EXPECT_EQ(source->notes()[1], "not used: 1 CObservationOdometry without a valid time stamp");
}

TEST(RawlogPoses, GivenOnesReplaceTheLogs)
{
  const TemporaryFolder folder;
  writeLog(folder / "a.rawlog", {frame({laser(at(0))}), move2D(at(0.5), 1, 0, 0), frame({laser(at(1))})});
  InputOptions options;
  options.paths = {folder / "a.rawlog"};
  options.posesPath = folder.write("p.txt", "1000000000 0 0 0\n1000000004 8 0 0\n");
  const auto items = read(options);
  ASSERT_EQ(items.size(), 2U);
  expectPose(items[1], planar(2, 0, 0));

  options.posesPath = folder.write("far.txt", "5 0 0 0\n6 8 0 0\n");
  EXPECT_NE(complaint<std::runtime_error>(options).find("of its 2 observations"), std::string::npos);
}

TEST(RawlogPoses, ALogWithoutThemIsReadOnlyWhereTheyDoNotMatter)
{
  const TemporaryFolder folder;
  writeLog(folder / "one.rawlog", {laser(at(0))});
  expectPose(read(folder / "one.rawlog").at(0), CPose3D());

  writeLog(folder / "two.rawlog", {laser(at(0)), laser(at(1))});
  InputOptions options;
  options.paths = {folder / "two.rawlog"};
  EXPECT_NE(complaint<std::runtime_error>(options).find("give --poses"), std::string::npos);
  options.standingStill = true;
  const auto items = read(options);
  ASSERT_EQ(items.size(), 2U);
  expectPose(items[1], CPose3D());
}

TEST(Rawlog, AWholeCRawlogIsReadLikeItsEntries)
{
  const TemporaryFolder folder;
  const auto log = mrpt::obs::CRawlog::Create();
  log->insert(frame({laser(at(0))}));
  log->insert(move2D(at(0.5), 1, 0, 0));
  log->insert(frame({laser(at(1))}));
  writeLog(folder / "a.rawlog", {log});
  const auto items = read(folder / "a.rawlog");
  ASSERT_EQ(items.size(), 2U);
  expectPose(items[1], planar(1, 0, 0));
}

TEST(Rawlog, OtherObjectsAreLeftOutAndCounted)
{
  const TemporaryFolder folder;
  writeLog(folder / "a.rawlog", {odometry(at(0), 1, 0, 0), laser(at(0)),
                                 mrpt::maps::CSimplePointsMap::Create(), odometry(at(1), 1, 0, 0)});
  const auto items = read(folder / "a.rawlog");
  ASSERT_EQ(items.size(), 2U);
  EXPECT_EQ(std::get<LeftOutScan>(items[1]).kind, "CSimplePointsMap");
}

TEST(Rawlog, IsReadTwiceIfItIsNamedTwice)
{
  const TemporaryFolder folder;
  writeLog(folder / "a.rawlog", {frame({laser(at(0))}), move2D(at(0.5), 1, 0, 0), frame({laser(at(1))})});
  InputOptions options;
  options.paths = {folder / "a.rawlog", folder / "a.rawlog"};
  for (const auto& source : openInputs(options)) EXPECT_EQ(allItems(*source).size(), 2U);
}

/// Forty frames of many rays that do not compress well, so that a compressed log has its frames all along its
/// length.
Objects longLog()
{
  Objects objects;
  std::mt19937 random(5);
  std::uniform_real_distribution<float> range(1, 9);
  for (int i = 0; i < 40; ++i)
  {
    auto scan = laser(at(i));
    scan->resizeScan(2000);
    for (size_t ray = 0; ray < 2000; ++ray) scan->setScanRange(ray, range(random));
    objects.push_back(frame({scan}));
    objects.push_back(move2D(at(i + 0.5), 0.1, 0, 0.01));
  }
  return objects;
}

// What stands before the cut is read as it is; the cut is reported, except where a plain log ends between two
// objects.
TEST(Rawlog, CutAtEveryEighthGivesWhatStandsBeforeTheCut)
{
  const TemporaryFolder folder;
  for (const bool compressed : {true, false})
  {
    SCOPED_TRACE(compressed ? "compressed" : "plain");
    writeLog(folder / "whole.rawlog", longLog(), compressed);
    const std::string whole = fileContent(folder / "whole.rawlog");
    const auto wholeItems = read(folder / "whole.rawlog");
    ASSERT_EQ(wholeItems.size(), 40U);
    size_t before = 0;
    for (size_t eighth = 1; eighth < 8; ++eighth)
    {
      SCOPED_TRACE(eighth);
      InputOptions options;
      options.paths = {folder.write("cut.rawlog", whole.substr(0, whole.size() * eighth / 8 + 3))};
      const auto source = openOne(options);
      const auto items = allItems(*source);
      EXPECT_EQ(source->damages().size(), 1U);
      EXPECT_GE(items.size(), before);
      EXPECT_LT(items.size(), wholeItems.size());
      before = items.size();
      if (!compressed)
      {
        EXPECT_NEAR(static_cast<double>(items.size()), 5.0 * static_cast<double>(eighth), 2);
      }
      for (size_t i = 0; i < items.size(); ++i)
        expectPose(items[i], std::get<ObservedScan>(wholeItems[i]).robotPose_map);
    }
    EXPECT_GT(before, 0U);
  }
}

TEST(Rawlog, AGzipStreamWithAWrongChecksumIsDamaged)
{
  const TemporaryFolder folder;
  writeLog(folder / "a.rawlog", longLog());
  std::string content = fileContent(folder / "a.rawlog");
  content[content.size() - 6] ^= 0x10;  // of the CRC-32 in the last eight bytes
  InputOptions options;
  options.paths = {folder.write("b.rawlog", content)};
  const auto source = openOne(options);
  EXPECT_GE(allItems(*source).size(), 30U);  // zlib holds back the last piece, whose sum is wrong
  EXPECT_EQ(source->damages().size(), 1U);
}

// Bytes of a small plain log flipped one by one: no crash, no hang, no unbounded memory. (MRPT's own reader
// does crash.)
TEST(Rawlog, FlippedBytesDoNoHarm)
{
  const TemporaryFolder folder;
  writeLog(folder / "a.rawlog", {frame({laser(at(0))}), move2D(at(0.5), 1, 0, 0), frame({laser(at(1))})},
           false);
  const std::string whole = fileContent(folder / "a.rawlog");
  size_t damaged = 0;
  for (size_t i = 0; i < whole.size(); i += 3)
  {
    std::string content = whole;
    content[i] = static_cast<char>(content[i] ^ (i % 2 == 0 ? 0x40 : 0xff));
    InputOptions options;
    options.paths = {folder.write("b.rawlog", content)};
    options.standingStill = true;
    try
    {
      const auto source = openOne(options);
      (void)allItems(*source);
      damaged += source->damages().size();
    }
    catch (const std::runtime_error&)
    {
      ++damaged;  // from its first entry on
    }
  }
  EXPECT_GT(damaged, 20U);
}

// A length of four billion elements where 81 stand.
TEST(Rawlog, AnAbsurdLengthIsRefusedWithoutTakingTheMemory)
{
  const TemporaryFolder folder;
  auto comment = mrpt::obs::CObservationComment::Create();
  comment->text = std::string(81, 'x');
  writeLog(folder / "a.rawlog", {laser(at(0)), comment}, false);
  std::string content = fileContent(folder / "a.rawlog");
  const size_t length = content.find(std::string(81, 'x')) - 4;
  ASSERT_EQ(content[length], 81);
  content.replace(length, 4, "\xff\xff\xff\xf0");
  InputOptions options;
  options.paths = {folder.write("b.rawlog", content)};
  const auto source = openOne(options);
  EXPECT_EQ(allItems(*source).size(), 1U);
  ASSERT_EQ(source->damages().size(), 1U);
  EXPECT_NE(source->damages()[0].find("entry 2"), std::string::npos) << source->damages()[0];
}

TEST(Rawlog, ForeignFilesAreRefusedByName)
{
  const TemporaryFolder folder;
  const auto refusal = [&](const std::string& path)
  {
    InputOptions options;
    options.paths = {path};
    return complaint<std::runtime_error>(options);
  };
  EXPECT_NE(refusal(folder.write("text.rawlog", "this is a text, not a log")).find("text.rawlog"),
            std::string::npos);
  EXPECT_NE(refusal(folder.write("zeros.rawlog", std::string(10000, '\0'))).find("zeros.rawlog"),
            std::string::npos);
  writeLog(folder / "map.rawlog", {mrpt::maps::CSimplePointsMap::Create()});
  EXPECT_NE(refusal(folder / "map.rawlog").find("begins with a mrpt::maps::CSimplePointsMap"),
            std::string::npos);
  EXPECT_NE(refusal(folder / "none.rawlog").find("does not exist"), std::string::npos);
  EXPECT_EQ(refusal(folder.write("empty.rawlog", "")), "") << "an empty log has no items";
}

TEST(TrialRun, OutlivesWhatItsAttemptDoesNot)
{
  using Step = std::function<void()>;
  using Bytes = std::vector<uint8_t>;
  const auto never = [] { return false; };
  const Bytes large(3'000'000, 7);
  const auto well = tryInChild([&](const Step& step) { return step(), step(), large; }, never);
  EXPECT_EQ(well.steps, 2U);
  EXPECT_FALSE(well.failure.has_value());
  EXPECT_EQ(well.found, large);
  const auto crashed = tryInChild([](const Step& step) { return step(), std::abort(), Bytes(1); }, never);
  EXPECT_EQ(crashed.steps, 1U);
  EXPECT_TRUE(crashed.failure.has_value());
  EXPECT_TRUE(crashed.found.empty());
  const auto threw = tryInChild([](const Step&) -> Bytes { throw std::runtime_error("x"); }, never);
  EXPECT_TRUE(threw.failure.has_value());
  const auto stopped = tryInChild([](const Step&) { return pause(), Bytes(); }, [] { return true; });
  EXPECT_TRUE(stopped.stopped);
  EXPECT_FALSE(stopped.failure.has_value());
}

TEST(SimpleMap, GivesEveryObservationAtTheMeanOfItsPose)
{
  const TemporaryFolder folder;
  mrpt::maps::CSimpleMap map;
  mrpt::poses::CPose3DPDFGaussian pose(CPose3D(1, 2, 3, 0.1, 0.2, 0.3));
  map.insert(pose, *frame({laser(at(0)), laser(at(1))}));
  for (const std::string name : {"m.simplemap", "m.simplemap.gz"})
  {
    SCOPED_TRACE(name);
    ASSERT_TRUE(map.saveToFile(folder / name));
    const auto items = read(folder / name);
    ASSERT_EQ(items.size(), 2U);
    expectPose(items[1], CPose3D(1, 2, 3, 0.1, 0.2, 0.3));
    const std::string whole = fileContent(folder / name);
    InputOptions options;
    options.paths = {folder.write("cut.simplemap", whole.substr(0, whole.size() / 2))};
    EXPECT_NE(complaint<std::runtime_error>(options).find("cut.simplemap"), std::string::npos);
  }
}

std::string pcd(double x)
{
  return "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\nHEIGHT 1\nVIEWPOINT 1 2 3 "
         "0.70710678 0 0 0.70710678\nPOINTS 1\nDATA ascii\n" +
         std::to_string(x) + " 0 0\n";
}

// The viewpoint is turned by 90 degrees about z: 0.5 m along its x is along the map's y.
TEST(PcdFolder, IsReadInNaturalOrderWithOriginsInTheTurnedFrame)
{
  const TemporaryFolder folder;
  for (const int i : {10, 9, 1, 2}) folder.write("s_" + std::to_string(i) + ".pcd", pcd(i));
  folder.write("notes.txt", "no scan");
  InputOptions options;
  options.paths = {folder.path()};
  options.sensorOrigin = {0.5, 0, 0.25};
  const auto items = read(options);
  ASSERT_EQ(items.size(), 4U);
  for (size_t i = 0; i < 4; ++i)
  {
    const auto& scan = std::get<PointScan>(items[i]);
    const lamap::RayFan& fan = scan.scan.fans.at(0);
    EXPECT_EQ(scan.scan.inMap(fan.rays.at(0).end).x(), (std::vector<double>{1, 2, 9, 10}[i]));
    EXPECT_LT((scan.scan.inMap(fan.centre) - Eigen::Vector3d(1, 2.5, 3.25)).norm(), 1e-6);
  }
}

TEST(PcdFolder, TakesTheKthPoseForTheKthFile)
{
  const TemporaryFolder folder;
  for (const int i : {1, 2, 10}) folder.write("s_" + std::to_string(i) + ".pcd", pcd(i));
  InputOptions options;
  options.paths = {folder.path(), folder / "s_1.pcd"};
  const TemporaryFolder poses;
  options.posesPath =
      poses.write("p.tum", "1 10 0 0 0 0 0 1\n2 20 0 0 0 0 0 1\n3 30 0 0 0 0 0 1\n4 40 0 0 0 0 0 1\n");
  const auto sources = openInputs(options);
  std::vector<double> origins;
  for (const auto& source : sources)
    for (const ScanItem& item : allItems(*source))
      origins.push_back(std::get<PointScan>(item).scan.fans.at(0).centre.x());
  EXPECT_EQ(origins, (std::vector<double>{10, 20, 30, 40}));

  options.paths.pop_back();
  EXPECT_NE(complaint<std::runtime_error>(options).find("4 poses for 3 PCD files"), std::string::npos);
}

TEST(PcdFolder, AFileThatCannotBeReadIsADamageAndTheOthersAreRead)
{
  const TemporaryFolder folder;
  folder.write("s_1.pcd", pcd(1));
  folder.write("s_2.pcd", pcd(2).substr(0, 140));
  folder.write("s_3.pcd", pcd(3));
  InputOptions options;
  options.paths = {folder.path()};
  const auto source = openOne(options);
  EXPECT_EQ(allItems(*source).size(), 2U);
  ASSERT_EQ(source->damages().size(), 1U);
  EXPECT_NE(source->damages()[0].find("s_2.pcd"), std::string::npos);
}

TEST(ScanGraph, GivesPointsInTheMapFrame)
{
  const TemporaryFolder folder;
  octomap::ScanGraph graph;
  for (int i = 0; i < 3; ++i)
  {
    auto* cloud = new octomap::Pointcloud;  // the graph owns it
    cloud->push_back(2, 0, 0);
    cloud->push_back(0, 1, 0.5F);
    graph.addNode(cloud, octomap::pose6d(static_cast<float>(i), 10, 1, 0, 0, kQuarterTurn));
    ASSERT_TRUE(i > 0 || graph.writeBinary(folder / "one.graph"));
  }
  graph.connectPrevious();
  ASSERT_TRUE(graph.writeBinary(folder / "a.graph"));
  const auto items = read(folder / "a.graph");
  ASSERT_EQ(items.size(), 3U);
  const auto& scan = std::get<PointScan>(items[2]);
  const std::vector<lamap::Ray>& rays = scan.scan.fans.at(0).rays;
  EXPECT_LT((scan.scan.inMap(rays.at(0).end) - Eigen::Vector3d(2, 12, 1)).norm(), 1e-5);
  EXPECT_LT((scan.scan.inMap(rays.at(1).end) - Eigen::Vector3d(1, 10, 1.5)).norm(), 1e-5);
  EXPECT_EQ(scan.scan.sensorPose_map.translation().x(), 2);

  const std::string whole = fileContent(folder / "a.graph");
  const size_t sizeOfOne = fileContent(folder / "one.graph").size();  // with two counts of four bytes
  InputOptions options;
  options.paths = {folder.write("cut.graph", whole.substr(0, 4 + 5 * (sizeOfOne - 8) / 2))};
  const auto cut = openOne(options);
  EXPECT_EQ(allItems(*cut).size(), 2U);
  EXPECT_EQ(cut->damages().size(), 1U);
  std::string absurd = whole;
  absurd.replace(4, 4, "\xff\xff\xff\xf0");  // points of the first scan
  options.paths = {folder.write("absurd.graph", absurd)};
  const auto damaged = openOne(options);
  EXPECT_EQ(allItems(*damaged).size(), 0U);
  EXPECT_EQ(damaged->damages().size(), 1U);
  options.paths = {folder.write("foreign.graph", "certainly no graph")};
  EXPECT_NE(complaint<std::runtime_error>(options).find("foreign.graph"), std::string::npos);
}

TEST(Inputs, OptionsThatDoNotFitAreWrongUsage)
{
  const TemporaryFolder folder;
  writeLog(folder / "a.rawlog", {laser(at(0))});
  folder.write("a.pcd", pcd(1));
  folder.write("a.txt", "?");
  InputOptions options;
  options.paths = {folder / "a.txt"};
  EXPECT_NE(complaint<UsageError>(options).find("expected .rawlog"), std::string::npos);
  options.paths = {folder / "a.rawlog"};
  options.sensorOrigin = {0, 0, 1};
  EXPECT_NE(complaint<UsageError>(options).find("--sensor-origin"), std::string::npos);
  options.sensorOrigin.setZero();
  options.paths = {folder / "a.pcd"};
  options.standingStill = true;
  EXPECT_NE(complaint<UsageError>(options).find("--static"), std::string::npos);
  options.standingStill = false;
  options.paths = {folder / "a.pcd", folder / "a.rawlog"};
  options.posesPath = folder.write("p.tum", "1 10 0 0 0 0 0 1\n");
  EXPECT_NE(complaint<UsageError>(options).find("--poses"), std::string::npos);
}
}  // namespace
