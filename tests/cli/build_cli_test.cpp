// The real program: exit codes, signals, what stands on which stream.
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <thread>

#include "program.h"
#include "support/small_logs.h"

namespace
{
using namespace lamap::test;

class BuildProgram : public testing::Test
{
 protected:
  Outcome run(const std::vector<std::string>& arguments) const { return Program(streams_, arguments).wait(); }

  std::string smallLog(int scans = 3) const
  {
    Objects objects;
    for (int i = 0; i < scans; ++i)
    {
      objects.push_back(odometry(at(i), 0.01 * i, 0, 0));
      objects.push_back(laser(at(i), 15));
    }
    writeLog(folder_ / "a.rawlog", objects, false);
    return folder_ / "a.rawlog";
  }

  TemporaryFolder folder_;
  TemporaryFolder streams_;
};

TEST_F(BuildProgram, SavesAMapAndEndsWith0)
{
  const Outcome outcome = run({"build", "-i", smallLog(), "-m", "bgkMap", "-o", folder_ / "a.lamap.gz"});
  EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  EXPECT_NE(outcome.out.find("3 CObservation2DRangeScan"), std::string::npos) << outcome.out;
  EXPECT_GT(std::filesystem::file_size(folder_ / "a.lamap.gz"), 100U);
  EXPECT_EQ(
      run({"build", "-i", folder_ / "a.rawlog", "-m", "bgkMap", "-o", folder_ / "b.lamap.gz", "--threads",
           "2", "-s", "insertOpts.maxRange=30", "-s", "creationOpts.resolution=0.2", "--json"})
          .exitCode,
      0);
}

// MRPT's loggers print to std::cout.
TEST_F(BuildProgram, TheStandardOutputHoldsResultsAlone)
{
  const Outcome outcome = run({"build", "-i", smallLog(), "-m", "bgkMap", "-o", folder_ / "a.lamap.gz", "-s",
                               "insertOpts.minRange=15.25", "--json"});
  EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("closer than the minimum range"), std::string::npos) << outcome.err;
  EXPECT_EQ(outcome.out.substr(0, 2), "{\n") << outcome.out;
}

TEST_F(BuildProgram, WrongUsageEndsWith2)
{
  const std::string log = smallLog();
  const std::string out = folder_ / "a.lamap.gz";
  const std::vector<std::vector<std::string>> wrong{
      {},
      {"bild"},
      {"build"},
      {"build", "--frob"},
      {"build", "-i", log, "-m", "bgkMap"},
      {"build", "-i", log, "-o", out},
      {"build", "-i", log, "-m", "bkgMap", "-o", out},
      {"build", "-i", log, "-m", "bgkMap", "-o", folder_ / "a.txt"},
      {"build", "-i", log, "-m", "bgkMap", "-o", out, "-s", "maxRange"},
      {"build", "-i", log, "-m", "bgkMap", "-o", out, "--threads", "-1"},
      {"run"},
      {"run", "--frob", "--", "true"}};
  for (const auto& arguments : wrong)
  {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exitCode, 2) << (arguments.empty() ? "" : arguments.back()) << "\n" << outcome.err;
    EXPECT_NE(outcome.err, "");
  }
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST_F(BuildProgram, WrongWordsAreNamedBesideTheRightOnes)
{
  const std::string log = smallLog();
  const auto message = [&](const std::vector<std::string>& arguments) { return run(arguments).err; };
  EXPECT_NE(message({"bild"}).find("'bild' is not a subcommand; did you mean build?"), std::string::npos);
  EXPECT_NE(message({"frobnicate"}).find("'frobnicate' is not a subcommand; there are: build, compare"),
            std::string::npos);
  EXPECT_NE(message({}).find("There are: build"), std::string::npos);
  for (const std::string threads : {"-1", "two", "1.5", "1025", "99999999999999999999"})
    EXPECT_NE(
        message({"build", "-i", log, "-m", "bgkMap", "-o", folder_ / "a.lamap.gz", "--threads", threads})
            .find("--threads: '" + threads + "' is not a whole number from 0 to 1024"),
        std::string::npos)
        << threads;
  EXPECT_NE(message({"render", "a.lamap.gz", "-o", "a.png", "--view", "iso"})
                .find("--view: 'iso' is none of: 3d, slice, top"),
            std::string::npos);
  EXPECT_NE(message({"run", "--", "true", folder_ / "none.ini"}).find("none.ini: there is no such file"),
            std::string::npos);
}

