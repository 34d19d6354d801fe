#include "commands.h"

#include <lamap_tools/config/plugin_run.h>

#include <memory>

namespace lamap::app
{
void addRun(CLI::App& app, Action& action, const std::vector<std::string>& program)
{
  CLI::App* command = app.add_subcommand("run", "Run any MRPT program with the plug-in loaded");
  command->footer(
      "PROGRAM and its arguments follow the options, after -- if there are any: lamap run -- PROGRAM "
      "[ARGUMENTS...]");
  auto withoutCheck = std::make_shared<bool>(false);
  command->add_flag("--no-check", *withoutCheck, "Do not check the .ini files among the arguments first");
  command->callback(
      [&action, program, withoutCheck]
      {
        if (program.empty()) throw CLI::RequiredError("PROGRAM");
        if constexpr (kRunsCommands)
          action = [program, withoutCheck]() -> int { tools::runWithPlugin(program, !*withoutCheck); };
        else
          action = {};
      });
}

std::vector<std::string> takeProgram(std::vector<std::string>& arguments)
{
  if (arguments.empty() || arguments.front() != "run") return {};
  auto first = arguments.begin() + 1;
  while (first != arguments.end() && *first != "--" && first->rfind('-', 0) == 0) ++first;
  const auto program = first != arguments.end() && *first == "--" ? first + 1 : first;
  std::vector<std::string> taken(program, arguments.end());
  arguments.erase(first, arguments.end());
  return taken;
}

}  // namespace lamap::app
