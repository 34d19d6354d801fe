// Every option of every map: kept wherever a map goes, and with an effect on what it learns.
#include <gtest/gtest.h>
#include <lamap_mrpt/files/map_file.h>
#include <lamap_mrpt/maps/CBGKMap.h>
#include <lamap_mrpt/maps/CGPMap.h>
#include <lamap_mrpt/maps/CHilbertMap.h>
#include <lamap_mrpt/maps/COverlappingHilbertMap.h>
#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <support/made_maps.h>
#include <support/small_maps.h>

namespace
{
using namespace lamap::test;

/// A text with which an option shows, and what else it needs for that.
struct Change
{
  std::string key;
  std::string text;
  Settings companions{};
  std::string map{};  ///< alias of the only map that it is for; empty: of those without a change of their own
};

const Settings kPlanar{{"creationOpts.planar", "true"}};
const Settings kCentroids{{"insertOpts.trainingPoints", "centroids"}};
const Settings kNystroem{{"creationOpts.features", "nystroem"}};
const Settings kBatch{{"creationOpts.training", "batch"}};
const Settings kBatchNystroem{{"creationOpts.features", "nystroem"}, {"creationOpts.training", "batch"}};
const Settings kDescent{{"insertOpts.solver", "sgdL2"}, {"insertOpts.alpha", "0.01"}};
const Settings kSgd{
    {"creationOpts.training", "sgd"}, {"insertOpts.solver", "sgdL2"}, {"insertOpts.alpha", "0.01"}};
const Settings kCones{{"insertOpts.beamWidth", "observation"}};
const std::string kBgk = "bgkMap";
const std::string kGp = "gpMap";
const std::string kHilbert = "hilbertMap";
const std::string kOverlapping = "overlappingHilbertMap";

/// Say here how a new option shows. Not at their defaults, all of a map's together are legal.
const std::vector<Change>& changes()
{
  static const std::vector<Change> all{
      {"preset", "thesis"},
      {"preset", "la3dm", {}, kGp},
      {"resolution", "0.125"},
      {"blockDepth", "2"},
      {"pruning", "state"},
      {"planar", "true"},
      {"planarHeight", "0.5", kPlanar},
      {"priorAlpha", "1"},
      {"priorBeta", "1"},
      {"maxEvidence", "0.1"},
      {"fusion", "bayes"},
      {"signalVariance", "2"},
      {"noiseVariance", "0.3"},
      {"squashGain", "2"},
      {"minVariance", "0.001"},
      {"features", "nystroem"},
      {"features", "nystroem", kBatch, kHilbert},
      {"gamma", "20"},
      {"cutoff", "0.1"},
      {"latticeSpacing", "0.3"},
      {"components", "20", kNystroem},
      {"components", "20", kBatchNystroem, kHilbert},
      {"seed", "7", kNystroem},
      {"seed", "7", kBatchNystroem, kHilbert},
      {"priorPrecision", "1"},
      {"training", "sgd"},
      {"outOfFieldLimit", "0"},
      {"fieldLimit", "1"},
      {"keepModels", "false"},

      {"nested", "true"},
      {"freeSpace", "none"},
      {"freeSpace", "line", {}, kBgk},
      {"freeResolution", "0.5"},
      {"freeResolution", "0.7", {}, kGp},
      {"freeResolution", "0.35", kCentroids, kBgk},
      {"freeMargin", "0.4"},
      {"freeWeight", "0.25"},
      {"freeDownsampling", "0.5", kCentroids},
      {"trainingPoints", "centroids"},
      {"trainingPoints", "points", {}, kHilbert},
      {"trainingPoints", "points", {}, kOverlapping},
      {"hitDownsampling", "0.4", kCentroids},
      {"protectHits", "1", {{"insertOpts.freeMargin", "0"}, {"insertOpts.freeResolution", "0.1"}}},
      {"kernel", "wendlandC2"},
      {"kernelSupport", "0.3"},
      {"kernelScale", "2"},
      {"lengthScale", "0.2"},
      {"maxPoints", "3"},
      {"hitWeight", "4"},
      {"minRange", "1"},
      {"maxRange", "1.5"},
      {"considerInvalidRangesAsFreeSpace", "false"},
      {"rayDecimation", "3"},
      {"solver", "sgdL1", kSgd, kHilbert},
      {"solver", "sgdL1", kDescent},
      {"iterations", "2"},
      {"alpha", "0.1", kSgd, kHilbert},
      {"alpha", "0.1", kDescent},
      {"epochs", "1", kSgd, kHilbert},
      {"epochs", "1", kDescent},
      {"beamWidth", "spacing"},
      // The beams of a small scan are near each other: only a narrow kernel tells their widths apart.
      {"beamWidth", "none", {{"insertOpts.kernelSupport", "0.1"}}, kBgk},
      {"echoWeight", "0.5", kCones},
      {"noEchoWeight", "0.5", kCones},
      {"usePoseCovariance", "true"},
      {"rangeStd", "0.2"},
      {"pointStd", "0.2"},
      {"scansPerModel", "2"},
      {"boxQuantile", "0.2"},
      {"fieldNear", "1.5"},
      {"fieldDepth", "0"},
      {"fieldAngle", "30"},
      {"fieldWeight", "0.3"},
      {"freeThreshold", "0.01"},
      {"occupiedThreshold", "0.99"},
      {"varianceThreshold", "0.001"},

      {"decimation", "3"},
      {"outlierProb", "0.25"},
      {"endPointStd", "0.125"},
      {"freeBefore", "0.4"},
      {"unobservedProb", "0.5"},
      {"independence", "0.75"},
      {"generateOccupiedVoxels", "false"},
      {"visibleOccupiedVoxels", "false"},
      {"generateFreeVoxels", "true"},
      {"visibleFreeVoxels", "false"},
      {"generateGridLines", "true"},
      {"hideBuriedVoxels", "false"},
      {"colourBy", "probability"},
      {"freeOpacity", "0.25"}};
  return all;
}

const Change& changeOf(const std::string& key, const std::string& map)
{
  const Change* ofAll = nullptr;
  for (const Change& change : changes())
  {
    if (change.key != key) continue;
    if (change.map == map) return change;
    if (change.map.empty()) ofAll = &change;
  }
  if (ofAll == nullptr) throw std::logic_error("say in changes() how the new option " + key + " shows");
  return *ofAll;
}

class EveryOptionOfAMap : public testing::Test
{
 protected:
  /// @param creation of the map that is to have a prior map, if it is a BGK map
  [[nodiscard]] Change changeFor(const std::string& key, const std::string& map,
                                 const lamap::CBGKMap::TCreationOptions& creation) const
  {
    if (key != "priorMap") return changeOf(key, map);
    lamap::CBGKMap prior(creation);
    prior.updateVoxel(5, 5, 0.5, true);
    const std::string path = folder_.file("prior.lamap.gz");
    lamap::saveMapFile(prior, path);
    return {key, path};
  }