TEST_F(BuildProgram, FailuresEndWith1AndWriteNothing)
{
  const std::string log = smallLog();
  const auto expect1 = [&](const std::vector<std::string>& arguments, const std::string& word)
  {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exitCode, 1) << outcome.err;
    EXPECT_NE(outcome.err.find(word), std::string::npos) << outcome.err;
  };
  const std::string out = folder_ / "a.lamap.gz";
  expect1({"build", "-i", folder_ / "none.rawlog", "-m", "bgkMap", "-o", out}, "none.rawlog");
  expect1({"build", "-i", log, "-m", "bgkMap", "-o", folder_ / "none/a.lamap.gz"}, "none");
  expect1({"build", "-i", folder_.write("text.rawlog", "not a log at all"), "-m", "bgkMap", "-o", out},
          "text.rawlog");
  expect1({"build", "-i", folder_.write("empty.rawlog", ""), "-m", "bgkMap", "-o", out},
          "not one usable scan");
  expect1({"run", "--", "certainly-no-such-program"}, "certainly-no-such-program");
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST_F(BuildProgram, ACutLogIsSavedAndEndsWith1OrIfAllowedWith0)
{
  const std::string whole = fileContent(smallLog(8));
  const std::string cut = folder_.write("cut.rawlog", whole.substr(0, whole.size() / 2 + 3));
  const std::vector<std::string> arguments{"build", "-i", cut, "-m", "bgkMap", "-o", folder_ / "a.lamap.gz"};
  const Outcome outcome = run(arguments);
  EXPECT_EQ(outcome.exitCode, 1);
  EXPECT_NE(outcome.err.find("cut short"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.out.find("entry 9"), std::string::npos) << outcome.out;
  EXPECT_TRUE(std::filesystem::exists(folder_ / "a.lamap.gz"));
  auto allowed = arguments;
  allowed.emplace_back("--allow-truncated");
  EXPECT_EQ(run(allowed).exitCode, 0);
}

// Stopped in the middle of a long log: the map so far is whole, and going on with it works. How long a
// machine reads before it inserts is not known, so it is given more time until it has inserted something.
TEST_F(BuildProgram, SignalsSaveTheMapSoFarAndEndWith130)
{
  const std::string longLog = smallLog(20000);
  std::filesystem::rename(longLog, folder_ / "long.rawlog");
  const std::string shortLog = smallLog(2);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP})
  {
    const std::string out = folder_ / ("stopped" + std::to_string(signal) + ".lamap.gz");
    Outcome outcome;
    for (int seconds = 1; seconds <= 32 && !std::filesystem::exists(out); seconds *= 2)
    {
      const Program program(streams_, {"build", "-i", folder_ / "long.rawlog", "-m", "bgkMap", "-o", out,
                                       "-s", "creationOpts.resolution=0.02"});
      std::this_thread::sleep_for(std::chrono::seconds(seconds));
      kill(program.process(), signal);
      outcome = program.wait();
      if (outcome.signal == signal) continue;  // on a busy machine it may not have come to watch for signals
      ASSERT_EQ(outcome.exitCode, 130) << outcome.out << outcome.err;
    }
    EXPECT_NE(outcome.err.find("stopped by the user; the map so far is saved to"), std::string::npos)
        << outcome.err;
    EXPECT_EQ(run({"build", "-i", shortLog, "--onto", out, "-o", out}).exitCode, 0);
  }
  EXPECT_EQ(folder_.size(), 5U) << "two logs, three maps, nothing temporary";
}

