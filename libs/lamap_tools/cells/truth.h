#pragma once

#include <Eigen/Core>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

namespace lamap::tools
{
/// A cell that is known to be occupied or free.
struct TrueCell
{
  Eigen::Vector3d centre_map;  ///< [m]
  bool occupied = false;
};

/** What a world is like, cell by cell. Each cell occurs once.
 * Plain data; const methods may be called from several threads. */
struct Truth
{
  std::string name;  ///< for messages: the file
  std::vector<TrueCell> cells;
  /// Least distance of two cells along an axis [m], which is their edge; nothing for a single cell.
  std::optional<double> spacing_m;
  /// Points on the surfaces of what is occupied, if they are known better than by cells [m].
  std::vector<Eigen::Vector3d> surface_map;

  [[nodiscard]] size_t occupiedCount() const;
  /// Whether all centres have the same height: the truth of a map for 2D sensors.
  [[nodiscard]] bool isOneLayer() const;
  /// Whether all centres are centres of cells of this edge, (i + 1/2)·edge; of a single layer only x and y
  /// count.
  [[nodiscard]] bool isOnGrid(double edge_m) const;
};

/** Reads a truth from CSV: a header that names the columns x, y, z and label in any order among others, or
 * four numbers per line without a header; x, y, z [m, map frame] are the centre of a cell, label is 1
 * (occupied) or 0 (free). Empty lines and lines that begin with # are left out.
 * @param name  of the text, for messages
 * @throws std::runtime_error naming the text, the number of the line and what is wrong with it; also for a
 * cell that occurs twice and for a text without cells */
[[nodiscard]] Truth readTruthCsv(std::istream& in, const std::string& name);

/** A truth of cells in memory. @param name  for messages
 * @throws std::invalid_argument for a cell that is not finite or occurs twice, and if there are none */
[[nodiscard]] Truth truthOfCells(std::vector<TrueCell> cells, const std::string& name);

/** Reads a truth from a file: `.csv` as above, or any map that openCellMap() reads (`.bt` for one), whose
 * free and occupied cells are the truth and whose undecided ones are left out.
 * @throws std::runtime_error as readTruthCsv and openCellMap. */
[[nodiscard]] Truth readTruth(const std::string& path);

/** Points on surfaces, for the distances of MapGeometry. @throws as readPointsFile(), and for a file without
 * points */
void readSurface(const std::string& path, Truth& truth);

}  // namespace lamap::tools
