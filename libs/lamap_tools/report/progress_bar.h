#pragma once

#include <chrono>
#include <functional>
#include <ostream>
#include <string>

namespace lamap::tools
{
/// The progress of a command.
struct Progress
{
  size_t done = 0;
  size_t expected = 0;  ///< 0: not known
  std::string input;    ///< path of the one that is being read
};
using ProgressSink = std::function<void(const Progress&)>;

/** Shows the progress of a long task: a bar on a terminal, otherwise a line from time to time. */
class ProgressBar
{
 public:
  using Clock = std::chrono::steady_clock;

  /// @param unit what is counted, in the singular
  ProgressBar(std::ostream& out, bool isTerminal, std::string unit = "scan")
      : out_(out), isTerminal_(isTerminal), unit_(std::move(unit))
  {
  }
  /// Ends the line of a bar on the terminal.
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// Draws if enough time has passed since the last time, or at the end.
  void show(const Progress& progress, Clock::time_point now = Clock::now());

 private:
  std::ostream& out_;
  bool isTerminal_;
  std::string unit_;
  bool started_ = false;
  bool drawn_ = false;
  Clock::time_point begin_;
  Clock::time_point lastDrawn_;
};

/// "1:02:03", "2:03".
[[nodiscard]] std::string durationText(double seconds);

}  // namespace lamap::tools
