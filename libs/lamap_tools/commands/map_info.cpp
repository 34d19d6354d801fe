#include <lamap_tools/cells/octomap_file.h>
#include <lamap_tools/commands/map_info.h>
#include <lamap_tools/files/file_output.h>
#include <lamap_tools/report/fact_line.h>
#include <mrpt/core/format.h>
#include <mrpt/maps/CPointsMap.h>

#include <algorithm>
#include <filesystem>
#include <ostream>
#include <type_traits>
#include <variant>

namespace lamap::tools
{
CellSummary summarizeCells(const CellMap& map)
{
  CellSummary summary;
  summary.resolution_m = map.resolution();
  summary.evidenceNames = map.evidenceNames();
  map.visitLeaves(
      [&](const CellIndex& first, int edge, const CellEstimate& estimate)
      {
        if (!summary.extent) summary.extent = CellExtent{first, first};
        summary.extent->include(first);
        summary.extent->include({first.x + edge - 1, first.y + edge - 1, first.z + edge - 1});
        const auto along = static_cast<uint64_t>(edge);
        const uint64_t cells = along * along * along;
        if (estimate.state == CellState::Free) summary.free += cells;
        if (estimate.state == CellState::Occupied) summary.occupied += cells;
        if (estimate.state == CellState::Unknown) summary.unknown += cells;
        for (size_t i = 0; i < summary.evidenceNames.size(); ++i)
          summary.evidenceSums[i] += static_cast<double>(cells) * estimate.evidence[i];
      });
  return summary;
}

MapInfo readMapInfo(const std::string& path)
{
  const OpenedMap opened = openMap(path);
  MapInfo info;
  info.path = path;
  info.fileBytes = std::filesystem::file_size(path);
  info.className = opened.map ? opened.map->GetRuntimeClass()->className : opened.cells->className();
  if (opened.cells) info.cells = summarizeCells(*opened.cells);
  if (!opened.map) return info;

  info.formatVersion = opened.formatVersion;
  if (const auto* learned = dynamic_cast<const CLearnedMap*>(opened.map.get()))
  {
    info.alias = learned->alias();
    info.facts = learned->facts();
    info.options = learned->optionValues();
  }
  else
    info.description = opened.map->asString();
  if (const auto* points = dynamic_cast<const mrpt::maps::CPointsMap*>(opened.map.get()))
    info.facts.push_back({"points", points->size()});
  return info;
}

namespace
{
/// Ten digits are more than any sensor gives, and hide what doubles do to 0.1.
std::string metres(double length_m)
{
  return mrpt::format("%.10g", length_m);
}

std::string percent(uint64_t part, uint64_t whole)
{
  const double share = whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
  return std::to_string(part) + mrpt::format(" (%.1f %%)", 100 * share);
}

void printCells(const CellSummary& cells, std::ostream& out)
{
  printFact(out, "resolution", metres(cells.resolution_m), "m");
  printFact(out, "observed cells", std::to_string(cells.observed()));
  if (!cells.extent) return;
  printFact(out, "  occupied", percent(cells.occupied, cells.observed()));
  printFact(out, "  free", percent(cells.free, cells.observed()));
  printFact(out, "  unknown", percent(cells.unknown, cells.observed()));
  const Eigen::AlignedBox3d box_m = cells.extent->box_m(cells.resolution_m);
  for (int i = 0; i < 3; ++i)
    printFact(out, std::string("extent ") + "xyz"[i],
              metres(box_m.min()[i]) + " .. " + metres(box_m.max()[i]) + " m, " + metres(box_m.sizes()[i]),
              "m");
  for (size_t i = 0; i < cells.evidenceNames.size(); ++i)
    printFact(out, "sum of " + cells.evidenceNames[i], shortest(cells.evidenceSums[i]));
}

/// Facts that printCells() has printed already, in the same words for every class.
bool isCellCount(const CLearnedMap::Fact& fact)
{
  const auto& names = {"resolution", "cells", "occupied cells", "free cells", "unknown cells"};
  return std::find(names.begin(), names.end(), fact.name) != names.end();
}

/// Numbers and truth values as such, anything else as text.
Json jsonOf(const OptionValue& option)
{
  return std::visit(
      [&](const auto& content) -> Json
      {
        if constexpr (std::is_arithmetic_v<std::decay_t<decltype(content)>>)
          return content;
        else
          return option.text;
      },
      option.content);
}

Json cellsJson(const CellSummary& cells)
{
  Json json{{"observed", cells.observed()},
            {"occupied", cells.occupied},
            {"free", cells.free},
            {"unknown", cells.unknown}};
  json["evidence"] = Json::object();
  for (size_t i = 0; i < cells.evidenceNames.size(); ++i)
    json["evidence"][cells.evidenceNames[i]] = cells.evidenceSums[i];
  return json;
}
}  // namespace

void printMapInfo(const MapInfo& info, std::ostream& out)
{
  printFact(out, "file", info.path);
  printFact(out, "file size", std::to_string(info.fileBytes), "bytes");
  printFact(out, "class", info.className);
  if (!info.alias.empty()) printFact(out, "alias", info.alias);
  if (info.formatVersion) printFact(out, "format version", std::to_string(*info.formatVersion));
  if (!info.description.empty()) printFact(out, "description", info.description);
  if (info.cells) printCells(*info.cells, out);
  for (const auto& fact : info.facts)
    if (!info.cells || !isCellCount(fact)) printFact(out, fact.name, fact.text(), fact.unit);
  for (const auto& option : info.options)
    printFact(out, option.section + "." + option.key, option.text.empty() ? "(empty)" : option.text,
              option.unit);
}

Json mapInfoJson(const MapInfo& info)
{
  Json json{{"file", info.path}, {"fileBytes", info.fileBytes}, {"class", info.className}};
  if (!info.alias.empty()) json["alias"] = info.alias;
  if (info.formatVersion) json["formatVersion"] = *info.formatVersion;
  if (!info.description.empty()) json["description"] = info.description;
  if (info.cells)
  {
    json["resolution"] = info.cells->resolution_m;
    json["cells"] = cellsJson(*info.cells);
    json["extent"] = nullptr;
    if (info.cells->extent)
    {
      const Eigen::AlignedBox3d box_m = info.cells->extent->box_m(info.cells->resolution_m);
      const auto corner = [](const Eigen::Vector3d& p) { return Json{p.x(), p.y(), p.z()}; };
      json["extent"] = {{"min", corner(box_m.min())}, {"max", corner(box_m.max())}};
    }
  }
  json["facts"] = Json::object();
  json["units"] = Json::object();
  for (const auto& fact : info.facts)
  {
    json["facts"][fact.name] = std::visit([](auto number) { return Json(number); }, fact.number);
    if (!fact.unit.empty()) json["units"][fact.name] = fact.unit;
  }
  json["options"] = Json::object();
  for (const auto& option : info.options) json["options"][option.section][option.key] = jsonOf(option);
  return json;
}

}  // namespace lamap::tools
