#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

namespace lamap::app
{
/// What a chosen subcommand does. @return the exit code
using Action = std::function<int()>;

// One function per subcommand: describes it, and sets the action when it was chosen.
void addBuild(CLI::App& app, Action& action);
void addCompare(CLI::App& app, Action& action);
void addInfo(CLI::App& app, Action& action);
void addQuery(CLI::App& app, Action& action);
void addEval(CLI::App& app, Action& action);
void addExport(CLI::App& app, Action& action);
void addRender(CLI::App& app, Action& action);
void addSimulate(CLI::App& app, Action& action);
void addThin(CLI::App& app, Action& action);
void addTune(CLI::App& app, Action& action);
/// @param program  what takeProgram() took from the command line
void addRun(CLI::App& app, Action& action, const std::vector<std::string>& program);

/** Takes the program to run, and its arguments, off the end of `run [--flags] [--] PROGRAM ARGUMENTS...`:
 * CLI11 would look for its own options among them. Takes nothing where the first argument is not `run`. */
[[nodiscard]] std::vector<std::string> takeProgram(std::vector<std::string>& arguments);

/// Exit codes beside 0.
constexpr int kFailed = 1;
constexpr int kWrongUsage = 2;
constexpr int kStopped = 130;

}  // namespace lamap::app
