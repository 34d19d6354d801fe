#include <gtest/gtest.h>
#include <lamap_tools/commands/log_info.h>
#include <lamap_tools/commands/map_build.h>
#include <lamap_tools/commands/thin_log.h>
#include <lamap_tools/files/usage_error.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>

#include <sstream>

#include "support/small_logs.h"
#include "support/temporary_folder.h"

namespace
{
using namespace lamap::tools;
using namespace lamap::test;

mrpt::obs::CObservation2DRangeScan::Ptr labelled(const std::string& label, double seconds)
{
  auto scan = laser(at(seconds), 2 + 0.1F * static_cast<float>(seconds));
  scan->sensorLabel = label;
  return scan;
}

/// Of sensors A and B, a scan each at 0, 1, …, count − 1 s after the beginning of the log.
Objects twoSensors(int count)
{
  Objects objects;
  for (int i = 0; i < count; ++i)
    objects.insert(objects.end(), {odometry(at(i), 0.1 * i, 0, 0), labelled("A", i), labelled("B", i)});
  return objects;
}

struct Choosing
{
  std::vector<std::string> sensors{};
  uint64_t every = 1;
  std::string from{};
  std::string to{};

  [[nodiscard]] ScanChoice choice() const
  {
    ScanChoice choice;
    choice.sensors = sensors;
    choice.every = every;
    if (!from.empty()) choice.from = LogTime("--from", from);
    if (!to.empty()) choice.to = LogTime("--to", to);
    return choice;
  }
};

/// "A0 B0 A1": label and seconds of each scan that is chosen.
std::string chosen(const std::string& path, const Choosing& choosing)
{
  InputOptions options;
  options.paths = {path};
  options.choice = choosing.choice();
  std::string all;
  (void)visitScans(openInputs(options), options.shouldStop, nullptr,
                   [&](const ScanItem& item, const ScanSource& /*source*/)
                   {
                     const auto& scan = *std::get<ObservedScan>(item).observation;
                     const double seconds = mrpt::Clock::toDouble(scan.timestamp) - 1e9;
                     all +=
                         (all.empty() ? "" : " ") + scan.sensorLabel + std::to_string(std::lround(seconds));
                   });
  return all;
}

template <class Error>
std::string complaint(const std::string& path, const Choosing& choosing)
{
  try
  {
    (void)chosen(path, choosing);
  }
  catch (const Error& error)
  {
    return error.what();
  }
  return "";
}

class Choice : public testing::Test
{
 protected:
  Choice() { writeLog(log_, twoSensors(4)); }

