#pragma once

#include <lamap_tools/cells/cell_map.h>

#include <optional>
#include <string>
#include <vector>

namespace lamap::tools
{
/// The states of the cells that go into a file.
struct StateSet
{
  bool free = false;
  bool occupied = false;
  bool unknown = false;

  [[nodiscard]] bool has(CellState state) const
  {
    return state == CellState::Free ? free : state == CellState::Occupied ? occupied : unknown;
  }
};

/// Parses names separated by commas, e.g. "occupied,free", or "all". @throws std::runtime_error naming the
/// wrong word.
[[nodiscard]] StateSet parseStates(const std::string& names);

/// The maps of MRPT's own that cells are written as.
enum class StockMap
{
  Grid,    ///< COccupancyGridMap2D
  Points,  ///< CSimplePointsMap
  Octomap  ///< COctoMap
};

/// Parses names separated by commas: grid, points, octomap. @throws UsageError naming the wrong word, or one
/// that is given twice
[[nodiscard]] std::vector<StockMap> parseStockMaps(const std::string& names);

struct ExportOptions
{
  /// Cells in .csv, .ply, .pcd and .3Dscene. Default: all for .csv, occupied ones for the others.
  std::optional<StateSet> states;
  /// Serialized maps: what the cells are written as. Default: by the extension.
  std::vector<StockMap> as;
  /// .yaml and grids: the height [m] of the slice. Default: none, the map is projected.
  std::optional<double> z_m;
  /// .yaml and grids (projection), .png: cells with centres within these heights [m]. Default: no limit.
  std::optional<double> zMin_m;
  std::optional<double> zMax_m;
};

/** Checks a path's extension and the options before a map is read for them.
 * @throws UsageError as exportMap. */
void requireExportable(const std::string& path, const ExportOptions& options);

/** What a user should know of a file before it is used; empty: nothing. A projection of all heights of a 3D
 * map has its floor and ceiling in it. @throws as requireExportable() */
[[nodiscard]] std::string remarkOn(const CellMap& map, const std::string& path, const ExportOptions& options);

/** Writes a map by the extension of the path: .csv .ply .pcd .bt .ot .3Dscene .png .yaml (with its .pgm), or
 * as maps of MRPT's own: .gridmap[.gz] .pts.gz .metricmap[.gz], or any .gz with one name in `as`. The file
 * appears when it is complete; an existing one remains until then.
 * @throws std::runtime_error naming the path and what is wrong: an unknown extension (lists the known ones),
 * an option that the format does not take, a map without the cells asked for, a folder that does not exist.
 */
void exportMap(const CellMap& map, const std::string& path, const ExportOptions& options = {});

/** A header line, then one line per finest cell, sorted by z, y, x: x,y,z [m, centre], prob, variance (empty
 * if there is none), state, and the learner's evidence. Numbers read back as the same doubles. */
void writeCsv(const CellMap& map, const std::string& path, const StateSet& states);

/** Points at cells' centres, binary little endian: x, y, z (double) [m], red, green, blue (by height), prob,
 * variance (float; nan if there is none; omitted if no cell has one) and state (uchar: 0 unknown, 1 free,
 * 2 occupied). */
void writePly(const CellMap& map, const std::string& path, const StateSet& states);

/** Points at cells' centres, binary PCD 0.7: x y z (float) [m], rgb (by height, packed as PCL does),
 * intensity = prob.
 * @throws also if cells are so far from the origin that float cannot distinguish neighbours. */
void writePcd(const CellMap& map, const std::string& path, const StateSet& states);

/// A scene of stock MRPT objects: voxels coloured by height, a ground grid, axes. Opens without this library.
void writeScene(const CellMap& map, const std::string& path, const StateSet& states);

/** The map as ROS's map_server reads it: the .yaml and, next to it with the same stem, the .pgm (0 occupied,
 * 254 free, 205 unknown; top row = greatest y). A slice shows the cells at z_m; a projection the cells
 * between zMin_m and zMax_m: occupied if any is, else free if any is. */
void writeRosMap(const CellMap& map, const std::string& yamlPath, const ExportOptions& options);

/// Whether a path is one that writeStockMaps() takes: .gridmap, .metricmap or .gz.
[[nodiscard]] bool isStockMapFile(const std::string& path);
/// The maps that such a file is to hold, in their order. @throws UsageError if the path and `as` do not agree
[[nodiscard]] std::vector<StockMap> stockMapsIn(const std::string& path, const ExportOptions& options);

/** MRPT's own maps as one serialized object, compressed by gzip, which programs load without this library:
 *
 * - .gridmap[.gz]: a COccupancyGridMap2D. A column is occupied if any cell at the heights is, and then has
 * the largest P(occupied) of these; else free if any is, with the largest of those; else 0.5. In steps of
 * MRPT's own cells.
 * - .pts.gz: a CSimplePointsMap of the centres of occupied cells.
 * - .metricmap[.gz]: a CMultiMetricMap, of these two and a COctoMap, or of what `as` names in its order.
 * - any other .gz: the one that `as` names. A COctoMap's file holds occupied and free cells alone, by MRPT.
 *
 * @throws std::runtime_error naming the path: no cell to write, or cells so far from the origin that float
 * cannot distinguish neighbours */
void writeStockMaps(const CellMap& map, const std::string& path, const ExportOptions& options);

/// @throws std::runtime_error naming the path and the limit if float coordinates of a format mix cells up.
/// @param format  and what its coordinates are, e.g. "PCD's float coordinates"
void requireFloatPrecision(const CellMap& map, const std::string& path, const CellIndex& first,
                           const CellIndex& last, const std::string& format);

}  // namespace lamap::tools
