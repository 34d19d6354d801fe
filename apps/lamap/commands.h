#pragma once

#include <CLI/CLI.hpp>
#include <exception>
#include <functional>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

namespace lamap::app
{
/** Where results go: the standard output. Nothing else does: MRPT's loggers and OctoMap write messages to
 * std::cout, which main() sends to where messages go. */
[[nodiscard]] std::ostream& results();

/** The program `lamap` consists of two parts that are made of the same sources. The program itself parses the
 * command line, and answers at once what is wrong with it or what --help and --version ask for. Only for a
 * command that is to be run, it loads the library with all that commands need, MRPT above all, which takes
 * longer than many a command: that library parses the same command line again, and runs it. */
#ifdef LAMAP_ONLY_PARSES
constexpr bool kRunsCommands = false;
#else
constexpr bool kRunsCommands = true;
#endif

/// Runs the chosen subcommand. @return the exit code. Empty where commands are only parsed
using Action = std::function<int()>;

/** Parses a command line and, where commands are run, runs its command.
 * @return the exit code; nothing where the command is yet to be run */
[[nodiscard]] std::optional<int> runCommandLine(int argc, char** argv);

// What differs between the two parts.
/// The message of an error, without what libraries add to it.
[[nodiscard]] std::string messageOf(const std::exception& error);
/// Where progress bars are drawn, which move the cursor: not through what escapes control characters.
void drawProgressOn(std::streambuf* terminal);

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
void addCompletion(CLI::App& app, Action& action);
/// @param program  what takeProgram() took from the command line
void addRun(CLI::App& app, Action& action, const std::vector<std::string>& program);

/** Removes the program and its arguments from the end of `run [--flags] [--] PROGRAM ARGUMENTS...` and
 * returns them, because CLI11 would look for its own options among them. Returns nothing if the first
 * argument is not `run`. */
[[nodiscard]] std::vector<std::string> takeProgram(std::vector<std::string>& arguments);

/// Ends the help of each command, all of which must be there, with examples.
void addExamples(CLI::App& app);

/// Exit codes beside 0.
constexpr int kFailed = 1;
constexpr int kWrongUsage = 2;
constexpr int kStopped = 130;

}  // namespace lamap::app
