#include <lamap_tools/cells/octomap_file.h>
#include <lamap_tools/commands/map_info.h>
#include <lamap_tools/files/file_output.h>
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/maps/CPointsMap.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <ostream>

namespace lamap::tools
{
CellSummary summarizeCells(const CellMap& map)
{
  CellSummary summary;
  summary.resolution_m = map.resolution();
  summary.evidenceNames = map.evidenceNames();
  map.visitCells(
      [&](const CellIndex& cell, const CellEstimate& estimate)
      {
        if (!summary.extent) summary.extent = CellExtent{cell, cell};
        summary.extent->include(cell);
        if (estimate.state == CellState::Free) ++summary.free;
        if (estimate.state == CellState::Occupied) ++summary.occupied;
        if (estimate.state == CellState::Unknown) ++summary.unknown;
        for (size_t i = 0; i < summary.evidenceNames.size(); ++i)
          summary.evidenceSums[i] += estimate.evidence[i];
      });
  return summary;
}

namespace
{
/** The version that a class gave its object in a file: MRPT's archives begin with the length of the class's
 * name (with the highest bit set), the name, and this number. */
std::optional<int> formatVersion(const std::string& path)
{
  mrpt::io::CFileGZInputStream file;
  if (!file.open(path)) return std::nullopt;
  std::array<uint8_t, 129> start{};  // a length has seven bits
  const size_t count = file.Read(start.data(), start.size());
  const size_t at = 1 + (start[0] & 0x7FU);
  if (at >= count) return std::nullopt;
  return static_cast<int>(static_cast<int8_t>(start[at]));
}
}  // namespace

MapInfo readMapInfo(const std::string& path)
{
  const OpenedMap opened = openMap(path);
  MapInfo info;
  info.path = path;
  info.fileBytes = std::filesystem::file_size(path);
  info.className = opened.map ? opened.map->GetRuntimeClass()->className : opened.cells->className();
  if (opened.cells) info.cells = summarizeCells(*opened.cells);
  if (!opened.map) return info;

  info.formatVersion = formatVersion(path);
  if (const auto* learned = dynamic_cast<const CLearnedMap*>(opened.map.get()))
  {
    info.alias = learned->alias();
    info.facts = learned->facts();
    info.options = learned->optionValues();
  }
  else
    info.description = opened.map->asString();
  if (const auto* points = dynamic_cast<const mrpt::maps::CPointsMap*>(opened.map.get()))
    info.facts.push_back({"points", std::to_string(points->size()), ""});
  return info;
}

namespace
{
struct Axes
{
  std::array<double, 3> min_m;
  std::array<double, 3> max_m;
};

Axes limits(const CellSummary& cells)
{
  const double r = cells.resolution_m;
  const CellIndex& a = cells.extent->first;
  const CellIndex& b = cells.extent->last;
  return {{a.x * r, a.y * r, a.z * r}, {(b.x + 1.0) * r, (b.y + 1.0) * r, (b.z + 1.0) * r}};
}

void printLine(std::ostream& out, const std::string& name, const std::string& text,
               const std::string& unit = "")
{
  constexpr int kNameWidth = 34;
  out << std::left << std::setw(kNameWidth) << name << ' ' << text << (unit.empty() ? "" : " ") << unit
      << '\n';
}

/// Ten digits are more than any sensor gives, and hide what doubles do to 0.1.
std::string metres(double length_m)
{
  std::ostringstream text;
  text << std::setprecision(10) << length_m;
  return text.str();
}

std::string percent(uint64_t part, uint64_t whole)
{
  std::ostringstream text;
  text << part << " (" << std::fixed << std::setprecision(1)
       << (whole == 0 ? 0.0 : 100.0 * static_cast<double>(part) / static_cast<double>(whole)) << " %)";
  return text.str();
}

void printCells(const CellSummary& cells, std::ostream& out)
{
  printLine(out, "resolution", metres(cells.resolution_m), "m");
  printLine(out, "observed cells", std::to_string(cells.observed()));
  if (!cells.extent) return;
  printLine(out, "  occupied", percent(cells.occupied, cells.observed()));
  printLine(out, "  free", percent(cells.free, cells.observed()));
  printLine(out, "  unknown", percent(cells.unknown, cells.observed()));
  const Axes axes = limits(cells);
  for (size_t i = 0; i < 3; ++i)
    printLine(out, std::string("extent ") + "xyz"[i],
              metres(axes.min_m[i]) + " .. " + metres(axes.max_m[i]) + " m, " +
                  metres(axes.max_m[i] - axes.min_m[i]),
              "m");
  for (size_t i = 0; i < cells.evidenceNames.size(); ++i)
    printLine(out, "sum of " + cells.evidenceNames[i], shortest(cells.evidenceSums[i]));
}

/// Facts that the walk over the cells has told already, in the same words for every class.
bool isCellCount(const CLearnedMap::Fact& fact)
{
  const auto& names = {"resolution", "cells", "occupied cells", "free cells", "unknown cells"};
  return std::find(names.begin(), names.end(), fact.name) != names.end();
}

/// A text that is a number or a truth value becomes one.
nlohmann::ordered_json typed(const std::string& text)
{
  if (text == "true") return true;
  if (text == "false") return false;
  const char* end = text.data() + text.size();
  int64_t whole = 0;
  if (const auto read = std::from_chars(text.data(), end, whole); read.ec == std::errc() && read.ptr == end)
    return whole;
  double number = 0;
  if (const auto read = std::from_chars(text.data(), end, number);
      read.ec == std::errc() && read.ptr == end && std::isfinite(number))
    return number;
  return text;
}

nlohmann::ordered_json cellsJson(const CellSummary& cells)
{
  nlohmann::ordered_json json{{"observed", cells.observed()},
                              {"occupied", cells.occupied},
                              {"free", cells.free},
                              {"unknown", cells.unknown}};
  json["evidence"] = nlohmann::ordered_json::object();
  for (size_t i = 0; i < cells.evidenceNames.size(); ++i)
    json["evidence"][cells.evidenceNames[i]] = cells.evidenceSums[i];
  return json;
}
}  // namespace

void printMapInfo(const MapInfo& info, std::ostream& out)
{
  printLine(out, "file", info.path);
  printLine(out, "file size", std::to_string(info.fileBytes), "bytes");
  printLine(out, "class", info.className);
  if (!info.alias.empty()) printLine(out, "alias", info.alias);
  if (info.formatVersion) printLine(out, "format version", std::to_string(*info.formatVersion));
  if (!info.description.empty()) printLine(out, "description", info.description);
  if (info.cells) printCells(*info.cells, out);
  for (const auto& fact : info.facts)
    if (!info.cells || !isCellCount(fact)) printLine(out, fact.name, fact.value, fact.unit);
  for (const auto& option : info.options)
    printLine(out, option.section + "." + option.key, option.text.empty() ? "(empty)" : option.text,
              option.unit);
}

nlohmann::ordered_json mapInfoJson(const MapInfo& info)
{
  nlohmann::ordered_json json{{"file", info.path}, {"fileBytes", info.fileBytes}, {"class", info.className}};
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
      const Axes axes = limits(*info.cells);
      json["extent"] = {{"min", axes.min_m}, {"max", axes.max_m}};
    }
  }
  json["facts"] = nlohmann::ordered_json::object();
  json["units"] = nlohmann::ordered_json::object();
  for (const auto& fact : info.facts)
  {
    json["facts"][fact.name] = typed(fact.value);
    if (!fact.unit.empty()) json["units"][fact.name] = fact.unit;
  }
  json["options"] = nlohmann::ordered_json::object();
  for (const auto& option : info.options) json["options"][option.section][option.key] = typed(option.text);
  return json;
}

}  // namespace lamap::tools