TEST_F(BuildProgram, InfoDescribesALogAsItDoesAMap)
{
  const std::string log = smallLog();
  const Outcome text = run({"info", log});
  EXPECT_EQ(text.exitCode, 0) << text.err;
  EXPECT_EQ(text.err, "");
  EXPECT_NE(text.out.find("sensor CObservation2DRangeScan"), std::string::npos) << text.out;
  const Outcome json = run({"info", log, "--static", "--json"});
  EXPECT_EQ(json.exitCode, 0) << json.err;
  EXPECT_NE(json.out.find("\"the robot stands at the origin\""), std::string::npos) << json.out;

  const std::string whole = fileContent(log);
  const std::string cut = folder_.write("cut.rawlog", whole.substr(0, whole.size() / 2 + 3));
  const Outcome damaged = run({"info", cut});
  EXPECT_EQ(damaged.exitCode, 1);
  EXPECT_NE(damaged.err.find("cut short"), std::string::npos) << damaged.err;
  EXPECT_EQ(run({"info", cut, "--allow-truncated"}).exitCode, 0);

  const std::string map = folder_ / "a.lamap.gz";
  EXPECT_EQ(run({"build", "-i", log, "-m", "bgkMap", "-o", map}).exitCode, 0);
  EXPECT_EQ(run({"info", map}).exitCode, 0);
  const Outcome wrong = run({"info", map, "--static"});
  EXPECT_EQ(wrong.exitCode, 2);
  EXPECT_NE(wrong.err.find("--static: is for logs only"), std::string::npos) << wrong.err;
  EXPECT_EQ(run({"info", folder_ / "none.rawlog"}).exitCode, 1);

  const std::string poses = folder_.write("p.tum", "5 0 0 0 0 0 0 1\n6 1 0 0 0 0 0 1\n");
  for (const Outcome& outcome : {run({"info", log, "--poses", poses}),
                                 run({"build", "-i", log, "-m", "bgkMap", "-o", map, "--poses", poses})})
  {
    EXPECT_EQ(outcome.exitCode, 1);
    EXPECT_NE(outcome.err.find("none lies within the time of the poses, 5.000 to 6.000 s"), std::string::npos)
        << outcome.err;
  }
}

// What cannot be chosen is named by every command that reads logs; what can, is used.
TEST_F(BuildProgram, EveryCommandThatReadsLogsChoosesFromThem)
{
  const std::string log = smallLog(40);
  const std::string best = folder_ / "best.ini";
  const std::vector<std::vector<std::string>> commands{
      {"info", log},
      {"build", "-i", log, "-m", "bgkMap", "-o", folder_ / "a.lamap.gz"},
      {"eval", "--held-out", "2", "-i", log, "-m", "bgkMap"},
      {"tune", "-i", log, "-m", "bgkMap", "-s", "insertOpts.freeWeight=0.5,1", "--held-out", "2", "-o", best},
      {"compare", "-i", log, "-m", "bgkMap"},
      {"thin", "-i", log, "-o", folder_ / "part.rawlog"}};
  for (const auto& command : commands)
  {
    SCOPED_TRACE(command[0]);
    const auto with = [&](std::vector<std::string> flags)
    {
      flags.insert(flags.begin(), command.begin(), command.end());
      return run(flags);
    };
    const Outcome unknown = with({"--sensors", "FRONT"});
    EXPECT_EQ(unknown.exitCode, 1);
    EXPECT_NE(unknown.err.find("; there are: 'CObservation2DRangeScan'"), std::string::npos) << unknown.err;
    EXPECT_EQ(with({"--from", "soon"}).exitCode, 2);
    EXPECT_EQ(with({"--every", "0"}).exitCode, 2);
    const Outcome none = with({"--from", "2030-01-01"});
    EXPECT_EQ(none.exitCode, 1);
    EXPECT_NE(none.err.find("selects none of 40 observations"), std::string::npos) << none.err;
    const Outcome some =
        with({"--sensors", "CObservation2DRangeScan", "--every", "3", "--from", "4", "--to", "30"});
    EXPECT_EQ(some.exitCode, 0) << some.err;
    EXPECT_NE(some.out.find("observations chosen by --sensors CObservation2DRangeScan"), std::string::npos)
        << some.out;
  }
  EXPECT_EQ(run({"thin", "-i", log, "-o", folder_ / "part.rawlog"}).exitCode, 2) << "neither rays nor scans";
}

