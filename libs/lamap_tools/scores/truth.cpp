#include <lamap_tools/cells/cell_map.h>
#include <lamap_tools/scores/truth.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
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

std::string_view trimmed(std::string_view text)
{
  const auto isBlank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty() && isBlank(text.front())) text.remove_prefix(1);
  while (!text.empty() && isBlank(text.back())) text.remove_suffix(1);
  return text;
}

std::vector<std::string_view> fieldsOf(std::string_view line)
{
  std::vector<std::string_view> fields;
  for (;;)
  {
    const size_t comma = line.find(',');
    fields.push_back(trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

std::optional<double> numberIn(std::string_view field)
{
  if (!field.empty() && field.front() == '+') field.remove_prefix(1);
  double number = 0;
  const auto result = std::from_chars(field.data(), field.data() + field.size(), number);
  if (result.ec != std::errc() || result.ptr != field.data() + field.size()) return std::nullopt;
  return number;
}

/// Which fields of a line are x, y, z and label.
struct Columns
{
  std::array<size_t, 4> places{0, 1, 2, 3};
  size_t count = 4;
};
constexpr std::array<const char*, 4> kColumnNames{"x", "y", "z", "label"};

/// A line with a field that is no number is a header if it stands first.
std::optional<Columns> columnsOfHeader(const std::vector<std::string_view>& fields)
{
  if (std::all_of(fields.begin(), fields.end(), [](std::string_view f) { return numberIn(f).has_value(); }))
    return std::nullopt;
  Columns columns;
  columns.count = fields.size();
  for (size_t i = 0; i < kColumnNames.size(); ++i)
  {
    const auto found = std::find(fields.begin(), fields.end(), kColumnNames[i]);
    if (found == fields.end())
      throw std::runtime_error(std::string("the header names no column ") + kColumnNames[i] +
                               ", expected x,y,z,label");
    columns.places[i] = static_cast<size_t>(found - fields.begin());
  }
  return columns;
}

TrueCell cellFrom(const std::vector<std::string_view>& fields, const Columns& columns)
{
  if (fields.size() != columns.count)
    throw std::runtime_error("has " + std::to_string(fields.size()) + " fields, expected " +
                             std::to_string(columns.count) + " (x,y,z,label)");
  TrueCell cell;
  for (size_t axis = 0; axis < 3; ++axis)
  {
    const std::string_view field = fields[columns.places[axis]];
    const auto number = numberIn(field);
    if (!number || !std::isfinite(*number))
      throw std::runtime_error(std::string(kColumnNames[axis]) + " is '" + std::string(field) +
                               "', expected a finite number [m]");
    cell.centre_map[static_cast<Eigen::Index>(axis)] = *number;
  }
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

bool isCsv(const std::string& path)
{
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".csv";
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
  Columns columns;
  bool first = true;
  size_t number = 0;
  for (std::string line; std::getline(in, line);)
  {
    ++number;
    std::string_view content = line;
    if (number == 1 && content.substr(0, 3) == "\xEF\xBB\xBF") content.remove_prefix(3);  // byte order mark
    content = trimmed(content);
    if (content.empty() || content.front() == '#') continue;
    try
    {
      const auto fields = fieldsOf(content);
      const auto header = first ? columnsOfHeader(fields) : std::nullopt;
      first = false;
      if (header)
      {
        columns = *header;
        continue;
      }
      truth.cells.push_back(cellFrom(fields, columns));
      lines.push_back(number);
    }
    catch (const std::runtime_error& error)
    {
      throw std::runtime_error(name + ":" + std::to_string(number) + ": " + error.what());
    }
  }
  if (in.bad()) throw std::runtime_error(name + ": cannot be read: " + std::strerror(errno));
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

Truth readTruth(const std::string& path)
{
  if (std::filesystem::is_directory(path)) throw std::runtime_error(path + ": is a folder, not a truth");
  if (!isCsv(path)) return truthFromMap(path);
  std::ifstream in(path);
  if (!in) throw std::runtime_error(path + ": cannot be opened: " + std::strerror(errno));
  return readTruthCsv(in, path);
}

}  // namespace lamap::tools
