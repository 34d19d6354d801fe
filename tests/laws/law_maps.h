#pragma once

#include <lamap_mrpt/maps/CBGKMap.h>
#include <lamap_mrpt/maps/CGPMap.h>
#include <lamap_mrpt/maps/CHilbertMap.h>
#include <lamap_mrpt/maps/COverlappingHilbertMap.h>
#include <support/made_maps.h>

#include "law_scans.h"

// The four maps as the laws see them: through what they share as MRPT maps, and a few traits where they
// differ.
namespace lamap::test
{
/// Values to choose from, by the option's name; "" leaves the option at its default.
using Choices = std::vector<std::pair<std::string, std::vector<std::string>>>;

/// What no law depends on, and any map has.
inline Choices sharedChoices()
{
  return {{"creationOpts.planar", {"", "", "true"}},
          {"insertOpts.minRange", {"", "0.15"}},
          {"insertOpts.maxRange", {"", "0.7", "1.5"}},
          {"insertOpts.considerInvalidRangesAsFreeSpace", {"", "false"}},
          {"insertOpts.rayDecimation", {"", "", "2"}}};
}

/// What changes files and threads, but not every law holds with: `state` forgets, and scans may wait for
/// others.
inline Choices choicesForFiles(bool prunes)
{
  Choices choices = {{"creationOpts.preset", {"", "", "thesis"}}};
  if (prunes) choices.push_back({"creationOpts.pruning", {"", "none", "state"}});
  return choices;
}

template <typename Map>
struct Law;

template <>
struct Law<CBGKMap>
{
  /// Evidence adds up: orders and batches do not matter, and maps can be merged.
  static constexpr bool kAdds = true;
  /// The same scans in another order give the same file, not only the same cells.
  static constexpr bool kForgetsTheOrder = true;
  static constexpr bool kPrunes = true;
  /// Moves by multiples of this move the map exactly.
  static constexpr int kMove_cells = 1;
  /// Nothing is said farther than this from all rays.
  static constexpr double kReach_m = 0.4;

  static Choices choices()
  {
    return {{"creationOpts.blockDepth", {"", "2", "3", "5", "6"}},
            {"insertOpts.trainingPoints", {"", "centroids"}},
            {"insertOpts.hitDownsampling", {"", "0", "0.25"}},
            {"insertOpts.freeDownsampling", {"", "0.25"}},
            {"insertOpts.freeSpace", {"", "line", "none"}},
            {"insertOpts.freeResolution", {"", "0.07", "0.2"}},
            {"insertOpts.freeMargin", {"", "0", "0.23"}},
            {"insertOpts.freeWeight", {"", "1.7"}},
            {"insertOpts.protectHits", {"", "0", "3"}},
            {"insertOpts.kernel", {"", "sparseMatern32", "wendlandC2"}},
            {"insertOpts.kernelSupport", {"", "0.06", "0.33"}},
            {"insertOpts.kernelScale", {"", "4"}}};
  }
};

template <>
struct Law<CGPMap>
{
  static constexpr bool kAdds = true;
  static constexpr bool kForgetsTheOrder = true;
  static constexpr bool kPrunes = true;
  static constexpr int kMove_cells = 8;  // points are divided by blocks; here these are 8 cells wide at most
  static constexpr double kReach_m = 0.5;

  static Choices choices()
  {
    return {{"creationOpts.blockDepth", {"", "2", "4"}},      {"creationOpts.fusion", {"", "bayes"}},
            {"creationOpts.signalVariance", {"", "2"}},       {"creationOpts.noiseVariance", {"", "0.5"}},
            {"creationOpts.squashGain", {"", "10"}},          {"insertOpts.nested", {"", "true"}},
            {"insertOpts.trainingPoints", {"", "centroids"}}, {"insertOpts.hitDownsampling", {"", "0.25"}},
            {"insertOpts.freeSpace", {"", "", "none"}},       {"insertOpts.freeResolution", {"", "0.35"}},
            {"insertOpts.freeMargin", {"", "0.23"}},          {"insertOpts.kernelSupport", {"", "0.33"}},
            {"insertOpts.lengthScale", {"", "0.2"}},          {"insertOpts.maxPoints", {"", "60"}}};
  }
};

/// What both kinds of Hilbert maps have.
inline Choices hilbertChoices()
{
  return {{"creationOpts.components", {"30"}},
          {"insertOpts.trainingPoints", {"", "points"}},
          {"insertOpts.freeResolution", {"", "0.2"}},
          {"insertOpts.hitWeight", {"", "3"}},
          {"insertOpts.epochs", {"2"}},
          {"insertOpts.rangeStd", {"", "", "0.05"}}};
}

template <>
struct Law<COverlappingHilbertMap>
{
  static constexpr bool kAdds = true;
  static constexpr bool kForgetsTheOrder = false;  // it keeps its models in the order of their scans
  static constexpr bool kPrunes = true;
  static constexpr int kMove_cells = 8;
  static constexpr double kReach_m = 1.0;