 private:
  TemporaryFolder folder_;
};

template <typename Map>
class EveryOption : public EveryOptionOfAMap
{
};
using Maps = testing::Types<lamap::CBGKMap, lamap::CGPMap, lamap::CHilbertMap, lamap::COverlappingHilbertMap>;
TYPED_TEST_SUITE(EveryOption, Maps);

TYPED_TEST(EveryOption, IsReadStoredCopiedAndWritten)
{
  const TypeParam untouched;
  const std::string alias = untouched.alias();
  lamap::CBGKMap::TCreationOptions planar;
  planar.resolution = 0.125;
  planar.planar = true;
  planar.planarHeight = 0.5;
  Settings settings;
  for (const auto& usual : untouched.optionValues())
    settings.emplace_back(usual.section + "." + usual.key, this->changeFor(usual.key, alias, planar).text);
  const TypeParam map = made<TypeParam>(settings);
  const auto due = map.optionValues();
  const auto usual = untouched.optionValues();
  for (size_t i = 0; i < due.size(); ++i)
    EXPECT_NE(due[i].text, usual[i].text) << due[i].section << "." << due[i].key << " is at its default";
  const auto expectSame = [&](const lamap::CLearnedMap& other)
  {
    const auto values = other.optionValues();
    ASSERT_EQ(values.size(), due.size());
    for (size_t i = 0; i < due.size(); ++i) EXPECT_EQ(values[i].text, due[i].text) << due[i].key;
  };
  expectSame(TypeParam(map));
  expectSame(*std::dynamic_pointer_cast<TypeParam>(objectFrom(bytesOf(map))));

  const std::string prefix = "map_" + alias + "_00";
  typename TypeParam::TMapDefinition definition;
  definition.loadFromConfigFile(mrpt::config::CConfigFileMemory(iniOf(alias, settings)), prefix);
  mrpt::config::CConfigFileMemory written;
  definition.saveToConfigFile(written, prefix);
  typename TypeParam::TMapDefinition again;
  again.loadFromConfigFile(mrpt::config::CConfigFileMemory(written.getContent()), prefix);
  const std::unique_ptr<TypeParam> remade(TypeParam::CreateFromMapDefinition(again));
  expectSame(*remade);
}

template <typename Map>
Map taughtAtAnUncertainPose(const Settings& settings)
{
  mrpt::poses::CPose3DPDFGaussian uncertain(kSecondPose);
  uncertain.cov(0, 0) = uncertain.cov(1, 1) = uncertain.cov(3, 3) = 0.04;
  Map map = made<Map>(settings);
  map.insertObservationAt(roomScan(61), uncertain);
  map.insertScan(smallScan());
  map.insertScan(coneScan());
  return map;
}

/// The settings with one more, in the place of one of the same name.
Settings with(Settings settings, const std::string& name, const std::string& text)
{
  for (auto& setting : settings)
    if (setting.first == name) return setting.second = text, settings;
  settings.emplace_back(name, text);
  return settings;
}

TYPED_TEST(EveryOption, TakesEffect)
{
  const TypeParam untouched;
  for (const auto& option : untouched.optionValues())
  {
    const bool isOfLearning = option.section == "creationOpts" || option.section == "insertOpts";
    if (!isOfLearning || option.key == "preset") continue;  // their own tests
    const Change change = this->changeFor(option.key, untouched.alias(), {});
    SCOPED_TRACE(option.key + " = " + change.text);
    const auto usual = taughtAtAnUncertainPose<TypeParam>(change.companions);
    const auto changed = taughtAtAnUncertainPose<TypeParam>(
        with(change.companions, option.section + "." + option.key, change.text));
    // How cells are held shows in what they take, not in what they say; two ways of fusion, in other
    // evidence.
    const bool showsInFacts = option.key == "blockDepth" || option.key == "pruning" ||
                              option.key == "keepModels" || option.key == "fusion";
    if (showsInFacts)
      EXPECT_NE(factsOf(changed), factsOf(usual));
    else
      EXPECT_FALSE(cellsOf(changed) == cellsOf(usual)) << "changes nothing";
  }
}

}  // namespace
