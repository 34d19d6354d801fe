#include <lamap_tools/cells/truth.h>

#include <lamap_tools/cells/cell_map.h>
#include <lamap_tools/files/file_input.h>
#include <lamap_tools/files/file_names.h>
#include <lamap_tools/files/point_list.h>
#include <lamap_tools/files/text_fields.h>
#include <lamap_tools/report/counted.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <numeric>
#include <stdexcept>
#include <string_view>

namespace lamap::tools
{
namespace
{
/// Coordinates nearer to each other than this [m] are the same one, rounded differently.
constexpr double kSameCoordinate_m = 1e-5;

/// Which fields of a line are x, y, z and label.
struct Columns
{
  std::array<size_t, 4> places{0, 1, 2, 3};
  size_t count = 4;
};
const std::vector<std::string> kColumnNames{"x", "y", "z", "label"};

/// A line with a field that is no number is a header if it stands first.
std::optional<Columns> columnsOfHeader(const std::vector<std::string_view>& fields)
{
  if (std::all_of(fields.begin(), fields.end(),
                  [](auto field) { return numberIn<double>(field).has_value(); }))
    return std::nullopt;
  Columns columns{{}, fields.size()};
  const auto places = placesOf(kColumnNames, fields);
  for (size_t i = 0; i < places.size(); ++i)
  {
    if (!places[i])
      throw std::runtime_error("the header names no column " + kColumnNames[i] + ", expected x,y,z,label");
    columns.places[i] = *places[i];
  }
  return columns;
}

TrueCell cellFrom(const std::vector<std::string_view>& fields, const Columns& columns)
{
  if (fields.size() != columns.count)
    throw std::runtime_error("has " + counted(fields.size(), "field") + ", expected " +
                             std::to_string(columns.count) + " (x,y,z,label)");
  TrueCell cell;
  for (size_t axis = 0; axis < 3; ++axis)
    cell.centre_map[static_cast<Eigen::Index>(axis)] =
        coordinateIn(fields[columns.places[axis]], kColumnNames[axis]);
  const std::string_view label = fields[columns.places[3]];
  if (label != "0" && label != "1")
    throw std::runtime_error("label is '" + std::string(label) + "', expected 1 (occupied) or 0 (free)");
  cell.occupied = label == "1";
  return cell;
}

bool inOrder(const Eigen::Vector3d& a, const Eigen::Vector3d& b)
{
  for (const int axis : {2, 1, 0})
    if (a[axis] != b[axis]) return a[axis] < b[axis];
  return false;
}

/// @param lines the number of the line that each cell was read from
void requireEachCellOnce(const std::vector<TrueCell>& cells, const std::vector<size_t>& lines)
{
  const auto risesTo = [&](size_t i) { return inOrder(cells[i - 1].centre_map, cells[i].centre_map); };
  size_t rising = 1;
  while (rising < cells.size() && risesTo(rising)) ++rising;
  if (rising >= cells.size()) return;  // a sorted file, as ours are
  std::vector<size_t> order(cells.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return inOrder(cells[a].centre_map, cells[b].centre_map); });
  for (size_t i = 1; i < order.size(); ++i)
    if (cells[order[i - 1]].centre_map == cells[order[i]].centre_map)
      throw std::runtime_error(std::to_string(lines[order[i]]) + ": the cell stands in line " +
                               std::to_string(lines[order[i - 1]]) + " already");
}

std::optional<double> leastSpacing(const std::vector<TrueCell>& cells)
{
  std::optional<double> least;
  for (int axis = 0; axis < 3; ++axis)
  {
    std::vector<double> coordinates;
    coordinates.reserve(cells.size());
    for (const TrueCell& cell : cells)
      if (coordinates.empty() || coordinates.back() != cell.centre_map[axis])
        coordinates.push_back(cell.centre_map[axis]);
    std::sort(coordinates.begin(), coordinates.end());
    for (size_t i = 1; i < coordinates.size(); ++i)
    {
      const double distance = coordinates[i] - coordinates[i - 1];
      if (distance > kSameCoordinate_m && (!least || distance < *least)) least = distance;
    }
  }
  return least;
}

Truth truthFromMap(const std::string& path)
{
  Truth truth;
  truth.name = path;
  const auto map = openCellMap(path);
  truth.spacing_m = map->resolution();
  map->visitCells(
      [&](const CellIndex& cell, const CellEstimate& estimate)
      {
        if (estimate.state == CellState::Unknown) return;
        truth.cells.push_back({cellCentre(cell, *truth.spacing_m), estimate.state == CellState::Occupied});
      });
  if (truth.cells.empty()) throw std::runtime_error(path + ": holds no cell that is free or occupied");
  return truth;
}
}  // namespace

