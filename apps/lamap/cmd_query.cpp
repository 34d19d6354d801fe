#include <lamap_tools/commands/query_map.h>
#include <lamap_tools/files/point_list.h>

#include "command_line.h"

namespace lamap::app
{
namespace
{
struct QueryArguments
{
  std::string map;
  std::vector<std::string> at;
  std::string pointsFile;
  bool json = false;
};

void describe(CLI::App& command, QueryArguments& arguments)
{
  addMapArgument(command, arguments.map);
  // A point is one text with commas that CLI11 must not split.
  auto* at = command.add_option("--at", arguments.at, "A point x,y,z in the map frame [m]; may be repeated")
                 ->type_size(1)
                 ->allow_extra_args(false)
                 ->take_all();
  auto* file = command.add_option(
      "--points", arguments.pointsFile,
      "File of points: x,y,z per line, or a CSV whose header names x, y and z; -: standard input");
  at->excludes(file);
  command.add_flag("--json", arguments.json, "Print the answers as JSON");
}

void check(const CLI::App& /*command*/, const QueryArguments& arguments)
{
  if (arguments.at.empty() && arguments.pointsFile.empty())
    throw CLI::ValidationError("query", "give points with --at x,y,z or --points FILE");
}

/// @throws std::runtime_error if a file has no point. A pipe may have none, which is told.
std::vector<mrpt::math::TPoint3D> pointsOf(const std::string& path)
{
  auto points = tools::readPointsFile(path);
  if (!points.empty()) return points;
  if (path != "-") throw std::runtime_error(path + ": holds no point; expected lines x,y,z");
  std::cerr << "lamap: the standard input holds no point\n";
  return points;
}

int query(QueryArguments& arguments)
{
  std::vector<mrpt::math::TPoint3D> points;
  for (const std::string& text : arguments.at) points.push_back(tools::parsePoint(text));
  const auto map = tools::openCellMap(arguments.map);
  if (!arguments.pointsFile.empty()) points = pointsOf(arguments.pointsFile);
  if (arguments.json)
    print(tools::answersJson(*map, points));
  else
    tools::writeAnswersCsv(*map, points, results());
  return 0;
}
}  // namespace

void addQuery(CLI::App& app, Action& action)
{
  addCommand<QueryArguments, query>(
      app, action, "query", "Query a map at points: probability, variance, state, evidence", describe, check);
}

}  // namespace lamap::app
