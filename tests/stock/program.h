#pragma once

#include <sys/types.h>
#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace lamap::test
{
/// How a program ended, and all it printed.
struct Outcome
{
  std::optional<int> exitCode;  ///< nothing if a signal ended it
  bool timedOut = false;        ///< that signal was ours
  std::string output;           ///< standard output and standard error as they came

  [[nodiscard]] bool succeeded() const { return exitCode == 0; }
};

/// What a program reads keys from.
enum class Keys
{
  None,     ///< at its end, so that "Press any key" does not wait
  Terminal  ///< one at which nobody sits
};

/// A program with its own process group, started at once; whatever is left of the group is killed in the end.
class Program
{
 public:
  using Environment = std::vector<std::pair<std::string, std::string>>;

  /// @param command looked up in PATH. @param folder where it runs. @throws std::runtime_error if it cannot
  /// be started
  Program(const std::vector<std::string>& command, const std::filesystem::path& folder,
          const Environment& environment = {}, Keys keys = Keys::None);
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  [[nodiscard]] bool isRunning();
  /// Waits until it ends, or ends it when the time is over.
  Outcome wait(std::chrono::seconds timeout);
  /// Ends it; for programs with windows, which nobody closes.
  Outcome stop();
  /// What it has printed so far.
  [[nodiscard]] std::string output() const;

 private:
  bool reap();

  pid_t pid_ = -1;
  int terminal_ = -1;
  std::optional<int> status_;
  std::filesystem::path outputFile_;
};

/// Runs a program to its end.
Outcome run(const std::vector<std::string>& command, const std::filesystem::path& folder,
            std::chrono::seconds timeout = std::chrono::seconds(180),
            const Program::Environment& environment = {});

/// `lamap run -- command…`
std::vector<std::string> withPlugin(const std::vector<std::string>& command);

/// Path of the plug-in, of the tool, and of a ready configuration.
std::string pluginFile();
std::string lamapTool();
std::string configFile(const std::string& name);

/// Whether a program stands in PATH.
bool isInstalled(const std::string& program);

/// A file of the Debian package mrpt-common; nothing if it is not installed.
std::optional<std::string> dataset(const std::string& name);

/// Calls a question every 0.1 s. @return whether its answer became yes in time.
bool becomes(const std::function<bool()>& question, std::chrono::seconds timeout);

/// An empty folder of this test, removed before it is made again, left for looking at afterwards.
std::filesystem::path freshFolder();

std::string readFile(const std::filesystem::path& path);
void writeFile(const std::filesystem::path& path, const std::string& text);

#define SKIP_WITHOUT_PROGRAM(name) \
  if (!lamap::test::isInstalled(name)) GTEST_SKIP() << name << " is not installed"
#define SKIP_WITHOUT_DATASET(name) \
  if (!lamap::test::dataset(name)) \
  GTEST_SKIP() << name << " of the Debian package mrpt-common is not installed"

}  // namespace lamap::test