// A wall 3 m ahead, seen from (0, 0) along x and from (1, 0) along y, with the same points in both files.
TEST_F(BuildProgram, CloudFrameSaysWhereThePointsAre)
{
  std::string points;
  for (int y = -10; y <= 10; ++y) points += "3.05 " + std::to_string(0.1 * y) + " 0.05\n";
  const std::string turned = "1 0 0 0.70710678 0 0 0.70710678";
  const TemporaryFolder plain;
  const TemporaryFolder withPoses;
  for (const std::string name : {"000000.pcd", "000001.pcd"})
  {
    const auto pcd = [&](const std::string& viewpoint)
    {
      return "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 21\nHEIGHT "
             "1\nVIEWPOINT " +
             viewpoint + "\nPOINTS 21\nDATA ascii\n" + points;
    };
    plain.write(name, pcd("0 0 0 1 0 0 0"));
    withPoses.write(name, pcd(name == "000001.pcd" ? turned : "0 0 0 1 0 0 0"));
  }
  const std::string tum = folder_.write("p.tum", "5 0 0 0 0 0 0 1\n6 1 0 0 0 0 0.70710678 0.70710678\n");
  const std::string kitti = folder_.write("p.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n0 -1 0 1 1 0 0 0 0 0 1 0\n");
  const std::string map = folder_ / "a.lamap.gz";
  const std::vector<std::vector<std::string>> inputs{
      {plain.path(), "--poses", tum}, {plain.path(), "--poses", kitti}, {withPoses.path()}};
  for (std::vector<std::string> arguments : inputs)
  {
    SCOPED_TRACE(arguments.back());
    arguments.insert(arguments.begin(), {"build", "-m", "bgkMap", "-o", map, "-i"});
    const Outcome inMapFrame = run(arguments);
    EXPECT_EQ(inMapFrame.exitCode, 0) << inMapFrame.err;
    EXPECT_NE(inMapFrame.out.find("give --cloud-frame sensor"), std::string::npos) << inMapFrame.out;
    EXPECT_EQ(run({"query", map, "--at", "1.05,3.05,0.05"}).out.find("occupied"), std::string::npos);
    arguments.insert(arguments.end(), {"--cloud-frame", "sensor"});
    const Outcome inSensorFrame = run(arguments);
    EXPECT_EQ(inSensorFrame.exitCode, 0) << inSensorFrame.err;
    EXPECT_EQ(inSensorFrame.out.find("give --cloud-frame"), std::string::npos) << inSensorFrame.out;
    EXPECT_NE(run({"query", map, "--at", "1.05,3.05,0.05"}).out.find("occupied"), std::string::npos);
  }
  const Outcome wrong =
      run({"build", "-i", plain.path(), "-m", "bgkMap", "-o", map, "--cloud-frame", "world"});
  EXPECT_EQ(wrong.exitCode, 2);
  EXPECT_NE(wrong.err.find("--cloud-frame: 'world' is none of: map, sensor"), std::string::npos) << wrong.err;
}

TEST_F(BuildProgram, RunPassesArgumentsEnvironmentAndExitCodeOn)
{
#ifdef LAMAP_SANITIZED
  GTEST_SKIP() << "programs without sanitizers cannot load a library with those of clang";
#endif
  const Outcome outcome =
      run({"run", "--", "sh", "-c", "echo \"$LD_PRELOAD|$1|$2\"; exit 7", "sh", "--", "-m"});
  EXPECT_EQ(outcome.exitCode, 7);
  EXPECT_NE(outcome.out.find("libmrpt-lamap.so"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("|--|-m\n"), std::string::npos) << outcome.out;
  EXPECT_EQ(run({"run", "sh", "-c", "exit 8"}).exitCode, 8) << "without -- too";
  EXPECT_EQ(run({"run", "sh", "-c", "kill -9 $$"}).signal, SIGKILL);
}

TEST_F(BuildProgram, RunRefusesAConfigurationThatTheProgramWouldIgnore)
{
#ifdef LAMAP_SANITIZED
  GTEST_SKIP() << "programs without sanitizers cannot load a library with those of clang";
#endif
  const std::string bad = folder_.write("bad.ini", "[App]\nbkgMap_count=1\n");
  const Outcome outcome = run({"run", "--", "touch", bad, folder_ / "started"});
  EXPECT_EQ(outcome.exitCode, 1);
  EXPECT_NE(outcome.err.find("bgkMap_count"), std::string::npos) << outcome.err;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "started"));
  EXPECT_EQ(run({"run", "--no-check", "--", "touch", bad, folder_ / "started"}).exitCode, 0);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "started"));
  const std::string good = folder_.write("good.ini", "[App]\nbgkMap_count=1\n");
  EXPECT_EQ(run({"run", "--", "true", good}).exitCode, 0);
}
}  // namespace
