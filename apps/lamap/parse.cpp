#include "command_line.h"
#include "commands.h"

#include <lamap_core/options/nearest_name.h>
#include <lamap_tools/files/text_fields.h>
#include <lamap_tools/files/usage_error.h>
#include <lamap_tools/report/printable_output.h>

#include <algorithm>
#include <iostream>
#include <new>
#include <string>
#include <vector>

namespace
{
int fail(int code, const std::string& what)
{
  std::cerr << "lamap: " << what << "\n";
  return code;
}

/// CLI11 would say only that a subcommand is required.
void requireSubcommand(const CLI::App& app, const std::vector<std::string>& arguments)
{
  const std::string name = arguments.empty() ? "" : arguments.front();
  if (name.rfind('-', 0) == 0) return;
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  if (std::find(names.begin(), names.end(), name) != names.end()) return;
  throw lamap::tools::UsageError(
      (name.empty() ? "which subcommand? There are: " + lamap::tools::joined(names)
                    : "'" + name + "' is not a subcommand; " + lamap::suggestionFor(name, names)) +
      ". `lamap --help` describes them");
}

/// While it lives, what libraries print to std::cout goes to where messages go.
class LibraryOutput
{
 public:
  LibraryOutput() : before_(std::cout.rdbuf(std::cerr.rdbuf())) {}
  ~LibraryOutput() { std::cout.rdbuf(before_); }
  LibraryOutput(const LibraryOutput&) = delete;
  LibraryOutput& operator=(const LibraryOutput&) = delete;

 private:
  std::streambuf* before_;
};

/// A full disk shows only now. @return the exit code of a command that would end with this one
int withOutputWritten(int code)
{
  std::ostream& results = lamap::app::results();
  results.flush();
  if (results || code != 0) return code;
  return fail(lamap::app::kFailed, "the standard output did not take all that was written to it");
}
}  // namespace

std::ostream& lamap::app::results()
{
  static std::ostream stream(std::cout.rdbuf());
  return stream;
}

std::optional<int> lamap::app::runCommandLine(int argc, char** argv)
{
  const lamap::tools::PrintableOutput printable(results());
  const lamap::tools::PrintableOutput messages(std::cerr);
  const LibraryOutput ofLibraries;
  drawProgressOn(messages.terminal());
  CLI::App app{"Learned 3D occupancy maps: build them from logs, inspect, score and export them", "lamap"};
  app.set_version_flag("--version", LAMAP_VERSION);
  app.require_subcommand(1);
  Action action;
  addBuild(app, action);
  addCompare(app, action);
  addInfo(app, action);
  addQuery(app, action);
  addEval(app, action);
  addExport(app, action);
  addRender(app, action);
  addSimulate(app, action);
  addThin(app, action);
  addTune(app, action);
  addCompletion(app, action);
  std::vector<std::string> arguments(argv + 1, argv + argc);
  addRun(app, action, takeProgram(arguments));
  addExamples(app);
  try
  {
    requireSubcommand(app, arguments);
    app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
    if (!kRunsCommands) return std::nullopt;
    return withOutputWritten(action());
  }
  catch (const CLI::Success& success)
  {
    return withOutputWritten(app.exit(success, results(), std::cerr));  // --help, --version
  }
  catch (const CLI::ParseError& error)
  {
    const bool hasCommand = !arguments.empty() && arguments.front().rfind('-', 0) != 0;
    const std::string command = hasCommand ? " " + arguments.front() : "";
    return fail(kWrongUsage, std::string(error.what()) + "; see `lamap" + command + " --help`");
  }
  catch (const lamap::tools::UsageError& error)
  {
    return fail(kWrongUsage, error.what());
  }
  catch (const std::bad_alloc&)
  {
    return fail(kFailed, "not enough memory");
  }
  catch (const std::exception& error)
  {
    return fail(kFailed, messageOf(error));
  }
}
