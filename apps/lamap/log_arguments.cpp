#include "log_arguments.h"

#include <lamap_tools/cells/query_map.h>
#include <unistd.h>

#include <iostream>

#include "commands.h"
#include "legal_values.h"
#include "stop_request.h"

namespace lamap::app
{
std::vector<CLI::Option*> addLogOptions(CLI::App& command, LogArguments& arguments,
                                        tools::InputOptions& inputs, unsigned& threads)
{
  return {command.add_option(
              "--poses", inputs.posesPath,
              "Poses in place of the log's (TUM format or MRPT's path text); for PCD files one a file"),
          command.add_option("--sensor-origin", arguments.sensorOrigin,
                             "x,y,z of the sensor in the frame of a PCD file's VIEWPOINT [m]"),
          command.add_flag("--static", inputs.standingStill,
                           "For rawlogs: the robot stood at the origin all the time"),
          command.add_option("--threads", threads, "How many threads; 0: as many as the machine has")
              ->check(wholeNumber(0, kMostThreads)),
          command.add_flag("--allow-truncated", arguments.allowTruncated,
                           "A log that was cut short is no failure")};
}

void prepareInputs(const LogArguments& arguments, tools::InputOptions& inputs)
{
  if (!arguments.sensorOrigin.empty())
  {
    const auto origin = tools::parsePoint(arguments.sensorOrigin);
    inputs.sensorOrigin = {origin.x, origin.y, origin.z};
  }
  catchStopSignals();
  inputs.shouldStop = stopRequested;
}

int tellDamages(const LogArguments& arguments, const std::vector<tools::InputReport>& inputs)
{
  if (!tools::damaged(inputs)) return 0;
  for (const tools::InputReport& input : inputs)
    for (const std::string& damage : input.damages)
      std::cerr << "lamap: " << input.path << ": cut short or damaged: " << damage << "\n";
  return arguments.allowTruncated ? 0 : kFailed;
}

std::vector<std::string> pathsRead(const tools::InputOptions& inputs, const std::vector<std::string>& others)
{
  std::vector<std::string> paths = inputs.paths;
  paths.push_back(inputs.posesPath);
  paths.insert(paths.end(), others.begin(), others.end());
  return paths;
}

bool isTerminal()
{
  return isatty(STDERR_FILENO) != 0;
}

}  // namespace lamap::app
