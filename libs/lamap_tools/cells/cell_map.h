#pragma once

#include <lamap_core/grid/cell.h>
#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <mrpt/maps/CMetricMap.h>
#include <mrpt/math/TPoint3D.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace lamap::tools
{
/** Any map of cells, ours or a peer's, read in one way.
 *
 * Cells are those of lamap_core/cell.h, which are OctoMap's too: cell i covers [i·r, (i+1)·r). Leaves of an
 * octree that are larger than a finest cell are expanded.
 */
class CellMap
{
 public:
  virtual ~CellMap() = default;

  /// The class that holds the cells, e.g. "lamap::CBGKMap", "octomap::OcTree".
  [[nodiscard]] virtual std::string className() const = 0;
  /// Edge of a finest cell [m].
  [[nodiscard]] virtual double resolution() const = 0;
  /// Names of CellEstimate::evidence, in its order; one or two.
  [[nodiscard]] virtual std::vector<std::string> evidenceNames() const = 0;
  /// What the map says at a point of the map frame [m]; nothing where it was not observed.
  [[nodiscard]] virtual std::optional<CellEstimate> estimateAt(
      const mrpt::math::TPoint3D& point_map) const = 0;

  using CellVisitor = CLearnedMap::CellVisitor;
  /// Calls the visitor once for every finest cell that has evidence; no order is promised.
  virtual void visitCells(const CellVisitor& visitor) const = 0;

  /// @param first cell of a cube whose cells say the same, @param edge of it in cells
  using LeafVisitor = std::function<void(const CellIndex& first, int edge, const CellEstimate& estimate)>;
  /// The same cells, those of an octree's leaf in one call: what it costs does not grow with their number.
  virtual void visitLeaves(const LeafVisitor& visitor) const
  {
    visitCells([&](const CellIndex& cell, const CellEstimate& estimate) { visitor(cell, 1, estimate); });
  }

  /// The file that it was read from, for messages; empty: none.
  [[nodiscard]] const std::string& path() const { return path_; }
  void setPath(std::string path) { path_ = std::move(path); }

 private:
  std::string path_;
};

/// A map file, read.
struct OpenedMap
{
  /// The file's map; nothing where the file is an OctoMap tree.
  mrpt::maps::CMetricMap::Ptr map;
  /// Its cells; nothing where the map has none (a point map, say).
  std::unique_ptr<CellMap> cells;
  /// Of the class in MRPT's archive; nothing where the file is an OctoMap tree.
  std::optional<int> formatVersion;
};

/** Reads a map file: `.ot` and `.bt` with OctoMap, anything else as a saved MRPT map.
 * @throws std::runtime_error naming the file and what is wrong: missing, cut short, of another kind. */
[[nodiscard]] OpenedMap openMap(const std::string& path);

/// The same. @throws std::runtime_error also where the map has no cells, naming its class.
[[nodiscard]] OpenedMap openMapOfCells(const std::string& path);
/// Only the cells. @throws as openMapOfCells().
[[nodiscard]] std::unique_ptr<CellMap> openCellMap(const std::string& path);

/** The cells of a CLearnedMap, COctoMap, CColouredOctoMap or COccupancyGridMap2D (its layer is z index 0,
 * cells never observed are left out); nullptr for any other class. Keeps the map alive. */
[[nodiscard]] std::unique_ptr<CellMap> cellsOf(const mrpt::maps::CMetricMap::Ptr& map);

/** Calls a visitor for each cell of an octree's leaves.
 * @throws std::runtime_error before any call, naming the file and the count, if they stand for more finest
 * cells than are read one by one: 2^20 and 256 for each leaf, no more than 2^28, or what the environment
 * variable LAMAP_MAX_CELLS says. */
void visitCellsOfLeaves(const CellMap& octree, const CellMap::CellVisitor& visitor);

/// @throws std::runtime_error naming a resolution that no cells are read with: 1e-6 to 1e6 m are legal
void requireReadableResolution(const std::string& path, double resolution_m);

/// "free", "occupied" or "unknown".
[[nodiscard]] const char* stateName(CellState state);

}  // namespace lamap::tools
