#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <ostream>
#include <string>
#include <vector>

namespace lamap::app
{
/** Where results go: the standard output. Nothing else does: MRPT's loggers and OctoMap write messages to
 * std::cout, which main() sends to where messages go. */
[[nodiscard]] std::ostream& results();

/// Runs the chosen subcommand. @return the exit code
using Action = std::function<int()>;

// One function per subcommand: adds it, and sets the action if it is chosen.
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

/** Removes the program and its arguments from the end of `run [--flags] [--] PROGRAM ARGUMENTS...` and
 * returns them, because CLI11 would look for its own options among them. Returns nothing if the first
 * argument is not `run`. */
[[nodiscard]] std::vector<std::string> takeProgram(std::vector<std::string>& arguments);

/// Exit codes beside 0.
constexpr int kFailed = 1;
constexpr int kWrongUsage = 2;
constexpr int kStopped = 130;

}  // namespace lamap::app
