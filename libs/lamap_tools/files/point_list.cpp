#include <lamap_tools/files/point_list.h>

#include <lamap_tools/files/file_input.h>
#include <lamap_tools/files/text_fields.h>
#include <lamap_tools/files/usage_error.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <string_view>

namespace lamap::tools
{
namespace
{
using mrpt::math::TPoint3D;

/// Fields between commas or semicolons where the line has any, between blanks otherwise.
std::vector<std::string_view> fieldsOf(std::string_view line)
{
  if (line.find_first_of(",;") != std::string_view::npos) return fieldsBetween(line, ",;");
  std::vector<std::string_view> fields = fieldsBetween(line, " \t\r");
  fields.erase(std::remove(fields.begin(), fields.end(), std::string_view()), fields.end());
  return fields;
}

/// Which fields of a line are x, y and z.
struct Columns
{
  std::array<size_t, 3> xyz{0, 1, 2};
  size_t count = 3;
};

TPoint3D pointFrom(const std::vector<std::string_view>& fields, const Columns& columns)
{
  if (fields.size() != columns.count)
    throw std::runtime_error("has " + std::to_string(fields.size()) + " fields, expected " +
                             (columns.count == 3 ? "x,y,z" : std::to_string(columns.count)));
  TPoint3D point;
  for (size_t axis = 0; axis < 3; ++axis)
    point[axis] = coordinateIn(fields[columns.xyz[axis]], std::string(1, "xyz"[axis]));
  return point;
}

/// A line with letters where numbers should be is a header; it must name x, y and z.
std::optional<Columns> columnsOfHeader(const std::vector<std::string_view>& fields)
{
  if (std::any_of(fields.begin(), fields.end(),
                  [](auto field) { return numberIn<double>(field).has_value(); }))
    return std::nullopt;
  const auto places = placesOf({"x", "y", "z"}, fields);
  if (!places[0] || !places[1] || !places[2]) return std::nullopt;
  return Columns{{*places[0], *places[1], *places[2]}, fields.size()};
}
}  // namespace

TPoint3D parsePoint(const std::string& text)
{
  try
  {
    return pointFrom(fieldsOf(trimmed(text)), {});
  }
  catch (const std::runtime_error& error)
  {
    throw UsageError("'" + text + "': " + error.what());
  }
}

std::vector<TPoint3D> readPoints(std::istream& in, const std::string& name)
{
  std::vector<TPoint3D> points;
  std::optional<Columns> columns;
  forEachLine(in, name,
              [&](std::string_view line, size_t)
              {
                const auto fields = fieldsOf(line);
                if (!columns)
                {
                  const auto header = columnsOfHeader(fields);
                  columns = header.value_or(Columns());
                  if (header) return;
                }
                points.push_back(pointFrom(fields, *columns));
              });
  return points;
}

std::vector<TPoint3D> readPointsFile(const std::string& path)
{
  if (path == "-") return readPoints(std::cin, "standard input");
  std::ifstream in = openedFile(path, "a file of points");
  return readPoints(in, path);
}

}  // namespace lamap::tools
