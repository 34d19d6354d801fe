#include <lamap_tools/cells/octomap_file.h>
#include <lamap_tools/export/export_map.h>
#include <lamap_tools/files/file_names.h>
#include <lamap_tools/files/file_output.h>
#include <lamap_tools/files/usage_error.h>
#include <lamap_tools/pictures/render_map.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace lamap::tools
{
StateSet parseStates(const std::string& names)
{
  StateSet states;
  std::istringstream list(names);
  for (std::string name; std::getline(list, name, ',');)
  {
    if (name == "all")
      states = {true, true, true};
    else if (name == "free")
      states.free = true;
    else if (name == "occupied")
      states.occupied = true;
    else if (name == "unknown")
      states.unknown = true;
    else
      throw UsageError("'" + name + "' is no state of a cell; expected free, occupied, unknown or all");
  }
  if (!states.free && !states.occupied && !states.unknown)
    throw UsageError("no state of a cell is named; expected free, occupied, unknown or all");
  return states;
}

std::vector<StockMap> parseStockMaps(const std::string& names)
{
  std::vector<StockMap> maps;
  std::istringstream list(names);
  for (std::string name; std::getline(list, name, ',');)
  {
    if (name != "grid" && name != "points" && name != "octomap")
      throw UsageError("'" + name + "' is no map of MRPT's own to export; expected grid, points or octomap");
    const StockMap map = name == "grid"     ? StockMap::Grid
                         : name == "points" ? StockMap::Points
                                            : StockMap::Octomap;
    if (std::find(maps.begin(), maps.end(), map) != maps.end())
      throw UsageError("'" + name + "' is named twice among the maps to export");
    maps.push_back(map);
  }
  if (maps.empty()) throw UsageError("no map to export is named; expected grid, points or octomap");
  return maps;
}

void requireExportable(const std::string& path, const ExportOptions& options)
{
  const std::string extension = extensionOf(path);
  const auto& known = {".csv", ".ply", ".pcd", ".bt", ".ot", ".3dscene", ".png", ".yaml"};
  const bool isStock = isStockMapFile(path);
  if (!isStock && std::find(known.begin(), known.end(), extension) == known.end())
    throw UsageError(path + ": '" + extension +
                     "' is not a format for export; known are .csv .ply .pcd .bt .ot .3Dscene .png .yaml "
                     ".gridmap.gz .pts.gz .metricmap, and .gz with --as");
  for (const auto& height_m : {options.z_m, options.zMin_m, options.zMax_m})
    if (height_m && !std::isfinite(*height_m))
      throw UsageError(path + ": a height is not a finite number [m]");
  const auto refuse = [&](const char* option, const char* takers)
  { throw UsageError(path + ": " + extension + " takes no " + option + "; only " + takers + " do"); };
  const bool points =
      extension == ".csv" || extension == ".ply" || extension == ".pcd" || extension == ".3dscene";
  if (options.states && !points) refuse("--states", ".csv, .ply, .pcd and .3Dscene");
  if (!options.as.empty() && !isStock) refuse("--as", ".metricmap and .gz");
  const std::vector<StockMap> stock = isStock ? stockMapsIn(path, options) : std::vector<StockMap>{};
  const bool isFlat =
      extension == ".yaml" || std::find(stock.begin(), stock.end(), StockMap::Grid) != stock.end();
  if (options.z_m && !isFlat) refuse("--z", ".yaml and grids (and lamap render --view slice)");
  if ((options.zMin_m || options.zMax_m) && !isFlat && extension != ".png")
    refuse("--z-min or --z-max", ".yaml, grids and .png");
  if (options.z_m && (options.zMin_m || options.zMax_m))
    throw UsageError(path + ": --z makes a slice, --z-min and --z-max limit a projection; name one kind");
  if (options.zMin_m && options.zMax_m && *options.zMin_m > *options.zMax_m)
    throw UsageError(path + ": --z-min " + shortest(*options.zMin_m) + " is above --z-max " +
                     shortest(*options.zMax_m));
}

std::string remarkOn(const CellMap& map, const std::string& path, const ExportOptions& options)
{
  if (options.z_m || options.zMin_m || options.zMax_m) return "";
  bool isProjected = extensionOf(path) == ".yaml";
  if (isStockMapFile(path))
  {
    const std::vector<StockMap> maps = stockMapsIn(path, options);
    isProjected = std::find(maps.begin(), maps.end(), StockMap::Grid) != maps.end();
  }
  const auto extent = isProjected ? cellExtent(map) : std::nullopt;
  if (!extent || extent->first.z == extent->last.z) return "";
  const auto metres = [&](double index) { return shortest(index * map.resolution()); };
  return path + ": a projection of all heights, z = " + metres(extent->first.z) + " to " +
         metres(extent->last.z + 1.0) +
         " m: a floor or a ceiling among them is occupied everywhere; --z-min and --z-max leave them out";
}

void exportMap(const CellMap& map, const std::string& path, const ExportOptions& options)
{
  const std::string extension = extensionOf(path);
  const StateSet all{true, true, true};
  const StateSet occupied{false, true, false};
  requireExportable(path, options);

  if (extension == ".csv") return writeCsv(map, path, options.states.value_or(all));
  if (extension == ".ply") return writePly(map, path, options.states.value_or(occupied));
  if (extension == ".pcd") return writePcd(map, path, options.states.value_or(occupied));
  if (extension == ".3dscene") return writeScene(map, path, options.states.value_or(occupied));
  if (extension == ".bt" || extension == ".ot") return writeOctomapFile(map, path);
  if (extension == ".yaml") return writeRosMap(map, path, options);
  if (isStockMapFile(path)) return writeStockMaps(map, path, options);

  RenderOptions view;  // .png
  view.zMin_m = options.zMin_m;
  view.zMax_m = options.zMax_m;
  renderMap(map, path, view);
}

void requireFloatPrecision(const CellMap& map, const std::string& path, const CellIndex& first,
                           const CellIndex& last, const std::string& format)
{
  double farthest = 0;  // in cells
  for (const CellIndex& cell : {first, last})
    for (const int index : {cell.x, cell.y, cell.z}) farthest = std::max(farthest, std::abs(index + 0.5));
  constexpr double kMaxError = 0.05;  // of a cell
  if (farthest * static_cast<double>(std::numeric_limits<float>::epsilon()) / 2 <= kMaxError) return;
  throw std::runtime_error(path + ": cells lie up to " + shortest(farthest * map.resolution()) +
                           " m from the origin, where " + format +
                           " do not tell them apart; .ply and .csv do");
}

}  // namespace lamap::tools