size_t Truth::occupiedCount() const
{
  return static_cast<size_t>(
      std::count_if(cells.begin(), cells.end(), [](const TrueCell& cell) { return cell.occupied; }));
}

bool Truth::isOneLayer() const
{
  return std::all_of(
      cells.begin(), cells.end(),
      [&](const TrueCell& cell)
      { return std::abs(cell.centre_map.z() - cells.front().centre_map.z()) < kSameCoordinate_m; });
}

bool Truth::isOnGrid(double edge_m) const
{
  constexpr double kTolerance = 0.01;  // of a cell
  const int axes = isOneLayer() ? 2 : 3;
  return std::all_of(cells.begin(), cells.end(),
                     [&](const TrueCell& cell)
                     {
                       for (int axis = 0; axis < axes; ++axis)
                       {
                         const double index = cell.centre_map[axis] / edge_m - 0.5;
                         if (!(std::abs(index - std::round(index)) < kTolerance)) return false;
                       }
                       return true;
                     });
}

Truth readTruthCsv(std::istream& in, const std::string& name)
{
  Truth truth;
  truth.name = name;
  std::vector<size_t> lines;
  std::optional<Columns> columns;
  forEachLine(in, name,
              [&](std::string_view line, size_t number)
              {
                const auto fields = fieldsBetween(line, ",");
                if (!columns)
                {
                  const auto header = columnsOfHeader(fields);
                  columns = header.value_or(Columns());
                  if (header) return;
                }
                truth.cells.push_back(cellFrom(fields, *columns));
                lines.push_back(number);
              });
  if (truth.cells.empty()) throw std::runtime_error(name + ": holds no cell; expected lines x,y,z,label");
  try
  {
    requireEachCellOnce(truth.cells, lines);
  }
  catch (const std::runtime_error& error)
  {
    throw std::runtime_error(name + ":" + error.what());
  }
  truth.spacing_m = leastSpacing(truth.cells);
  return truth;
}

Truth truthOfCells(std::vector<TrueCell> cells, const std::string& name)
{
  if (cells.empty()) throw std::invalid_argument(name + ": holds no cell");
  for (const TrueCell& cell : cells)
    if (!cell.centre_map.allFinite()) throw std::invalid_argument(name + ": a centre is not finite");
  std::vector<const TrueCell*> order;
  order.reserve(cells.size());
  for (const TrueCell& cell : cells) order.push_back(&cell);
  std::sort(order.begin(), order.end(),
            [](const TrueCell* a, const TrueCell* b) { return inOrder(a->centre_map, b->centre_map); });
  for (size_t i = 1; i < order.size(); ++i)
    if (order[i - 1]->centre_map == order[i]->centre_map)
      throw std::invalid_argument(name + ": a cell occurs twice");
  Truth truth;
  truth.name = name;
  truth.spacing_m = leastSpacing(cells);
  truth.cells = std::move(cells);
  return truth;
}

Truth readTruth(const std::string& path)
{
  requireNoFolder(path, "a truth");
  if (extensionOf(path) != ".csv") return truthFromMap(path);
  std::ifstream in = openedFile(path, "a truth");
  return readTruthCsv(in, path);
}

void readSurface(const std::string& path, Truth& truth)
{
  truth.surface_map.clear();
  for (const mrpt::math::TPoint3D& point : readPointsFile(path))
    truth.surface_map.emplace_back(point.x, point.y, point.z);
  if (truth.surface_map.empty()) throw std::runtime_error(path + ": holds no point; expected lines x,y,z");
}

}  // namespace lamap::tools
