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
/// How a program ended, and its output.
struct Outcome
{
  std::optional<int> exitCode;  ///< empty if a signal ended it
  bool timedOut = false;        ///< the signal was ours
  std::string output;           ///< standard output and standard error as they came

  [[nodiscard]] bool succeeded() const { return exitCode == 0; }
};

/// Standard input of a program.
enum class Keys
{
  None,     ///< empty, so that "Press any key" does not wait
  Terminal  ///< a terminal without a user
};

/// A program with its own process group, started on construction; what remains of the group is killed at the
/// end.
class Program
{
 public:
  using Environment = std::vector<std::pair<std::string, std::string>>;

  /// @param command found through PATH. @param folder its working folder. @throws std::runtime_error if it
  /// cannot be started
  Program(const std::vector<std::string>& command, const std::filesystem::path& folder,
          const Environment& environment = {}, Keys keys = Keys::None);
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  [[nodiscard]] bool isRunning();
  /// Waits until it ends, or ends it after the time limit.
  Outcome wait(std::chrono::seconds timeout);
  /// Ends it; for programs with windows, which do not end on their own.
  Outcome stop();
  /// Its output so far.
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

/// Paths of the plug-in, of the tool, and of a ready-made configuration.
std::string pluginFile();
std::string lamapTool();
std::string configFile(const std::string& name);

/// Whether a program is in PATH.
bool isInstalled(const std::string& program);

/// A file of the Debian package mrpt-common; empty if it is not installed.
std::optional<std::string> dataset(const std::string& name);

/// Evaluates a condition every 0.1 s. @return whether it became true in time.
bool becomes(const std::function<bool()>& question, std::chrono::seconds timeout);

/// An empty folder for this test, made anew for each run and kept afterwards for inspection.
std::filesystem::path freshFolder();

std::string readFile(const std::filesystem::path& path);
void writeFile(const std::filesystem::path& path, const std::string& text);

#define SKIP_WITHOUT_PROGRAM(name) \
  if (!lamap::test::isInstalled(name)) GTEST_SKIP() << name << " is not installed"
#define SKIP_WITHOUT_DATASET(name) \
  if (!lamap::test::dataset(name)) \
  GTEST_SKIP() << name << " of the Debian package mrpt-common is not installed"

}  // namespace lamap::test
