#include <lamap_tools/commands/map_info.h>

#include "command_line.h"

namespace lamap::app
{
namespace
{
struct InfoArguments
{
  std::string map;
  bool json = false;
};

void describe(CLI::App& command, InfoArguments& arguments)
{
  addMapArgument(command, arguments.map);
  command.add_flag("--json", arguments.json, "Print the same facts as JSON");
}

int info(InfoArguments& arguments)
{
  const tools::MapInfo found = tools::readMapInfo(arguments.map);
  if (arguments.json)
    print(tools::mapInfoJson(found));
  else
    tools::printMapInfo(found, std::cout);
  return 0;
}
}  // namespace

void addInfo(CLI::App& app, Action& action)
{
  addCommand<InfoArguments>(app, action, "info",
                            "Show what a map holds: class, cells, extent, evidence, every option", describe,
                            info);
}

}  // namespace lamap::app
