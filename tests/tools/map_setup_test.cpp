#include <gtest/gtest.h>
#include <lamap_mrpt/maps/CBGKMap.h>
#include <lamap_tools/config/map_setup.h>
#include <lamap_tools/config/plugin_run.h>
#include <lamap_tools/files/usage_error.h>
#include <mrpt/maps/COctoMap.h>

#include <cstdlib>
#include <stdexcept>

#include "support/temporary_folder.h"

namespace
{
using namespace lamap::tools;
using lamap::test::TemporaryFolder;

/// The message that refuses a request, and whether it counts as wrong usage.
struct Refusal
{
  std::string text;
  bool wrongUsage = false;
};

Refusal refusalOf(const MapRequest& request)
{
  try
  {
    (void)createMap(readMapDefinition(request));
  }
  catch (const UsageError& error)
  {
    return {error.what(), true};
  }
  catch (const std::runtime_error& error)
  {
    return {error.what(), false};
  }
  return {};
}

void expectRefusal(const MapRequest& request, bool wrongUsage, const std::vector<std::string>& words)
{
  const Refusal refusal = refusalOf(request);
  EXPECT_EQ(refusal.wrongUsage, wrongUsage) << refusal.text;
  for (const std::string& word : words)
    EXPECT_NE(refusal.text.find(word), std::string::npos)
        << "\"" << refusal.text << "\" says nothing of " << word;
}

TEST(MapNames, AreKnownByAliasAndByClassNameWithAndWithoutNamespace)
{
  for (const std::string name : {"bgkMap", "CBGKMap", "lamap::CBGKMap"})
  {
    const auto map = createMap(readMapDefinition({name, "", {}}));
    EXPECT_NE(dynamic_cast<lamap::CBGKMap*>(map.get()), nullptr) << name;
  }
  for (const std::string name : {"octoMap", "COctoMap", "mrpt::maps::COctoMap"})
    EXPECT_NE(dynamic_cast<mrpt::maps::COctoMap*>(createMap(readMapDefinition({name, "", {}})).get()),
              nullptr)
        << name;
  EXPECT_TRUE(isLearnedMap("bgkMap"));
  EXPECT_FALSE(isLearnedMap("octoMap"));
}

TEST(MapNames, AMistypedOneNamesTheNearest)
{
  expectRefusal({"bkgMap", "", {}}, true, {"bkgMap", "bgkMap"});
  expectRefusal({"octomaps", "", {}}, true, {"octomaps", "octoMap"});
  expectRefusal({"", "", {}}, true, {"-m", "-c"});
}

TEST(Settings, TakeEffectAndThoseOfTheMapItselfWin)
{
  const auto map = createMap(readMapDefinition({"bgkMap",
                                                "",
                                                {"insertOpts.maxRange=3", "creationOpts.resolution=0.25"},
                                                {"insertOpts.MAXRANGE=4.5"}}));
  const auto& bgk = dynamic_cast<const lamap::CBGKMap&>(*map);
  EXPECT_EQ(bgk.resolution(), 0.25);
  EXPECT_TRUE(bgk.optionIs("insertOpts", "maxRange", "4.5"));

  const auto octo = createMap(readMapDefinition({"octoMap", "", {"creationOpts.resolution=0.5"}}));
  EXPECT_EQ(dynamic_cast<const mrpt::maps::COctoMap&>(*octo).getResolution(), 0.5);
}

TEST(Settings, MistypedOnesNameWhatIsWrongAndTheNearestRightOne)
{
  expectRefusal({"bgkMap", "", {"insertOpts.maxRagne=3"}}, true, {"maxRagne", "maxRange"});
  expectRefusal({"bgkMap", "", {"insertOps.maxRange=3"}}, true, {"insertOps", "insertOpts"});
  expectRefusal({"bgkMap", "", {"insertOpts.maxRange=3m"}}, true, {"maxRange", "3m"});
  expectRefusal({"bgkMap", "", {"insertOpts.freeSpace=lines"}}, true, {"freeSpace", "lines", "line"});
  for (const std::string bad : {"0", "-1", "nan", "abc", "inf"})
    expectRefusal({"bgkMap", "", {"creationOpts.resolution=" + bad}}, true, {"resolution", bad});
  for (const std::string bad :
       {"x", "insertOpts.maxRange", "maxRange=3", "insertOpts.maxRange=", ".a=1", "a.=1"})
    expectRefusal({"bgkMap", "", {bad}}, true, {bad, "section.key=value"});
}

// MRPT would take one of the two in silence.
TEST(Settings, AKeyIsNotGivenTwice)
{
  expectRefusal({"bgkMap", "", {"insertOpts.maxRange=3", "insertOpts.maxRange=3"}}, true,
                {"insertOpts.maxRange=3", "given twice"});
  expectRefusal({"octoMap", "", {}, {"creationOpts.resolution=1", "CreationOpts.Resolution=2"}}, true,
                {"CreationOpts.Resolution=2", "given twice"});
}

// MRPT's loaders silently accept all of these.
TEST(Settings, OfMrptsOwnMapsAreJudgedToo)
{
  expectRefusal({"octoMap", "", {"insertOpts.maxrnge=3"}}, true, {"maxrnge", "maxrange"});
  expectRefusal({"octoMap", "", {"insertOps.maxrange=3"}}, true, {"insertOps", "insertOpts"});
  expectRefusal({"octoMap", "", {"insertOpts.maxrange=3m"}}, true, {"maxrange", "3m", "number"});
  expectRefusal({"octoMap", "", {"insertOpts.pruning=maybe"}}, true, {"pruning", "maybe"});
  expectRefusal({"octoMap", "", {"likelihoodOpts.decimation=2.5"}}, true, {"decimation", "2.5"});
  for (const std::string bad : {"0", "-1", "nan", "abc"})
    expectRefusal({"octoMap", "", {"creationOpts.resolution=" + bad}}, true, {"resolution", bad});
  EXPECT_EQ(refusalOf({"octoMap", "", {"insertOpts.pruning=false", "insertOpts.maxrange=30"}}).text, "");
}

const std::string kWhole =
    "[map]\nbgkMap_count=1 // one\n[map_bgkMap_00_creationOpts]\nresolution=0.2 // m\n"
    "[map_bgkMap_00_insertOpts]\nmaxRange = 12\n";

TEST(ConfigFile, SaysWhichMapAndSettingsOverrideIt)
{
  const TemporaryFolder folder;
  const std::string path = folder.write("a.ini", kWhole);
  const auto map = createMap(readMapDefinition({"", path, {}}));
  EXPECT_EQ(dynamic_cast<const lamap::CBGKMap&>(*map).resolution(), 0.2);
  const auto finer = createMap(readMapDefinition({"bgkMap", path, {"creationOpts.resolution=0.05"}}));
  EXPECT_EQ(dynamic_cast<const lamap::CBGKMap&>(*finer).resolution(), 0.05);
  EXPECT_TRUE(dynamic_cast<const lamap::CBGKMap&>(*finer).optionIs("insertOpts", "maxRange", "12"));
}

TEST(ConfigFile, MayUseTheClassNameAndMayCountSeveralMaps)
{
  const TemporaryFolder folder;
  const std::string byClass = folder.write(
      "a.ini", "[map]\nlamap::CBGKMap_count=1\n[map_lamap::CBGKMap_00_creationOpts]\nresolution=0.3\n");
  for (const std::string name : {"", "bgkMap"})
    EXPECT_EQ(
        dynamic_cast<const lamap::CBGKMap&>(*createMap(readMapDefinition({name, byClass, {}}))).resolution(),
        0.3);

  const std::string two = folder.write(
      "b.ini", kWhole + "[map_octoMap_00_creationOpts]\nresolution=0.7\n[map]\noctoMap_count=1\n");
  expectRefusal({"", two, {}}, false, {"b.ini", "bgkMap", "octoMap", "-m"});
  const auto octo = createMap(readMapDefinition({"octoMap", two, {}}));
  EXPECT_EQ(dynamic_cast<const mrpt::maps::COctoMap&>(*octo).getResolution(), 0.7);
}

TEST(ConfigFile, NamesWhatNothingReads)
{
  const TemporaryFolder folder;
  const auto with = [&](const std::string& text) { return MapRequest{"", folder.write("a.ini", text), {}}; };
  expectRefusal(with("[map]\nbkgMap_count=1\n"), false, {"a.ini", "bkgMap_count", "bgkMap_count"});
  expectRefusal(with("[map]\nbgkMap_count=one\n"), false, {"bgkMap_count", "one"});
  expectRefusal(with("[map]\nbgkMap_count=2\n"), false, {"bgkMap_count", "2"});
  expectRefusal(with("[map]\nbgkMap_count=0\n"), false, {"asks for no map"});
  expectRefusal(with("[mapp]\nbgkMap_count=1\n"), false, {"[mapp]", "[map]"});
  expectRefusal(with(""), false, {"a.ini", "bgkMap_count"});
  expectRefusal(with(kWhole + "maxRagne=3\n"), false, {"a.ini", "maxRagne", "maxRange"});
  expectRefusal(with(kWhole + "minRange=3m\n"), false, {"a.ini", "minRange", "3m"});
  expectRefusal(with(kWhole + "[map_bgkMap_00_insertOptions]\nmaxRange=3\n"), false,
                {"insertOptions", "insertOpts"});
  expectRefusal(with(kWhole + "[map_bgkMap_01_insertOpts]\nmaxRange=3\n"), false, {"_01_", "_00_"});
  expectRefusal(with(kWhole + "[mop_bgkMap_00_insertOpts]\nmaxRange=3\n"), false,
                {"mop_bgkMap", "map_bgkMap"});
  expectRefusal({"octoMap", folder.write("a.ini", kWhole), {}}, false, {"bgkMap", "octoMap"});
  expectRefusal({"", folder / "none.ini", {}}, false, {"none.ini", "cannot be read"});
  expectRefusal({"", folder.path(), {}}, false, {"cannot be read"});
  EXPECT_EQ(refusalOf(with(kWhole)).text, "");
}

std::string stockComplaint(const TemporaryFolder& folder, const std::string& text)
{
  try
  {
    checkStockConfig(folder.write("app.ini", text));
  }
  catch (const std::runtime_error& error)
  {
    return error.what();
  }
  return "";
}

const std::string kApplication =
    "[App]\nlogOutput_dir=X\npointsMap_count=1\nbgkMap_count=1\nparticle_count=7\n"
    "[App_pointsMap_00_insertOpts]\nminDistBetweenLaserPoints=0.05\nunheardOf=1\n"
    "[App_bgkMap_00_creationOpts]\nresolution=0.1\n[App_bgkMap_00_insertOpts]\nmaxRange=10 ; "
    "metres\n[Other]\nx=1\n";

TEST(ConfigFile, NamesLinesThatAreNoAssignment)
{
  const TemporaryFolder folder;
  const auto with = [&](const std::string& line)
  {
    const std::string text =
        "[map]\nbgkMap_count=1\n[map_bgkMap_00_creationOpts]\n# a comment\n" + line + "\n";
    return MapRequest{"", folder.write("a.ini", text), {}};
  };
  for (const std::string line : {"resolution 0.05", "resolution: 0.05", "garbage"})
    expectRefusal(with(line), false, {"line 5", line, "map_bgkMap_00_creationOpts"});
  EXPECT_EQ(refusalOf(with("resolution = 0.05  // [m]")).text, "");
  EXPECT_EQ(refusalOf(with("\r\nresolution = 0.05\r\n\r")).text, "") << "lines end as on Windows";
}

TEST(ConfigFile, NamesAKeyThatStandsTwiceInASection)
{
  const TemporaryFolder folder;
  const auto with = [&](const std::string& text) {
    return MapRequest{"", folder.write("a.ini", "[map]\nbgkMap_count=1\n" + text), {}};
  };
  const std::string insert = "[map_bgkMap_00_insertOpts]\n";
  expectRefusal(with(insert + "maxRange = 5\n\nmaxRange = 6\n"), false,
                {"line 6", "maxRange", "given twice", "map_bgkMap_00_insertOpts", "first in line 4"});
  expectRefusal(
      with(insert + "maxRange=5\n[map_bgkMap_00_creationOpts]\nresolution=0.2\n" + insert + "MaxRange=5\n"),
      false, {"line 8", "MaxRange", "given twice", "first in line 4"});
  expectRefusal(with("bgkMap_count=1\n"), false, {"line 3", "bgkMap_count", "given twice"});
  EXPECT_EQ(refusalOf(with(insert + "maxRange=5\n# maxRange=6\n[map_bgkMap_00_renderOpts]\n")).text, "");
}

TEST(StockConfig, IsAcceptedIfItAsksForOurMapAndAllOfItIsRead)
{
  const TemporaryFolder folder;
  EXPECT_EQ(stockComplaint(folder, kApplication), "");
  EXPECT_EQ(
      stockComplaint(folder, "[A]\nlamap::CBGKMap_count=2\n[A_lamap::CBGKMap_01_insertOpts]\nmaxRange=1\n"),
      "");
}

TEST(StockConfig, NamesWhatTheApplicationWouldIgnore)
{
  const TemporaryFolder folder;
  const auto expectWords = [&](const std::string& text, const std::vector<std::string>& words)
  {
    const std::string complaint = stockComplaint(folder, text);
    for (const std::string& word : words)
      EXPECT_NE(complaint.find(word), std::string::npos)
          << "\"" << complaint << "\" says nothing of " << word;
  };
  const auto changed = [](const std::string& from, const std::string& to)
  {
    std::string text = kApplication;
    return text.replace(text.find(from), from.size(), to);
  };
  expectWords(changed("bgkMap_count=1", "bkgMap_count=1"), {"app.ini", "bkgMap_count", "bgkMap_count"});
  expectWords(changed("bgkMap_count=1", "bgkMap_count=0"), {"asks for none", "bgkMap_count = 1"});
  expectWords(changed("bgkMap_count=1", "bgkMap_count=yes"), {"bgkMap_count", "yes"});
  expectWords(changed("maxRange", "maxRagne"), {"maxRagne", "maxRange"});
  expectWords(changed("maxRange=10", "maxRange=10m"), {"maxRange", "10m"});
  expectWords(changed("maxRange=10", "maxRange=10\nmaxRange=20"), {"maxRange", "given twice"});
  expectWords(changed("App_bgkMap_00_insertOpts", "App_bgkMap_01_insertOpts"),
              {"_01_insertOpts", "_00_insertOpts"});
  expectWords(changed("App_bgkMap_00_insertOpts", "App_bkgMap_00_insertOpts"), {"App_bkgMap", "App_bgkMap"});
  expectWords(changed("App_bgkMap_00_insertOpts", "Apq_bgkMap_00_insertOpts"), {"Apq_bgkMap", "App_bgkMap"});
  expectWords(changed("App_bgkMap_00_insertOpts", "App_bgkMap_00_insrtOpts"), {"insrtOpts", "insertOpts"});
  expectWords("", {"asks for none"});
  // Those of `lamap build`, and of another application.
  expectWords(changed("App_bgkMap_00_insertOpts", "map_bgkMap_00_insertOpts"),
              {"[map_bgkMap_00_insertOpts]", "not read", "[App_bgkMap_00_insertOpts]"});
  expectWords(kApplication + "[MAP_gpMap_00_insertOpts]\nmaxRange=3\n",
              {"[MAP_gpMap_00_insertOpts]", "not read"});
  expectWords(kApplication + "[map_lamap::CBGKMap_00_insertOpts]\nmaxRange=3\n",
              {"[map_lamap::CBGKMap_00_insertOpts]", "not read"});
  expectWords(
      "[MappingApplication]\nbgkMap_count=1\n[map_bgkMap_00_insertOpts]\nmaxRange=3\n",
      {"[map_bgkMap_00_insertOpts]", "no section [map] counts", "[MappingApplication_bgkMap_00_insertOpts]"});
  expectWords(kApplication + "[LocalizationOfARobot_gpMap_00_insertOpts]\nmaxRange=3\n",
              {"[LocalizationOfARobot_gpMap_00_insertOpts]", "no section [LocalizationOfARobot] counts"});
  // One file of two applications, or of one that is told to have no such map for now.
  for (const char* count : {"0", "1"})
    EXPECT_EQ(stockComplaint(folder, kApplication + "[Two]\nbgkMap_count=" + count +
                                         "\n[Two_bgkMap_00_insertOpts]\nmaxRange=3\n"),
              "");
}

TEST(Plugin, IsTheLibraryThisProgramRunsWith)
{
  EXPECT_NE(pluginPath().find("libmrpt-lamap.so"), std::string::npos);
  EXPECT_EQ(pluginPath().front(), '/');
  setenv("LAMAP_PLUGIN", "/nowhere/libmrpt-lamap.so", 1);
  EXPECT_THROW((void)pluginPath(), std::runtime_error);
  unsetenv("LAMAP_PLUGIN");
}
}  // namespace
