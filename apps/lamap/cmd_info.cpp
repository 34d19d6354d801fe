#include <lamap_tools/commands/log_info.h>
#include <lamap_tools/commands/map_info.h>

#include "command_line.h"

namespace lamap::app
{
namespace
{
struct InfoArguments
{
  std::string path;
  tools::InputOptions inputs;
  LogArguments log;
  std::vector<CLI::Option*> forLogs;
  bool json = false;
};

void describe(CLI::App& command, InfoArguments& arguments)
{
  command
      .add_option("file", arguments.path,
                  "A saved map (.lamap.gz), OctoMap's .ot or .bt, or a log as of `lamap build`")
      ->required();
  arguments.forLogs = addInputOptions(command, arguments.log, arguments.inputs);
  for (CLI::Option* option : arguments.forLogs) option->group("For logs");
  command.add_flag("--json", arguments.json, "Print the same facts as JSON");
}

int logInfo(InfoArguments& arguments)
{
  arguments.inputs.paths = {arguments.path};
  prepareInputs(arguments.log, arguments.inputs);
  const tools::LogInfo found =
      withProgressBar([&](const auto& progress) { return tools::readLogInfo(arguments.inputs, progress); });
  if (found.stopped) return stoppedByUser("");
  if (arguments.json)
    print(tools::logInfoJson(found));
  else
    tools::printLogInfo(found, results());
  return tellDamages(arguments.log.allowTruncated, {found.input});
}

int info(InfoArguments& arguments)
{
  if (tools::isNameOfLog(arguments.path)) return logInfo(arguments);
  for (const CLI::Option* option : arguments.forLogs)
    if (option->count() > 0) throw CLI::ValidationError(option->get_name(), "is for logs only");
  const tools::MapInfo found = tools::readMapInfo(arguments.path);
  if (arguments.json)
    print(tools::mapInfoJson(found));
  else
    tools::printMapInfo(found, results());
  return 0;
}
}  // namespace

void addInfo(CLI::App& app, Action& action)
{
  addCommand<InfoArguments, info>(
      app, action, "info",
      "Show what a map holds (class, cells, extent, evidence, every option), or a log "
      "(sensors, scans, ranges, poses)",
      describe);
}

}  // namespace lamap::app
