#pragma once

#include <lamap_tools/cells/cell_map.h>

#include <optional>
#include <string>
#include <vector>

namespace lamap::tools
{
/// Which states of cells go into a file.
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

/// From names separated by commas, e.g. "occupied,free", or "all". @throws std::runtime_error naming the
/// wrong word.
[[nodiscard]] StateSet parseStates(const std::string& names);

struct ExportOptions
{
  /// Which cells .csv, .ply, .pcd and .3Dscene hold. Default: all for .csv, occupied ones for the others.
  std::optional<StateSet> states;
  /// .yaml: the height [m] of the slice. Default: none, the map is projected.
  std::optional<double> z_m;
  /// .yaml (projection), .png: cells with their centre within these heights [m]. Default: no limit.
  std::optional<double> zMin_m;
  std::optional<double> zMax_m;
};

/** Checks a path's extension and the options before a map is read for them.
 * @throws UsageError as exportMap. */
void requireExportable(const std::string& path, const ExportOptions& options);

/** Writes a map by the extension of the path: .csv .ply .pcd .bt .ot .3Dscene .png .yaml (with its .pgm).
 * The file appears when it is whole; one that stood there stays until then.
 * @throws std::runtime_error naming the path and what is wrong: an unknown extension (lists the known ones),
 * an option that the format does not take, a map without the cells asked for, a folder that does not exist.
 */
void exportMap(const CellMap& map, const std::string& path, const ExportOptions& options = {});

/** A header line, then one line per finest cell, sorted by z, y, x: x,y,z [m, centre], prob, variance (empty
 * where there is none), state, and the learner's evidence. Numbers read back as the same doubles. */
void writeCsv(const CellMap& map, const std::string& path, const StateSet& states);

/** Points at cells' centres, binary little endian: x, y, z (double) [m], red, green, blue (by height), prob,
 * variance (float; nan where there is none; left out if no cell has one) and state (uchar: 0 unknown, 1 free,
 * 2 occupied). */
void writePly(const CellMap& map, const std::string& path, const StateSet& states);

/** Points at cells' centres, binary PCD 0.7: x y z (float) [m], rgb (by height, packed as PCL does),
 * intensity = prob.
 * @throws also where float cannot tell neighbouring cells apart, so far from the origin. */
void writePcd(const CellMap& map, const std::string& path, const StateSet& states);

/// A scene of stock MRPT objects: voxels coloured by height, a ground grid, axes. Opens without this library.
void writeScene(const CellMap& map, const std::string& path, const StateSet& states);

/** The map as ROS's map_server reads it: the .yaml and, beside it under the same stem, the .pgm (0 occupied,
 * 254 free, 205 unknown; top row = greatest y). A slice shows the cells at z_m; a projection the cells
 * between zMin_m and zMax_m, occupied where any is, else free where any is. */
void writeRosMap(const CellMap& map, const std::string& yamlPath, const ExportOptions& options);

}  // namespace lamap::tools
