// What commands share while they run.
#include <lamap_mrpt/compat/mrpt_compat.h>
#include <lamap_tools/files/point_list.h>
#include <lamap_tools/files/text_fields.h>
#include <lamap_tools/files/usage_error.h>
#include <lamap_tools/scores/score_report.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <string_view>
#include <tuple>
#include <utility>

#include "command_line.h"

namespace lamap::app
{
namespace
{
std::atomic<bool> stopAsked{false};

/// One number, which then stands for both, or two.
std::pair<double, double> oneOrTwoNumbers(const std::string& flag, const std::string& text)
{
  std::vector<double> numbers;
  for (const std::string_view field : tools::fieldsBetween(text, ","))
  {
    const auto number = tools::numberIn<double>(field);
    if (!number)
      throw tools::UsageError(flag + " " + text + ": must be a number, or two separated by a comma");
    numbers.push_back(*number);
  }
  if (numbers.size() > 2) throw tools::UsageError(flag + " " + text + ": must be at most two numbers");
  return {numbers.front(), numbers.back()};
}
}  // namespace

void prepareChoice(const ChoiceArguments& arguments, tools::ScanChoice& choice)
{
  if (!arguments.sensors.empty())
    for (const std::string_view name : tools::fieldsBetween(arguments.sensors, ","))
      choice.sensors.emplace_back(name);
  if (!arguments.from.empty()) choice.from = tools::LogTime("--from", arguments.from);
  if (!arguments.to.empty()) choice.to = tools::LogTime("--to", arguments.to);
}

void prepareInputs(const LogArguments& arguments, tools::InputOptions& inputs)
{
  if (!arguments.sensorOrigin.empty())
  {
    const auto origin = tools::parsePoint(arguments.sensorOrigin);
    inputs.sensorOrigin = {origin.x, origin.y, origin.z};
  }
  if (!arguments.pingBeam.empty())
    std::tie(inputs.pings.beamWidth_deg, inputs.pings.beamHeight_deg) =
        oneOrTwoNumbers("--ping-beam", arguments.pingBeam);
  if (!arguments.pingThreshold.empty())
    inputs.pings.threshold = oneOrTwoNumbers("--ping-threshold", arguments.pingThreshold);
  prepareChoice(arguments.choice, inputs.choice);
  catchStopSignals();
  inputs.shouldStop = stopRequested;
}

int tellDamages(bool allowTruncated, const std::vector<tools::InputReport>& inputs)
{
  if (!tools::damaged(inputs)) return 0;
  for (const tools::InputReport& input : inputs)
    for (const std::string& damage : input.damages)
      std::cerr << "lamap: " << input.path << ": cut short or damaged: " << damage << "\n";
  return allowTruncated ? 0 : kFailed;
}

std::vector<std::string> pathsRead(const tools::InputOptions& inputs, const std::vector<std::string>& others)
{
  std::vector<std::string> paths = inputs.paths;
  paths.push_back(inputs.posesPath);
  paths.insert(paths.end(), others.begin(), others.end());
  return paths;
}

void requireCurveFiles(const ScoreArguments& arguments)
{
  for (const std::string& path : arguments.paths())
    if (!path.empty()) tools::requireCurveFile(path);
}

void writeCurves(const ScoreArguments& arguments, const std::vector<tools::MapScores>& maps)
{
  if (!arguments.roc.empty()) tools::writeRocCurves(maps, arguments.roc);
  if (!arguments.calibration.empty()) tools::writeCalibration(maps, arguments.calibration);
}

namespace
{
std::ostream& terminalStream()
{
  static std::ostream stream(std::cerr.rdbuf());
  return stream;
}
}  // namespace

void catchStopSignals()
{
  struct sigaction action = {};
  action.sa_handler = [](int) { stopAsked = true; };
  action.sa_flags = SA_RESTART | static_cast<int>(SA_RESETHAND);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP})
  {
    struct sigaction before = {};
    sigaction(signal, nullptr, &before);
    const bool isForNohup = signal == SIGHUP && before.sa_handler == SIG_IGN;
    if (!isForNohup) sigaction(signal, &action, nullptr);
  }
}

bool stopRequested()
{
  return stopAsked;
}

void drawProgressOn(std::streambuf* terminal)
{
  terminalStream().rdbuf(terminal);
}

tools::ProgressBar makeProgressBar(const std::string& unit)
{
  return tools::ProgressBar(terminalStream(), isatty(STDERR_FILENO) != 0, unit);
}

int stoppedByUser(const std::string& consequence)
{
  std::cerr << "lamap: stopped by the user" << consequence << "\n";
  return kStopped;
}

std::string messageOf(const std::exception& error)
{
  return compat::messageOf(error);
}

}  // namespace lamap::app

/// What the program calls, when a command is to be run. @return the exit code
extern "C" int lamapRunCommand(int argc, char** argv)
{
  return lamap::app::runCommandLine(argc, argv).value();
}