  TemporaryFolder folder_;
  std::string log_ = folder_ / "a.rawlog";
};

TEST_F(Choice, TakesSensorsByTheirLabels)
{
  EXPECT_EQ(chosen(log_, {{"B"}}), "B0 B1 B2 B3");
  EXPECT_EQ(chosen(log_, {{"B", "A"}}), chosen(log_, {}));
  const std::string text = complaint<std::runtime_error>(log_, {{"A", "C"}});
  EXPECT_NE(text.find("there is no 'C' in " + log_ + "; there are: 'A', 'B'"), std::string::npos) << text;
}

TEST_F(Choice, AnObservationWithoutALabelGoesByItsClass)
{
  writeLog(log_, {odometry(at(0), 0, 0, 0), laser(at(0)), labelled("A", 1), odometry(at(1), 0, 0, 0)});
  EXPECT_EQ(chosen(log_, {{"CObservation2DRangeScan"}}), "0");
}

// At 1, 2 and 3 s, of which every second one is taken: of both sensors those at 1 and 3 s.
TEST_F(Choice, EveryNthIsCountedForEachSensorAfterTheOtherChoices)
{
  EXPECT_EQ(chosen(log_, {{}, 3}), "A0 B0 A3 B3");
  EXPECT_EQ(chosen(log_, {{}, 2, "1"}), "A1 B1 A3 B3");
  EXPECT_EQ(chosen(log_, {{"A"}, 2, "1"}), "A1 A3");
}

// The log begins at 1e9 s since 1970.
TEST_F(Choice, TimesCountFromTheFirstTimeStampOrAreAbsolute)
{
  for (const auto& [from, to] :
       std::vector<std::pair<std::string, std::string>>{{"1", "2"},
                                                        {"0.5", "2.999"},
                                                        {"1000000001", "1000000002"},
                                                        {"2001-09-09T01:46:41", "2001-09-09 01:46:42.0Z"},
                                                        {"1", "1000000002.5"}})
    EXPECT_EQ(chosen(log_, {{"A"}, 1, from, to}), "A1 A2") << from << " to " << to;
  EXPECT_EQ(chosen(log_, {{"A"}, 1, "2001-09-09", "0"}), "A0");
  EXPECT_EQ(chosen(log_, {{"A"}, 1, "3"}), "A3");
}

// The log begins 80,000 s before midnight.
TEST_F(Choice, ADateAloneIsTheWholeDay)
{
  Objects objects{odometry(at(0), 0, 0, 0)};
  for (const double seconds : {0, 79999, 80000, 166400}) objects.push_back(labelled("A", seconds));
  objects.push_back(odometry(at(200000), 1, 0, 0));
  writeLog(log_, objects);
  EXPECT_EQ(chosen(log_, {{}, 1, "", "2001-09-09"}), "A0 A79999");
  EXPECT_EQ(chosen(log_, {{}, 1, "2001-09-10", "2001-09-10"}), "A80000");
  EXPECT_EQ(chosen(log_, {{}, 1, "2001-09-09T12:00", "2001-09-09"}), "A79999") << "not later than its day";
  EXPECT_EQ(chosen(log_, {{}, 1, "", "2001-09-10T00:00"}), "A0 A79999 A80000") << "midnight is a moment";
}

TEST_F(Choice, ScansWithoutATimeStampAreCountedWhereATimeIsAskedFor)
{
  auto untimed = labelled("B", 1);
  untimed->timestamp = INVALID_TIMESTAMP;
  const std::string path = folder_ / "a.simplemap";
  const auto write = [&](const std::vector<mrpt::obs::CObservation::Ptr>& scans)
  {
    mrpt::maps::CSimpleMap map;
    map.insert(std::make_shared<mrpt::poses::CPose3DPDFGaussian>(), frame(scans));
    ASSERT_TRUE(map.saveToFile(path));
  };
  write({labelled("A", 0), untimed, untimed, labelled("A", 2)});
  InputOptions options;
  options.paths = {path};
  options.choice = Choosing{{}, 1, "1"}.choice();
  EXPECT_EQ(
      readLogInfo(options).choice,
      "1 of 4 observations chosen by --from 1; --from and --to leave out 2 without a time stamp (B: 2)");
  options.choice = Choosing{{}, 2}.choice();
  EXPECT_EQ(readLogInfo(options).choice, "2 of 4 observations chosen by --every 2") << "no time is needed";

  write({untimed, untimed});
  const std::string text = complaint<std::runtime_error>(path, {{}, 1, "", "5"});
  EXPECT_NE(text.find("selects none of 2 observations of " + path +
                      "; --from and --to leave out 2 without a time stamp (B: 2)"),
            std::string::npos)
      << text;
}

TEST_F(Choice, TheFirstTimeStampIsThatOfTheWholeLog)
{
  writeLog(log_, {odometry(at(0), 0, 0, 0), labelled("A", 2), labelled("B", 5), labelled("B", 6),
                  odometry(at(9), 0, 0, 0)});
  EXPECT_EQ(chosen(log_, {{"B"}, 1, "", "3"}), "B5") << "3 s after A's only scan";
}

TEST_F(Choice, WrongTimesAndNumbersAreWrongUsage)
{
  for (const std::string time :
       {"-1", "soon", "1 s", "nan", "1e12", "2001-02-31", "2001-9", "2001-09-09T25:00"})
    EXPECT_THROW(LogTime("--from", time), UsageError) << time;
  EXPECT_NE(complaint<UsageError>(log_, {{}, 1, "3", "2"}).find("--from 3 is later than --to 2"),
            std::string::npos);
  EXPECT_NE(complaint<UsageError>(log_, {{}, 0}).find("--every 0"), std::string::npos);
}

TEST_F(Choice, WhatTakesNothingIsAnErrorAndNothingIsWritten)
{
  const std::string text = complaint<std::runtime_error>(log_, {{"A"}, 1, "100"});
  EXPECT_NE(text.find("--sensors A --from 100: selects none of 8 observations of " + log_), std::string::npos)
      << text;
  BuildOptions build;
  build.inputs.paths = {log_};
  build.inputs.choice = Choosing{{}, 1, "100"}.choice();
  build.map.mapName = "bgkMap";
  build.outPath = folder_ / "a.lamap.gz";
  EXPECT_THROW((void)buildMap(build), std::runtime_error);
  EXPECT_EQ(folder_.size(), 1U) << "the log";
}

TEST_F(Choice, GivesTheMapOfALogThatHoldsNothingElse)
{
  Objects part;
  for (const int i : {0, 1, 2, 3}) part.push_back(odometry(at(i), 0.1 * i, 0, 0));
  part.insert(part.end(), {labelled("B", 1), labelled("B", 3)});
  writeLog(folder_ / "part.rawlog", part);
  BuildOptions build;
  build.map.mapName = "bgkMap";
  build.inputs.paths = {folder_ / "part.rawlog"};
  build.outPath = folder_ / "part.lamap.gz";
  (void)buildMap(build);
  build.inputs.paths = {log_};
  build.inputs.choice = Choosing{{"B"}, 2, "1", "3"}.choice();
  build.outPath = folder_ / "chosen.lamap.gz";
  const BuildReport report = buildMap(build);
  EXPECT_EQ(fileContent(folder_ / "chosen.lamap.gz"), fileContent(folder_ / "part.lamap.gz"));
  EXPECT_EQ(report.inputs.at(0).notes.back(),
            "2 of 8 observations chosen by --sensors B --from 1 --to 3 --every 2");
}

TEST_F(Choice, CountsThroughAllInputs)
{
  InputOptions options;
  for (int i = 0; i < 5; ++i)
    options.paths.push_back(
        folder_.write(std::to_string(i) + ".pcd",
                      "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 1\nHEIGHT 1\nVIEWPOINT " +
                          std::to_string(i) + " 0 0 1 0 0 0\nPOINTS 1\nDATA ascii\n9 0 0\n"));
  options.choice.every = 2;
  std::vector<double> origins;
  (void)visitScans(openInputs(options), options.shouldStop, nullptr,
                   [&](const ScanItem& item, const ScanSource& /*source*/)
                   { origins.push_back(std::get<PointScan>(item).scan.fans.at(0).centre.x()); });
  EXPECT_EQ(origins, (std::vector<double>{0, 2, 4}));
}

TEST_F(Choice, AppliesToSimpleMapsAndToInfo)
{
  mrpt::maps::CSimpleMap map;
  for (const int i : {0, 1, 2, 3})
    map.insert(std::make_shared<mrpt::poses::CPose3DPDFGaussian>(),
               frame({labelled("A", i), labelled("B", i)}));
  const std::string path = folder_ / "a.simplemap";
  ASSERT_TRUE(map.saveToFile(path));
  EXPECT_EQ(chosen(path, {{"B"}, 2, "1"}), "B1 B3");

  InputOptions options;
  options.paths = {path};
  options.choice = Choosing{{"B"}, 2, "1"}.choice();
  const LogInfo info = readLogInfo(options);
  ASSERT_EQ(info.sensors.size(), 1U);
  EXPECT_EQ(info.sensors[0].scans, 2U);
  EXPECT_EQ(logInfoJson(info)["sensors"][0]["first"], 1.0) << "since the first time stamp of the whole log";
  EXPECT_EQ(info.choice, "2 of 8 observations chosen by --sensors B --from 1 --every 2");
}

// Odometry stays, so that the part has the poses of the whole.
TEST_F(Choice, WritesAPartOfALog)
{
  ThinOptions options;
  options.inPath = log_;
  options.outPath = folder_ / "part.rawlog";
  options.choice = Choosing{{"A"}, 1, "1", "2"}.choice();
  const ThinReport report = thinLog(options);
  EXPECT_EQ(report.choice, "2 of 8 observations chosen by --sensors A --from 1 --to 2");
  EXPECT_EQ(chosen(options.outPath, {}), "A1 A2");
  InputOptions whole;
  whole.paths = {options.outPath};
  EXPECT_EQ(openInputs(whole).at(0)->notes().at(0), "4 poses from odometry");

  options.choice = Choosing{{"C"}}.choice();
  options.outPath = folder_ / "none.rawlog";
  EXPECT_THROW((void)thinLog(options), std::runtime_error);
  options.choice = Choosing{{}, 1, "50"}.choice();
  EXPECT_THROW((void)thinLog(options), std::runtime_error);
  EXPECT_EQ(folder_.size(), 2U) << "the log and its part";
}

TEST_F(Choice, WritesAPartOfASimpleMap)
{
  mrpt::maps::CSimpleMap map;
  for (const int i : {0, 1, 2})
    map.insert(std::make_shared<mrpt::poses::CPose3DPDFGaussian>(), frame({labelled("A", i)}));
  ThinOptions options;
  options.inPath = folder_ / "a.simplemap";
  ASSERT_TRUE(map.saveToFile(options.inPath));
  options.outPath = folder_ / "part.simplemap";
  options.choice = Choosing{{}, 1, "1"}.choice();
  (void)thinLog(options);
  mrpt::maps::CSimpleMap part;
  ASSERT_TRUE(part.loadFromFile(options.outPath));
  EXPECT_EQ(part.size(), 2U) << "no pose without observations";
}
}  // namespace
