#pragma once

#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/maps/TMetricMapInitializer.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <support/small_maps.h>

// Maps of any class, created from configurations.
namespace lamap::test
{
using Settings = std::vector<std::pair<std::string, std::string>>;  ///< "section.key", text

template <typename Map>
std::string aliasOf()
{
  return Map().alias();
}

inline std::string iniOf(const std::string& alias, const Settings& settings)
{
  std::string ini = "[map]\n" + alias + "_count = 1\n";
  for (const std::string section : {"creationOpts", "insertOpts", "likelihoodOpts", "renderOpts"})
  {
    ini += "[map_" + alias + "_00_" + section + "]\n";
    for (const auto& [name, text] : settings)
      if (name.rfind(section + ".", 0) == 0) ini += name.substr(section.size() + 1) + " = " + text + "\n";
  }
  return ini;
}

template <typename Map>
Map made(const Settings& settings = {}, const std::string& name = aliasOf<Map>())
{
  mrpt::maps::TSetOfMetricMapInitializers definitions;
  definitions.loadFromConfigFile(mrpt::config::CConfigFileMemory(iniOf(name, settings)), "map");
  mrpt::maps::CMultiMetricMap maps;
  maps.setListOfMaps(definitions);
  return dynamic_cast<Map&>(*maps.maps.at(0));
}

inline const mrpt::poses::CPose3D kSecondPose(0.3, 0.2, 0.1, 0.5, 0.02, -0.03);

/// Two scans: one as rays, one as an observation.
template <typename Map>
void teach(Map& map)
{
  map.insertScan(smallScan());
  map.insertObservation(roomScan(61), kSecondPose);
}

template <typename Map>
Map taught(const Settings& settings = {})
{
  Map map = made<Map>(settings);
  teach(map);
  return map;
}

template <typename Map>
size_t cellCount(const Map& map)
{
  size_t count = 0;
  map.visitCells([&](const lamap::CellIndex&, const lamap::CellEstimate&) { ++count; });
  return count;
}

/// Index (z, y, x), P(occupied), state and evidence of every cell that has any, in order.
using Cells =
    std::vector<std::tuple<std::array<int32_t, 3>, double, lamap::CellState, std::array<double, 2>>>;
template <typename Map>
Cells cellsOf(const Map& map)
{
  Cells cells;
  map.visitCells(
      [&](const lamap::CellIndex& cell, const lamap::CellEstimate& estimate)
      {
        cells.emplace_back(std::array<int32_t, 3>{cell.z, cell.y, cell.x}, estimate.prob, estimate.state,
                           estimate.evidence);
      });
  std::sort(cells.begin(), cells.end());
  return cells;
}

template <typename Map>
std::map<std::string, std::string> factsOf(const Map& map)
{
  std::map<std::string, std::string> facts;
  for (const auto& fact : map.facts()) facts[fact.name] = fact.text();
  return facts;
}

inline std::string contentOf(const std::string& path)
{
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace lamap::test
