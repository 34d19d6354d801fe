#pragma once

#include <lamap_tools/commands/map_build.h>

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace lamap::app
{
/// What every command takes that reads logs and makes maps of them.
struct LogArguments
{
  std::string sensorOrigin;
  bool allowTruncated = false;
};

/// Adds --poses, --sensor-origin, --static, --threads and --allow-truncated. @return these options
std::vector<CLI::Option*> addLogOptions(CLI::App& command, LogArguments& arguments,
                                        tools::InputOptions& inputs, unsigned& threads);

/// To be called before the inputs are opened: from now on Ctrl-C ends the reading.
/// @throws UsageError if the sensor's origin is no point
void prepareInputs(const LogArguments& arguments, tools::InputOptions& inputs);

/// Says what could not be read of the inputs. @return the exit code that this gives
int tellDamages(const LogArguments& arguments, const std::vector<tools::InputReport>& inputs);

/// What a command reads: its inputs, and others.
[[nodiscard]] std::vector<std::string> pathsRead(const tools::InputOptions& inputs,
                                                 const std::vector<std::string>& others);

/// Whether a progress bar can be drawn.
[[nodiscard]] bool isTerminal();

}  // namespace lamap::app