  static Choices choices()
  {
    Choices choices = hilbertChoices();
    for (const auto& choice : Choices{{"creationOpts.blockDepth", {"", "2", "3"}},
                                      {"creationOpts.features", {"", "", "nystroem"}},
                                      {"creationOpts.outOfFieldLimit", {"", "0"}},
                                      {"creationOpts.keepModels", {"", "", "false"}},
                                      {"insertOpts.iterations", {"8"}},
                                      {"insertOpts.solver", {"", "", "sgdL1"}},
                                      {"insertOpts.boxQuantile", {"", "0.02"}},
                                      {"insertOpts.fieldNear", {"", "0.5"}},
                                      {"insertOpts.fieldWeight", {"", "0.9"}}})
      choices.push_back(choice);
    return choices;
  }
};

template <>
struct Law<CHilbertMap>
{
  static constexpr bool kAdds = false;  // a scan's posterior is the next one's prior
  static constexpr bool kForgetsTheOrder = false;
  static constexpr bool kPrunes = false;  // cells are a view of the model
  static constexpr int kMove_cells = 2;   // whole sites of the lattice
  static constexpr double kReach_m = 1.0;

  static Choices choices()
  {
    Choices choices = hilbertChoices();
    choices.push_back({"creationOpts.training", {"", "", "batch", "sgd"}});
    choices.push_back({"creationOpts.features", {"", "", "nystroem"}});
    return choices;
  }
};

/// Sets an option, or removes what it was set to if the text is empty.
inline void set(Settings& settings, const std::string& name, const std::string& text)
{
  settings.erase(std::remove_if(settings.begin(), settings.end(),
                                [&](const auto& setting) { return setting.first == name; }),
                 settings.end());
  if (!text.empty()) settings.emplace_back(name, text);
}
inline Settings with(Settings settings, const std::string& name, const std::string& text)
{
  set(settings, name, text);
  return settings;
}

inline std::string textOf(const Settings& settings, const std::string& name)
{
  for (const auto& [key, text] : settings)
    if (key == name) return text;
  return "";
}

/// Random legal options.
template <typename Map>
Settings randomSettings(Random& random)
{
  Settings settings;
  for (const Choices& choices : {sharedChoices(), Law<Map>::choices()})
    for (const auto& [name, texts] : choices) set(settings, name, random.pick(texts));
  // Incremental training has no components to train.
  const bool isIncremental =
      std::is_same_v<Map, CHilbertMap> && textOf(settings, "creationOpts.training").empty();
  if (isIncremental) set(settings, "creationOpts.features", "");
  return settings;
}

/// The same, of every kind that files hold differently.
template <typename Map>
Settings randomSettingsForFiles(Random& random)
{
  Settings settings = randomSettings<Map>(random);
  for (const auto& [name, texts] : choicesForFiles(Law<Map>::kPrunes))
    set(settings, name, random.pick(texts));
  if (std::is_same_v<Map, COverlappingHilbertMap>)
    set(settings, "insertOpts.scansPerModel", random.pick<std::string>({"", "3"}));
  return settings;
}

inline std::string nameOf(const Settings& settings)
{
  std::string name;
  for (const auto& [key, text] : settings) name += key.substr(key.find('.') + 1) + " " + text + ", ";
  return name;
}

template <typename Map>
Map mapOf(const Settings& settings, const std::vector<TakenScan>& scans)
{
  Map map = made<Map>(settings);
  map.setMinLoggingLevel(mrpt::system::LVL_ERROR);
  for (const TakenScan& scan : scans) map.insertObservation(*scan.observation, scan.robotPose_map);
  return map;
}

/// What the map says of each cell; the place of a cell is given from `origin`.
template <typename Map>
Cells cellsFrom(const Map& map, const CellIndex& origin)
{
  Cells cells = cellsOf(map);
  for (auto& [index, prob, state, evidence] : cells)
  {
    index[0] -= origin.z;
    index[1] -= origin.y;
    index[2] -= origin.x;
  }
  return cells;
}

template <typename Map>
class MapLaws : public testing::Test
{
};
using AllMaps = testing::Types<CBGKMap, CGPMap, CHilbertMap, COverlappingHilbertMap>;

}  // namespace lamap::test
