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
 * @tparam run      runs it and returns the exit code. A parameter of the template, so that a program that
 * only parses does not contain it.
 * @param describe  adds its options
 * @param check     throws CLI::ValidationError if the options do not go together */
template <class Arguments, int (*run)(Arguments&)>
void addCommand(CLI::App& app, Action& action, const std::string& name, const std::string& text,
                void (*describe)(CLI::App&, Arguments&),
                void (*check)(const CLI::App&, const Arguments&) = nullptr)
{
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(name, text);
  describe(*command, *arguments);
  command->callback(
      [&action, arguments, command, check]
      {
        if (check) check(*command, *arguments);
        if constexpr (kRunsCommands)
          action = [arguments] { return run(*arguments); };
        else
          action = {};
      });
}

/// The map file that a command reads.
void addMapArgument(CLI::App& command, std::string& map);

// ---- For commands that read logs

struct ChoiceArguments
{
  std::string sensors;
  std::string from;
  std::string to;
};

struct LogArguments
{
  ChoiceArguments choice;
  std::string sensorOrigin;
  std::string pingBeam;
  std::string pingThreshold;
  bool allowTruncated = false;
};

/// Adds --sensors, --every, --from and --to. @return these options
std::vector<CLI::Option*> addChoiceOptions(CLI::App& command, ChoiceArguments& arguments,
                                           tools::ScanChoice& choice);
/// Adds --poses, --sensor-origin, --cloud-frame, --static, those that choose from a log, and
/// --allow-truncated.
/// @return these options
std::vector<CLI::Option*> addInputOptions(CLI::App& command, LogArguments& arguments,
                                          tools::InputOptions& inputs);
/// Adds those and --threads. @return all these options
std::vector<CLI::Option*> addLogOptions(CLI::App& command, LogArguments& arguments,
                                        tools::InputOptions& inputs, unsigned& threads);
CLI::Option* addAllowTruncated(CLI::App& command, bool& allowTruncated);

/// Call before the inputs are opened: from then on, Ctrl-C ends the reading.
/// @throws UsageError if the sensor's origin is not a point, or a time is illegal
void prepareInputs(const LogArguments& arguments, tools::InputOptions& inputs);

/// @throws UsageError if a time is illegal
void prepareChoice(const ChoiceArguments& arguments, tools::ScanChoice& choice);

/// Reports what could not be read of the inputs. @return the resulting exit code
int tellDamages(bool allowTruncated, const std::vector<tools::InputReport>& inputs);

/// All files that a command reads: its inputs, and others.
[[nodiscard]] std::vector<std::string> pathsRead(const tools::InputOptions& inputs,
                                                 const std::vector<std::string>& others);

// ---- For commands that score maps

struct ScoreArguments
{
  std::vector<double> thresholds{0.7};
  std::string roc;
  std::string calibration;

  [[nodiscard]] std::vector<std::string> paths() const { return {roc, calibration}; }
};

/// Adds --roc, --calibration and --thresholds.
void addScoreOptions(CLI::App& command, ScoreArguments& arguments);
/// Refuses, before any work, files of a kind that cannot be written. @throws as requireCurveFile()
void requireCurveFiles(const ScoreArguments& arguments);
void writeCurves(const ScoreArguments& arguments, const std::vector<tools::MapScores>& maps);

// ---- Legal values

/// For an option that is an enumeration: one of the words for its values, in upper or lower case.
[[nodiscard]] CLI::Validator wordToNumber(std::map<std::string, int> words);
/// @return the words of such a validator; none of another one
[[nodiscard]] std::vector<std::string> legalWords(const CLI::Validator& validator);
template <typename Enumeration>
[[nodiscard]] CLI::Validator oneOf(const std::map<std::string, Enumeration>& words)
{
  std::map<std::string, int> numbers;
  for (const auto& [word, value] : words) numbers.emplace(word, static_cast<int>(value));
  return wordToNumber(std::move(numbers));
}

/// A whole number between two limits, inclusive.
[[nodiscard]] CLI::Validator wholeNumber(int64_t low, int64_t high);

/// A length in metres, above 0.
[[nodiscard]] CLI::Validator lengthAboveZero();

/// The largest N in "every Nth".
constexpr int64_t kMostEvery = 1'000'000'000;

// ---- How a command runs and ends

/// After this, SIGINT, SIGTERM or SIGHUP, unless it is ignored, makes stopRequested() true; a second one ends
/// the program at once.
void catchStopSignals();
[[nodiscard]] bool stopRequested();

/// A progress bar on the standard error output.
[[nodiscard]] tools::ProgressBar makeProgressBar(const std::string& unit = "scan");

/// Runs a long task with a progress bar.
template <class Work>
auto withProgressBar(const Work& work, const std::string& unit = "scan")
{
  tools::ProgressBar bar = makeProgressBar(unit);
  return work(tools::ProgressSink([&](const tools::Progress& progress) { bar.show(progress); }));
}

/// Reports that the user stopped the command, and the consequence. @return the exit code
int stoppedByUser(const std::string& consequence);

inline void print(const nlohmann::ordered_json& json)
{
  results() << json.dump(2) << "\n";
}

}  // namespace lamap::app
