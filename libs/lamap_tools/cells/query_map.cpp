#include <lamap_tools/cells/query_map.h>
#include <lamap_tools/files/file_output.h>
#include <lamap_tools/files/usage_error.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>
#include <stdexcept>

namespace lamap::tools
{
namespace
{
using mrpt::math::TPoint3D;

bool isBlank(char c)
{
  return c == ' ' || c == '\t' || c == '\r';
}

std::string trimmed(const std::string& text)
{
  auto begin = std::find_if_not(text.begin(), text.end(), isBlank);
  auto end = std::find_if_not(text.rbegin(), std::make_reverse_iterator(begin), isBlank).base();
  return {begin, end};
}

/// Fields between commas or semicolons where the line has any, between blanks otherwise.
std::vector<std::string> fieldsOf(const std::string& line)
{
  std::vector<std::string> fields;
  if (line.find_first_of(",;") == std::string::npos)
  {
    for (size_t at = 0; at < line.size();)
    {
      while (at < line.size() && isBlank(line[at])) ++at;
      size_t end = at;
      while (end < line.size() && !isBlank(line[end])) ++end;
      if (end > at) fields.push_back(line.substr(at, end - at));
      at = end;
    }
    return fields;
  }
  for (size_t at = 0;;)
  {
    const size_t end = std::min(line.find_first_of(",;", at), line.size());
    fields.push_back(trimmed(line.substr(at, end - at)));
    if (end == line.size()) return fields;
    at = end + 1;
  }
}

std::optional<double> numberIn(const std::string& field)
{
  double number = 0;
  const char* begin = field.data() + (field.rfind('+', 0) == 0 ? 1 : 0);
  const char* end = field.data() + field.size();
  const auto result = std::from_chars(begin, end, number);
  if (result.ec != std::errc() || result.ptr != end) return std::nullopt;
  return number;
}

/// Which fields of a line are x, y and z.
struct Columns
{
  std::array<size_t, 3> xyz{0, 1, 2};
  size_t count = 3;
};

TPoint3D pointFrom(const std::vector<std::string>& fields, const Columns& columns)
{
  if (fields.size() != columns.count)
    throw std::runtime_error("has " + std::to_string(fields.size()) + " fields, expected " +
                             (columns.count == 3 ? std::string("x,y,z") : std::to_string(columns.count)));
  TPoint3D point;
  for (size_t axis = 0; axis < 3; ++axis)
  {
    const std::string& field = fields[columns.xyz[axis]];
    const auto number = numberIn(field);
    if (!number || !std::isfinite(*number))
      throw std::runtime_error(std::string(1, "xyz"[axis]) + " is '" + field +
                               "', expected a finite number [m]");
    point[axis] = *number;
  }
  return point;
}

/// A line with letters where numbers should be is a header; it must name x, y and z.
std::optional<Columns> columnsOfHeader(const std::vector<std::string>& fields)
{
  if (std::any_of(fields.begin(), fields.end(), [](const std::string& f) { return numberIn(f).has_value(); }))
    return std::nullopt;
  Columns columns;
  columns.count = fields.size();
  for (size_t axis = 0; axis < 3; ++axis)
  {
    const auto found = std::find(fields.begin(), fields.end(), std::string(1, "xyz"[axis]));
    if (found == fields.end()) return std::nullopt;
    columns.xyz[axis] = static_cast<size_t>(found - fields.begin());
  }
  return columns;
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
  Columns columns;
  bool first = true;
  size_t number = 0;
  for (std::string line; std::getline(in, line);)
  {
    ++number;
    line = trimmed(line);
    if (number == 1 && line.rfind("\xEF\xBB\xBF", 0) == 0) line.erase(0, 3);  // byte order mark
    if (line.empty() || line.front() == '#') continue;
    const auto fields = fieldsOf(line);
    const auto header = first ? columnsOfHeader(fields) : std::nullopt;
    first = false;
    if (header)
    {
      columns = *header;
      continue;
    }
    try
    {
      points.push_back(pointFrom(fields, columns));
    }
    catch (const std::runtime_error& error)
    {
      throw std::runtime_error(name + ":" + std::to_string(number) + ": " + error.what());
    }
  }
  if (in.bad()) throw std::runtime_error(name + ": cannot be read: " + std::strerror(errno));
  return points;
}

std::vector<TPoint3D> readPointsFile(const std::string& path)
{
  if (path == "-") return readPoints(std::cin, "standard input");
  if (std::filesystem::is_directory(path))
    throw std::runtime_error(path + ": is a folder, not a file of points");
  std::ifstream in(path);
  if (!in) throw std::runtime_error(path + ": cannot be opened: " + std::strerror(errno));
  return readPoints(in, path);
}

void writeAnswersCsv(const CellMap& map, const std::vector<TPoint3D>& points, std::ostream& out)
{
  const auto names = map.evidenceNames();
  out << "x,y,z,prob,variance,state";
  for (const auto& name : names) out << ',' << name;
  out << '\n';
  for (const auto& point : points)
  {
    const auto estimate = map.estimateAt(point);
    out << shortest(point.x) << ',' << shortest(point.y) << ',' << shortest(point.z) << ',';
    if (estimate) out << shortest(estimate->prob);
    out << ',';
    if (estimate && estimate->variance) out << shortest(*estimate->variance);
    out << ',' << (estimate ? stateName(estimate->state) : "unobserved");
    for (size_t i = 0; i < names.size(); ++i) out << ',' << (estimate ? shortest(estimate->evidence[i]) : "");
    out << '\n';
  }
}

nlohmann::ordered_json answersJson(const CellMap& map, const std::vector<TPoint3D>& points)
{
  const auto names = map.evidenceNames();
  auto answers = nlohmann::ordered_json::array();
  for (const auto& point : points)
  {
    const auto estimate = map.estimateAt(point);
    nlohmann::ordered_json answer{{"x", point.x}, {"y", point.y}, {"z", point.z}};
    answer["prob"] = estimate ? nlohmann::ordered_json(estimate->prob) : nullptr;
    answer["variance"] =
        estimate && estimate->variance ? nlohmann::ordered_json(*estimate->variance) : nullptr;
    answer["state"] = estimate ? stateName(estimate->state) : "unobserved";
    for (size_t i = 0; i < names.size(); ++i)
      answer[names[i]] = estimate ? nlohmann::ordered_json(estimate->evidence[i]) : nullptr;
    answers.push_back(std::move(answer));
  }
  return answers;
}

}  // namespace lamap::tools
