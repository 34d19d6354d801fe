#include "commands.h"

#include <lamap_tools/cells/query_map.h>

#include <iostream>
#include <memory>
#include <string>
#include <vector>

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

int query(const QueryArguments& arguments)
{
  std::vector<mrpt::math::TPoint3D> points;
  for (const std::string& text : arguments.at) points.push_back(tools::parsePoint(text));
  const auto map = tools::openCellMap(arguments.map);
  if (!arguments.pointsFile.empty()) points = tools::readPointsFile(arguments.pointsFile);
  if (arguments.json)
    std::cout << tools::answersJson(*map, points).dump(2) << "\n";
  else
    tools::writeAnswersCsv(*map, points, std::cout);
  return 0;
}
}  // namespace

void addQuery(CLI::App& app, Action& action)
{
  auto arguments = std::make_shared<QueryArguments>();
  CLI::App* command =
      app.add_subcommand("query", "Ask a map about points: probability, variance, state, evidence");
  command->add_option("map", arguments->map, "A saved map (.lamap.gz), or OctoMap's .ot or .bt")->required();
  // A point is one text with commas: CLI11 shall not cut it up.
  auto* at =
      command->add_option("--at", arguments->at, "A point x,y,z in the map frame [m]; may be named again")
          ->type_size(1)
          ->allow_extra_args(false)
          ->take_all();
  auto* file = command->add_option(
      "--points", arguments->pointsFile,
      "A file of points, x,y,z a line, or a CSV whose header names them; - for the input");
  at->excludes(file);
  command->add_flag("--json", arguments->json, "The answers as JSON");
  command->callback(
      [&action, arguments]
      {
        if (arguments->at.empty() && arguments->pointsFile.empty())
          throw CLI::ValidationError("query", "name points by --at x,y,z or --points FILE");
        action = [arguments] { return query(*arguments); };
      });
}

}  // namespace lamap::app
