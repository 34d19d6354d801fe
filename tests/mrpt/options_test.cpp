#include <gtest/gtest.h>
#include <lamap_core/options/nearest_name.h>
#include <lamap_mrpt/files/map_file.h>
#include <lamap_mrpt/maps/CBGKMap.h>
#include <lamap_mrpt/options/option_group.h>
#include <mrpt/config/CConfigFile.h>
#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/config/CConfigFilePrefixer.h>
#include <mrpt/maps/CMultiMetricMap.h>

#include <fstream>
#include <sstream>

#include <support/small_maps.h>

namespace
{
using lamap::CBGKMap;
using lamap::Option;
using lamap::TOptionGroup;
using namespace lamap::test;
using mrpt::config::CConfigFileMemory;

/// What loading a text says it does not like; "" if it likes it.
std::string complaintOf(TOptionGroup& group, const std::string& text,
                        const std::string& section = "x_insertOpts")
{
  try
  {
    group.loadFromConfigFile(CConfigFileMemory(text), section);
  }
  catch (const std::invalid_argument& error)
  {
    return error.what();
  }
  return "";
}

#define EXPECT_SAYS(text, ...)                                          \
  for (const std::string& part : std::vector<std::string>{__VA_ARGS__}) \
  EXPECT_NE((text).find(part), std::string::npos) << "'" << part << "' is missing in: " << (text)

template <typename Group>
class OptionGroupTest : public ::testing::Test
{
};
using Groups = ::testing::Types<CBGKMap::TCreationOptions, CBGKMap::TInsertionOptions,
                                CBGKMap::TLikelihoodOptions, CBGKMap::TRenderingOptions>;
TYPED_TEST_SUITE(OptionGroupTest, Groups);

TYPED_TEST(OptionGroupTest, EveryOptionSurvivesAnIniFile)
{
  TypeParam changed;
  setAllToOthers(changed);
  CConfigFileMemory ini;
  changed.saveToConfigFile(ini, "any");
  TypeParam loaded;
  EXPECT_FALSE(loaded.sameOptions(changed));
  loaded.loadFromConfigFile(ini, "any");
  for (const Option& option : changed.optionTable().options())
    EXPECT_EQ(option.textOf(loaded), option.textOf(changed)) << option.key;
  EXPECT_TRUE(loaded.sameOptions(changed));
}

TYPED_TEST(OptionGroupTest, EveryOptionSurvivesAsBytes)
{
  TypeParam changed;
  setAllToOthers(changed);
  lamap::ByteWriter bytes;
  changed.write(bytes);
  lamap::ByteReader reader(bytes.bytes());
  TypeParam read;
  read.read(reader);
  EXPECT_TRUE(read.sameOptions(changed));
}

TYPED_TEST(OptionGroupTest, SameOptionsSeesEachOne)
{
  const TypeParam untouched;
  int number = 0;
  for (const Option& option : untouched.optionTable().options())
  {
    TypeParam changed;
    setToAnother(option, changed, number++);
    EXPECT_FALSE(changed.sameOptions(untouched)) << option.key;
  }
}

TYPED_TEST(OptionGroupTest, PrintsEveryOption)
{
  TypeParam changed;
  setAllToOthers(changed);
  std::ostringstream out;
  changed.dumpToTextStream(out);
  for (const Option& option : changed.optionTable().options())
  {
    EXPECT_SAYS(out.str(), option.key, "= " + option.textOf(changed));
    EXPECT_FALSE(option.doc.empty()) << option.key;
  }
}

TYPED_TEST(OptionGroupTest, RefusesNonsenseForEveryOptionAndKeepsWhatItHad)
{
  TypeParam group;
  setAllToOthers(group);
  TypeParam before = group;
  for (const Option& option : group.optionTable().options())
  {
    if (option.type == lamap::OptionType::Text) continue;
    for (const std::string nonsense :
         {"30m", "abc", "nan", "inf", "-inf", "1e999", "-1e14", "", "0x10", "1 2"})
    {
      const std::string complaint = complaintOf(group, "[x]\n" + option.key + " = " + nonsense + "\n", "x");
      EXPECT_SAYS(complaint, group.optionTable().name() + "." + option.key, '"' + nonsense + '"', "\"x\"",
                  "legal is");
      EXPECT_TRUE(group.sameOptions(before)) << option.key << " = " << nonsense;
    }
  }
}

TEST(Options, LengthsMayBeLeftEmpty)
{
  CBGKMap::TInsertionOptions options;
  ASSERT_FALSE(options.kernelSupport);
  lamap::ByteWriter bytes;
  options.write(bytes);
  lamap::ByteReader reader(bytes.bytes());
  CBGKMap::TInsertionOptions read;
  read.kernelSupport = 3.0;
  read.read(reader);
  EXPECT_FALSE(read.kernelSupport);
  std::ostringstream out;
  options.dumpToTextStream(out);
  EXPECT_SAYS(out.str(), "kernelSupport", "2 cells");
}

TEST(Options, AMistypedKeyNamesTheNearestAndTheSection)
{
  CBGKMap::TInsertionOptions options;
  const std::string complaint = complaintOf(options, "[x_insertOpts]\nmaxRagne = 30\n");
  EXPECT_SAYS(complaint, "\"maxRagne\"", "\"x_insertOpts\"", "\"maxRange\"");
}

TEST(Options, AnErrorNamesTheFile)
{
  const TemporaryFolder folder;
  std::ofstream(folder.file("my.ini")) << "[x_insertOpts]\nmaxRange = 30m\n";
  CBGKMap::TInsertionOptions options;
  try
  {
    options.loadFromConfigFile(mrpt::config::CConfigFile(folder.file("my.ini")), "x_insertOpts");
    FAIL() << "30m was taken";
  }
  catch (const std::invalid_argument& error)
  {
    EXPECT_SAYS(std::string(error.what()), folder.file("my.ini"), "insertOpts.maxRange", "\"30m\"",
                "a number", "in m", "without the unit");
  }
}

TEST(Options, TakesCommentsSignsAndAnyCase)
{
  CBGKMap::TInsertionOptions options;
  EXPECT_EQ(
      complaintOf(
          options,
          "[x_insertOpts]\n# a line\nMAXRANGE = +3e1 // metres\nminrange=0.5 # here\nfreeSpace = LINE ; "
          "so\nprotectHits= 3\nconsiderInvalidRangesAsFreeSpace = No\n"),
      "");
  EXPECT_EQ(options.maxRange, 30.0);
  EXPECT_EQ(options.minRange, 0.5);
  EXPECT_EQ(options.freeSpace, lamap::FreeSpace::Line);
  EXPECT_EQ(options.protectHits, 3u);
  EXPECT_FALSE(options.considerInvalidRangesAsFreeSpace);
}

TEST(Options, NumbersOutOfRangeAndFractionsOfWholeNumbersAreRefused)
{
  CBGKMap::TInsertionOptions options;
  EXPECT_SAYS(complaintOf(options, "[x_insertOpts]\nfreeThreshold = 1.5\n"), "insertOpts.freeThreshold",
              "from 0 to 1");
  EXPECT_SAYS(complaintOf(options, "[x_insertOpts]\nprotectHits = 2.5\n"), "insertOpts.protectHits",
              "whole number");
  EXPECT_SAYS(complaintOf(options, "[x_insertOpts]\nprotectHits = -1\n"), "insertOpts.protectHits",
              "whole number");
  EXPECT_SAYS(complaintOf(options, "[x_insertOpts]\nkernelScale = 0\n"), "insertOpts.kernelScale", "> 0");
  EXPECT_SAYS(complaintOf(options, "[x_insertOpts]\nfreeSpace = lines\n"), "insertOpts.freeSpace",
              "samples, line, none", "did you mean line?");
}

TEST(Options, OptionsThatContradictEachOtherAreRefused)
{
  CBGKMap::TInsertionOptions options;
  EXPECT_SAYS(complaintOf(options, "[x_insertOpts]\nfreeThreshold = 0.8\n"), "occupiedThreshold",
              "\"x_insertOpts\"");
  EXPECT_EQ(options.thresholds.free, 0.3);
  EXPECT_SAYS(complaintOf(options, "[x_insertOpts]\nminRange = 5\nmaxRange = 4\n"), "maxRange");
}

TEST(Options, MrptsOwnKeysStandInCreationOpts)
{
  CBGKMap::TCreationOptions options;
  EXPECT_EQ(complaintOf(options, "[c]\nenableSaveAs3DObject = false\nresolution = 0.2\n", "c"), "");
  EXPECT_EQ(options.resolution, 0.2);
  EXPECT_SAYS(complaintOf(options, "[c]\nenableSaveAs3DObject = flase\n", "c"), "enableSaveAs3DObject",
              "true or false");
  EXPECT_SAYS(complaintOf(options, "[c]\nenableObservationInsertions = true\n", "c"),
              "enableObservationInsertion\"");
}

TEST(NearestName, CountsSwapsAsOneAndIgnoresCase)
{
  EXPECT_EQ(lamap::editDistance("bgkMap", "bkgMap"), 1U);
  EXPECT_EQ(lamap::editDistance("kitten", "sitting"), 3U);
  EXPECT_EQ(lamap::editDistance("ABC", "abc"), 0U);
  EXPECT_EQ(lamap::editDistance("", "abc"), 3U);
  EXPECT_TRUE(lamap::looksLikeMistyped("bkgMap", "bgkMap"));
  EXPECT_FALSE(lamap::looksLikeMistyped("bgkMap", "bgkMap"));
  EXPECT_FALSE(lamap::looksLikeMistyped("beaconMap", "bgkMap"));
}

TEST(Options, NearestCountsSwapsAndIgnoresCase)
{
  EXPECT_EQ(lamap::nearestOf("resolutoin", {"planar", "resolution", "pruning"}), "resolution");
  EXPECT_EQ(lamap::nearestOf("PLANAR", {"resolution", "planar"}), "planar");
  EXPECT_EQ(lamap::nearestOf("x", {}), "");
}

TEST(Options, OnlyWhatMayWellBeMeantIsSuggested)
{
  EXPECT_EQ(lamap::suggestionFor("resolutoin", {"planar", "resolution"}), "did you mean resolution?");
  EXPECT_EQ(lamap::suggestionFor("RESOLUTION", {"planar", "resolution"}), "did you mean resolution?");
  EXPECT_EQ(lamap::suggestionFor("unstr", {"structured", "unstructured"}, "'", "'"),
            "did you mean 'unstructured'?");
  EXPECT_EQ(lamap::suggestionFor("planar", {"resolution", "pruning"}), "there are: resolution, pruning");
  EXPECT_EQ(lamap::suggestionFor("", {"a", "b"}, "[", "]"), "there are: [a], [b]");
  EXPECT_EQ(lamap::suggestionFor("re", {"resolution"}), "there are: resolution");
  EXPECT_EQ(lamap::suggestionFor("x", {}), "there are none");
}

// ---- The map's definition

mrpt::maps::CMultiMetricMap mapsFrom(const std::string& text)
{
  mrpt::maps::TSetOfMetricMapInitializers definitions;
  definitions.loadFromConfigFile(CConfigFileMemory(text), "map");
  mrpt::maps::CMultiMetricMap maps;
  maps.setListOfMaps(definitions);
  return maps;
}

CBGKMap bgkFrom(const std::string& text, const std::string& count = "bgkMap_count")
{
  const auto maps = mapsFrom("[map]\n" + count + " = 1\n" + text);
  return dynamic_cast<const CBGKMap&>(*maps.maps.at(0));
}

std::string complaintOfDefinition(const std::string& text)
{
  try
  {
    bgkFrom(text);
  }
  catch (const std::exception& error)
  {
    return error.what();
  }
  return "";
}

TEST(Definition, AliasAndClassNameMakeTheMap)
{
  EXPECT_EQ(bgkFrom("[map_bgkMap_00_creationOpts]\nresolution=0.25\n").resolution(), 0.25);
  EXPECT_EQ(
      bgkFrom("[map_lamap::CBGKMap_00_creationOpts]\nresolution=0.25\n", "lamap::CBGKMap_count").resolution(),
      0.25);
}

TEST(Definition, LengthsFollowTheResolution)
{
  const CBGKMap map =
      bgkFrom("[map_bgkMap_00_creationOpts]\nresolution=0.25\n[map_bgkMap_00_insertOpts]\nfreeMargin=0.4\n");
  EXPECT_EQ(map.insertionOptions.kernelSupport, 0.5);
  EXPECT_EQ(map.insertionOptions.freeResolution, 0.25);
  EXPECT_EQ(map.insertionOptions.freeMargin, 0.4);
}

TEST(Definition, APresetComesFirstWhereverItStands)
{
  for (const std::string text :
       {"preset = thesis\npriorAlpha = 0.5\n", "priorAlpha = 0.5\npreset = thesis\n"})
  {
    const CBGKMap map =
        bgkFrom("[map_bgkMap_00_insertOpts]\nkernelScale = 3\n[map_bgkMap_00_creationOpts]\n" + text);
    const lamap::BgkOptions thesis = lamap::presetOptions(lamap::BgkPreset::Thesis);
    EXPECT_EQ(map.creationOptions().priorAlpha, 0.5);
    EXPECT_EQ(map.creationOptions().priorBeta, thesis.structure.priorBeta);
    EXPECT_EQ(map.creationOptions().pruning, thesis.structure.pruning);
    EXPECT_EQ(map.insertionOptions.kernelScale, 3);
    lamap::BgkInference expected = thesis.inference.resolved(map.resolution());
    expected.kernelScale = 3;
    EXPECT_TRUE(static_cast<const lamap::BgkInference&>(map.insertionOptions) == expected);
  }
}

// As map-partition reads: MRPT's prefixer lists the keys of the section without the prefix.
TEST(Definition, IsReadThroughAPrefixer)
{
  CConfigFileMemory ini(
      std::string("[PARAMS.metricmap]\nbgkMap_count = 1\n"
                  "[PARAMS.metricmap_bgkMap_00_creationOpts]\npreset = thesis\nresolution = 0.25\n"
                  "[PARAMS.metricmap_bgkMap_00_insertOpts]\nkernelScale = 3\n"));
  mrpt::maps::TSetOfMetricMapInitializers definitions;
  definitions.loadFromConfigFile(mrpt::config::CConfigFilePrefixer(ini, "PARAMS.", ""), "metricmap");
  mrpt::maps::CMultiMetricMap maps;
  maps.setListOfMaps(definitions);
  const auto& map = dynamic_cast<const CBGKMap&>(*maps.maps.at(0));
  EXPECT_EQ(map.resolution(), 0.25);
  EXPECT_EQ(map.insertionOptions.kernelScale, 3);
  EXPECT_EQ(map.creationOptions().pruning, lamap::presetOptions(lamap::BgkPreset::Thesis).structure.pruning);
}

TEST(Definition, EveryPresetMakesAMap)
{
  for (const std::string name : {"default", "thesis", "la3dm"})
    EXPECT_TRUE(bgkFrom("[map_bgkMap_00_creationOpts]\npreset = " + name + "\n").insertScan(smallScan()))
        << name;
}

TEST(Definition, SavedOptionsAreResolvedAndMakeTheSameMap)
{
  CBGKMap::TMapDefinition definition;
  setAllToOthers(definition.creationOpts);
  definition.creationOpts.priorMap.clear();
  setAllToOthers(definition.likelihoodOpts);
  setAllToOthers(definition.renderingOpts);
  definition.insertionOpts.kernelScale = 2;
  definition.genericMapParams.enableSaveAs3DObject = false;
  CConfigFileMemory ini;
  definition.saveToConfigFile(ini, "map_bgkMap_00");
  EXPECT_EQ(ini.read_string_first_word("map_bgkMap_00_insertOpts", "kernelSupport", "absent"),
            "0.25");  // two cells of 0.125 m
  ini.write("map", "bgkMap_count", 1);

  const CBGKMap map = bgkFrom(ini.getContent());
  const std::unique_ptr<CBGKMap> direct(CBGKMap::CreateFromMapDefinition(definition));
  EXPECT_EQ(bytesOf(map), bytesOf(*direct));
  EXPECT_FALSE(map.genericMapParams.enableSaveAs3DObject);
  EXPECT_TRUE(map.creationOptions().sameOptions(definition.creationOpts));
}

TEST(Definition, WhatIsSavedIsLoadedFromTheSameMemory)
{
  CBGKMap::TMapDefinition saved;
  saved.genericMapParams.enableObservationInsertion = false;
  saved.insertionOpts.maxRange = 12.5;
  CConfigFileMemory ini;
  saved.saveToConfigFile(ini, "map_bgkMap_00");
  CBGKMap::TMapDefinition loaded;
  loaded.loadFromConfigFile(ini, "map_bgkMap_00");
  EXPECT_FALSE(loaded.genericMapParams.enableObservationInsertion);
  EXPECT_EQ(loaded.insertionOpts.maxRange, 12.5);
}

// MRPT pads the keys that it writes, and a configuration in memory keeps the spaces.
TEST(Options, KeysThatAreWrittenWithSpacesAreRead)
{
  CConfigFileMemory ini;
  ini.write("x", "maxRange", 12.5, 30, 20, "padded");
  mrpt::maps::TMapGenericParams().saveToConfigFile(ini, "c");
  CBGKMap::TInsertionOptions insertion;
  insertion.loadFromConfigFile(ini, "x");
  EXPECT_EQ(insertion.maxRange, 12.5);
  CBGKMap::TCreationOptions creation;
  EXPECT_NO_THROW(creation.loadFromConfigFile(ini, "c"));
}

TEST(Definition, MistypedSectionsAndKeysAreNamed)
{
  EXPECT_SAYS(complaintOfDefinition("[map_bgkMap_00_insertOpt]\nmaxRange=3\n"), "\"map_bgkMap_00_insertOpt\"",
              "\"map_bgkMap_00_insertOpts\"");
  EXPECT_SAYS(complaintOfDefinition("[map_bgkMap_00_creationOpts]\nresolutoin=3\n"), "resolutoin",
              "resolution");
  EXPECT_SAYS(complaintOfDefinition("[map_bgkMap_00_insertOpts]\nResolution=0.2\n"),
              "\"resolution\" in section \"map_bgkMap_00_insertOpts\"",
              "belongs to section \"map_bgkMap_00_creationOpts\"");
  EXPECT_SAYS(complaintOfDefinition("[map_bgkMap_00_creationOpts]\npreset=tesis\n"), "creationOpts.preset",
              "thesis");
  for (const std::string resolution : {"0", "-0.1", "nan", "0.1m"})
    EXPECT_SAYS(complaintOfDefinition("[map_bgkMap_00_creationOpts]\nresolution=" + resolution + "\n"),
                "creationOpts.resolution", '"' + resolution + '"');
  EXPECT_SAYS(complaintOfDefinition("[map_bgkMap_00_insertOpts]\nkernelSupport=100\n"), "kernelSupport",
              "\"map_bgkMap_00_insertOpts\"");
  EXPECT_SAYS(complaintOfDefinition("[map_bgkMap_00_creationOpts]\npriorMap=/no/such/file.lamap.gz\n"),
              "/no/such/file.lamap.gz");
}

TEST(Definition, PrintsAllGroups)
{
  std::ostringstream out;
  CBGKMap::TMapDefinition().dumpToTextStream(out);
  EXPECT_SAYS(out.str(), "resolution", "kernelSupport", "outlierProb", "colourBy");
}

// ---- Options as the map has them

/// A map whose every option differs from the default, with a prior map and some evidence.
CBGKMap changedMap(const TemporaryFolder& folder)
{
  CBGKMap::TCreationOptions creation;
  setAllToOthers(creation);
  creation.priorMap.clear();
  CBGKMap prior(creation);
  prior.insertScan(smallScan());
  creation.priorMap = folder.file("prior.lamap.gz");
  lamap::saveMapFile(prior, creation.priorMap);
  CBGKMap map(creation);
  setAllToOthers(map.insertionOptions);
  setAllToOthers(map.likelihoodOptions);
  setAllToOthers(map.renderingOptions);
  map.genericMapParams.enableSaveAs3DObject = false;
  map.genericMapParams.enableObservationLikelihood = false;
  map.genericMapParams.enableObservationInsertion = false;
  map.insertScan(smallScan());
  return map;
}

void expectSameOptions(const CBGKMap& map, const CBGKMap& expected)
{
  const auto values = map.optionValues();
  const auto due = expected.optionValues();
  const auto usual = CBGKMap().optionValues();
  ASSERT_EQ(values.size(), due.size());
  for (size_t i = 0; i < due.size(); ++i)
  {
    EXPECT_EQ(values[i].text, due[i].text) << due[i].section << "." << due[i].key;
    EXPECT_NE(values[i].text, usual[i].text) << due[i].section << "." << due[i].key;
  }
  EXPECT_EQ(map.genericMapParams.enableSaveAs3DObject, expected.genericMapParams.enableSaveAs3DObject);
  EXPECT_EQ(map.genericMapParams.enableObservationLikelihood,
            expected.genericMapParams.enableObservationLikelihood);
  EXPECT_EQ(map.genericMapParams.enableObservationInsertion,
            expected.genericMapParams.enableObservationInsertion);
}

TEST(MapOptions, EveryOneSurvivesACopy)
{
  const TemporaryFolder folder;
  const CBGKMap map = changedMap(folder);
  const CBGKMap copy(map);
  expectSameOptions(copy, map);
  CBGKMap assigned;
  assigned = map;
  expectSameOptions(assigned, map);
  EXPECT_EQ(bytesOf(copy), bytesOf(map));
  EXPECT_EQ(bytesOf(assigned), bytesOf(map));
}

TEST(MapOptions, EveryOneSurvivesAParticleCopy)
{
  const TemporaryFolder folder;
  mrpt::maps::CMultiMetricMap particle;
  particle.maps.push_back(std::make_shared<CBGKMap>(changedMap(folder)));
  const mrpt::maps::CMultiMetricMap copy(particle);
  const auto& copied = dynamic_cast<const CBGKMap&>(*copy.maps.at(0));
  EXPECT_NE(copy.maps.at(0).get(), particle.maps.at(0).get());
  expectSameOptions(copied, dynamic_cast<const CBGKMap&>(*particle.maps.at(0)));
}

TEST(MapOptions, EveryOneSurvivesAFileEvenWithoutThePriorMapsFile)
{
  const TemporaryFolder folder;
  const CBGKMap map = changedMap(folder);
  lamap::saveMapFile(map, folder.file("map.lamap.gz"));
  std::filesystem::remove(folder.file("prior.lamap.gz"));
  const auto loaded = std::dynamic_pointer_cast<CBGKMap>(lamap::loadMapFile(folder.file("map.lamap.gz")));
  ASSERT_TRUE(loaded);
  expectSameOptions(*loaded, map);
  EXPECT_EQ(bytesOf(*loaded), bytesOf(map));
  ASSERT_TRUE(loaded->core().priorMap());
}

TEST(MapOptions, AreListedWithContentAndUnit)
{
  const CBGKMap map(0.2);
  bool found = false;
  for (const auto& value : map.optionValues())
  {
    if (value.section != "insertOpts" || value.key != "kernelSupport") continue;
    found = true;
    EXPECT_EQ(std::get<double>(value.content), 0.4);
    EXPECT_EQ(value.text, "0.4");
    EXPECT_EQ(value.unit, "m");
  }
  EXPECT_TRUE(found);
}

TEST(MapOptions, AreComparedByMeaning)
{
  CBGKMap map;
  map.insertionOptions.maxRange = 30;
  EXPECT_TRUE(map.optionIs("insertOpts", "maxRange", "3e1"));
  EXPECT_TRUE(map.optionIs("insertOpts", "maxrange", "30.0"));
  EXPECT_FALSE(map.optionIs("insertOpts", "maxRange", "31"));
  EXPECT_THROW((void)map.optionIs("insertOpts", "maxRagne", "31"), std::invalid_argument);
  EXPECT_THROW((void)map.optionIs("insertOpt", "maxRange", "31"), std::invalid_argument);
  EXPECT_THROW((void)map.optionIs("insertOpts", "maxRange", "far"), std::invalid_argument);
}

}  // namespace
