#pragma once

#include "commands.h"

#include <lamap_tools/inputs/scan_loop.h>
#include <lamap_tools/report/progress_bar.h>
#include <lamap_tools/scores/map_scores.h>

#include <cstdint>
#include <iostream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

// What the subcommands share: how they are described, what they read, how they end.
namespace lamap::app
{
/** Adds a subcommand whose arguments live as long as its action.
 * @param describe  adds its options
 * @param run       does it, @return the exit code
 * @param check     throws CLI::ValidationError if the options do not go together */
template <class Arguments>
void addCommand(CLI::App& app, Action& action, const std::string& name, const std::string& text,
                void (*describe)(CLI::App&, Arguments&), int (*run)(Arguments&),
                void (*check)(const CLI::App&, const Arguments&) = nullptr)
{
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(name, text);
  describe(*command, *arguments);
  command->callback(
      [&action, arguments, command, run, check]
      {
        if (check) check(*command, *arguments);
        action = [arguments, run] { return run(*arguments); };
      });
}

/// The map file that a command reads.
void addMapArgument(CLI::App& command, std::string& map);

// ---- What every command takes that reads logs and makes maps of them

struct LogArguments
{
  std::string sensorOrigin;
  bool allowTruncated = false;
};

/// Adds --poses, --sensor-origin, --static, --threads and --allow-truncated. @return these options
std::vector<CLI::Option*> addLogOptions(CLI::App& command, LogArguments& arguments,
                                        tools::InputOptions& inputs, unsigned& threads);
CLI::Option* addAllowTruncated(CLI::App& command, bool& allowTruncated);

/// To be called before the inputs are opened: from now on Ctrl-C ends the reading.
/// @throws UsageError if the sensor's origin is no point
void prepareInputs(const LogArguments& arguments, tools::InputOptions& inputs);

/// Says what could not be read of the inputs. @return the exit code that this gives
int tellDamages(bool allowTruncated, const std::vector<tools::InputReport>& inputs);

/// What a command reads: its inputs, and others.
[[nodiscard]] std::vector<std::string> pathsRead(const tools::InputOptions& inputs,
                                                 const std::vector<std::string>& others);

// ---- What every command takes that scores maps

struct ScoreArguments
{
  std::vector<double> thresholds{0.7};
  std::string roc;
  std::string calibration;

  [[nodiscard]] std::vector<std::string> paths() const { return {roc, calibration}; }
};

/// Adds --roc, --calibration and --thresholds.
void addScoreOptions(CLI::App& command, ScoreArguments& arguments);
/// Refuses files that cannot be written, before any work. @throws as requireCurveFile()
void requireCurveFiles(const ScoreArguments& arguments);
void writeCurves(const ScoreArguments& arguments, const std::vector<tools::MapScores>& maps);

// ---- Legal values

/// For an option of an enumeration's type: one of the words that name its values, in any case.
[[nodiscard]] CLI::Validator wordToNumber(std::map<std::string, int> words);
template <typename Enumeration>
[[nodiscard]] CLI::Validator oneOf(const std::map<std::string, Enumeration>& words)
{
  std::map<std::string, int> numbers;
  for (const auto& [word, value] : words) numbers.emplace(word, static_cast<int>(value));
  return wordToNumber(std::move(numbers));
}

/// A whole number between limits that are legal themselves.
[[nodiscard]] CLI::Validator wholeNumber(int64_t low, int64_t high);

/// For every Nth of something.
constexpr int64_t kMostEvery = 1'000'000'000;

// ---- How a command runs and ends

/// From now on SIGINT and SIGTERM ask for a stop, which stopRequested() tells; a second one ends the program
/// at once.
void catchStopSignals();
[[nodiscard]] bool stopRequested();

/// Where a progress bar is drawn.
[[nodiscard]] tools::ProgressBar makeProgressBar(const std::string& unit = "scans");

/// Does a long work, which tells a progress bar how far it is.
template <class Work>
auto withProgressBar(const Work& work, const std::string& unit = "scans")
{
  tools::ProgressBar bar = makeProgressBar(unit);
  return work(tools::ProgressSink([&](const tools::Progress& progress) { bar.show(progress); }));
}

/// Says that the user stopped it, and what becomes of the work. @return the exit code
int stoppedByUser(const std::string& consequence);

inline void print(const nlohmann::ordered_json& json)
{
  std::cout << json.dump(2) << "\n";
}

}  // namespace lamap::app
