#include "commands.h"

#include <lamap_tools/commands/map_info.h>

#include <iostream>
#include <memory>

namespace lamap::app
{
void addInfo(CLI::App& app, Action& action)
{
  struct InfoArguments
  {
    std::string map;
    bool json = false;
  };
  auto arguments = std::make_shared<InfoArguments>();
  CLI::App* command =
      app.add_subcommand("info", "Say what is in a map: class, cells, extent, evidence, every option");
  command->add_option("map", arguments->map, "A saved map (.lamap.gz), or OctoMap's .ot or .bt")->required();
  command->add_flag("--json", arguments->json, "The same facts as JSON");
  command->callback(
      [&action, arguments]
      {
        action = [arguments]
        {
          const tools::MapInfo info = tools::readMapInfo(arguments->map);
          if (arguments->json)
            std::cout << tools::mapInfoJson(info).dump(2) << "\n";
          else
            tools::printMapInfo(info, std::cout);
          return 0;
        };
      });
}

}  // namespace lamap::app
