// Settings without effect: the tables define them, setting one gives a warning, and the map stays the same.
#include <gtest/gtest.h>
#include <lamap_mrpt/maps/CBGKMap.h>
#include <lamap_mrpt/maps/CGPMap.h>
#include <lamap_mrpt/maps/CHilbertMap.h>
#include <lamap_mrpt/maps/COverlappingHilbertMap.h>

#include <cstdlib>
#include <iostream>
#include <set>
#include <string>
#include <vector>

#include <support/made_maps.h>

namespace
{
using lamap::CBGKMap;
using lamap::CGPMap;
using lamap::CHilbertMap;
using lamap::COverlappingHilbertMap;
using namespace lamap::test;

/// A setting and others in combination with which it has no effect.
struct Idle
{
  std::string name;
  std::string text;
  Settings others;
};

const Settings kLines = {{"insertOpts.beamWidth", "none"}};

template <typename Map>
std::vector<Idle> idleSettings();

template <>
std::vector<Idle> idleSettings<CBGKMap>()
{
  const Settings line = {{"insertOpts.freeSpace", "line"}};
  const Settings none = {{"insertOpts.freeSpace", "none"}};
  return {{"creationOpts.planarHeight", "0.5", {}},     {"insertOpts.freeResolution", "0.35", line},
          {"insertOpts.freeMargin", "0.5", none},       {"insertOpts.freeWeight", "0.25", none},
          {"insertOpts.protectHits", "1", none},        {"insertOpts.freeDownsampling", "0.5", {}},
          {"insertOpts.freeDownsampling", "0.6", line}, {"insertOpts.hitDownsampling", "0.5", {}},
          {"insertOpts.echoWeight", "0.5", kLines},     {"insertOpts.noEchoWeight", "0.5", kLines}};
}

template <>
std::vector<Idle> idleSettings<CGPMap>()
{
  const Settings none = {{"insertOpts.freeSpace", "none"}};
  return {{"creationOpts.planarHeight", "0.5", {}},
          {"insertOpts.freeResolution", "0.35", none},
          {"insertOpts.freeMargin", "0.5", none},
          {"insertOpts.protectHits", "1", none},
          {"insertOpts.freeDownsampling", "0.5", {}},
          {"insertOpts.hitDownsampling", "0.5", {}},
          {"insertOpts.freeDownsampling", "0.35", none},
          {"insertOpts.echoWeight", "0.5", kLines},
          {"insertOpts.noEchoWeight", "0.5", kLines},
          {"insertOpts.varianceThreshold", "0.02", {{"creationOpts.fusion", "bayes"}}},
          {"creationOpts.maxEvidence", "5", {{"creationOpts.fusion", "bayes"}}}};
}

std::vector<Idle> idleSettingsOfHilbertMaps(const Settings& descent)
{
  return {{"creationOpts.planarHeight", "0.5", {}}, {"creationOpts.components", "20", {}},
          {"creationOpts.seed", "7", {}},           {"insertOpts.iterations", "2", descent},
          {"insertOpts.alpha", "0.01", {}},         {"insertOpts.epochs", "1", {}},
          {"insertOpts.echoWeight", "0.5", kLines}, {"insertOpts.noEchoWeight", "0.5", kLines}};
}

template <>
std::vector<Idle> idleSettings<CHilbertMap>()
{
  return idleSettingsOfHilbertMaps({{"creationOpts.training", "batch"}, {"insertOpts.solver", "sgdL2"}});
}

template <>
std::vector<Idle> idleSettings<COverlappingHilbertMap>()
{
  std::vector<Idle> all = idleSettingsOfHilbertMaps({{"insertOpts.solver", "sgdL2"}});
  const Settings components = {{"creationOpts.features", "nystroem"}};
  all.push_back({"creationOpts.cutoff", "0.1", components});
  all.push_back({"creationOpts.latticeSpacing", "0.3", components});
  return all;
}

/// The cells of a map built with settings, and the messages printed.
template <typename Map>
std::pair<Cells, std::string> cellsAndWarnings(const Settings& settings)
{
  testing::internal::CaptureStderr();
  const Cells cells = cellsOf(taught<Map>(settings));
  std::cerr.flush();
  return {cells, testing::internal::GetCapturedStderr()};
}

template <typename Map>
class IdleSettings : public ::testing::Test
{
};
using Maps = ::testing::Types<CBGKMap, CHilbertMap, COverlappingHilbertMap, CGPMap>;
TYPED_TEST_SUITE(IdleSettings, Maps);

TYPED_TEST(IdleSettings, ChangeNothingAndAreNamed)
{
  for (const Idle& idle : idleSettings<TypeParam>())
  {
    const auto [usual, silence] = cellsAndWarnings<TypeParam>(idle.others);
    EXPECT_EQ(silence.find("warning"), std::string::npos) << silence;
    Settings settings = idle.others;
    settings.emplace_back(idle.name, idle.text);
    const auto [cells, said] = cellsAndWarnings<TypeParam>(settings);
    EXPECT_TRUE(cells == usual) << idle.name << " = " << idle.text << " has an effect";
    const std::string map = TypeParam().GetRuntimeClass()->className;
    EXPECT_EQ(said.find("warning: " + map + ": " + idle.name + " = " + idle.text + " has no effect"), 0U)
        << idle.name << ": " << said;
  }
}

TYPED_TEST(IdleSettings, AreAllTriedHere)
{
  std::set<std::string> tried;
  for (const Idle& idle : idleSettings<TypeParam>()) tried.insert(idle.name);
  const typename TypeParam::TMapDefinition definition;
  const auto require = [&](const lamap::TOptionGroup& group)
  {
    for (const lamap::Option& option : group.optionTable().options())
    {
      const std::string name = group.optionTable().name() + "." + option.key;
      EXPECT_EQ(tried.count(name), option.conditions.empty() ? 0U : 1U) << name;
    }
  };
  require(definition.creationOpts);
  require(definition.insertionOpts);
}

TYPED_TEST(IdleSettings, AreNotWhatAPresetOrASavedFileSays)
{
  for (const std::string preset : {"default", "thesis"})
  {
    typename TypeParam::TMapDefinition definition;
    mrpt::config::CConfigFileMemory ini(iniOf("x", {{"creationOpts.preset", preset}}));
    definition.loadFromConfigFile(ini, "map_x_00");
    mrpt::config::CConfigFileMemory saved;
    definition.saveToConfigFile(saved, "map_x_00");
    typename TypeParam::TMapDefinition again;
    testing::internal::CaptureStderr();
    again.loadFromConfigFile(saved, "map_x_00");
    std::cerr.flush();
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  }
}

/// Builds a map twice and ends the process.
template <typename Map>
[[noreturn]] void teachTwice(const Settings& settings)
{
  for (int i = 0; i < 2; ++i) (void)taught<Map>(settings);
  std::exit(0);
}

/// Expects that a new process, which has not warned of anything yet, prints this when it builds a map twice.
template <typename Map>
void expectToldOnce(const Settings& settings, const std::string& warning)
{
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(teachTwice<Map>(settings), testing::ExitedWithCode(0), testing::Eq(warning));
}

TEST(IdleSettingsDeathTest, AreToldOnceAndWithTheReason)
{
  expectToldOnce<CBGKMap>(
      {{"insertOpts.hitDownsampling", "0.75"}},
      "warning: lamap::CBGKMap: insertOpts.hitDownsampling = 0.75 has no effect: it matters only if "
      "insertOpts.trainingPoints is centroids (it is cells)\n");
}

TEST(IdleSettingsDeathTest, PosesWithoutTheCovarianceThatIsToCountAreTold)
{
  expectToldOnce<CHilbertMap>(
      {{"insertOpts.usePoseCovariance", "true"}},
      "warning: insertOpts.usePoseCovariance = true: the pose of a scan has no covariance, or a zero one; "
      "such scans count as certain\n");
  EXPECT_EQ(cellsAndWarnings<CHilbertMap>({}).second, "");
}

}  // namespace
