#pragma once

#include <lamap_tools/map_build.h>

#include <chrono>
#include <ostream>

namespace lamap::tools
{
/** Shows how far a build is: on a terminal a bar that is redrawn, elsewhere a line from time to time. */
class ProgressBar
{
 public:
  using Clock = std::chrono::steady_clock;

  ProgressBar(std::ostream& out, bool isTerminal) : out_(out), isTerminal_(isTerminal) {}
  /// Ends a bar that stands on the terminal.
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// Draws if enough time has passed since it last did, or at the end.
  void show(const BuildProgress& progress, Clock::time_point now = Clock::now());

 private:
  std::ostream& out_;
  bool isTerminal_;
  bool started_ = false;
  bool drawn_ = false;
  Clock::time_point begin_;
  Clock::time_point lastDrawn_;
};

/// "1:02:03", "2:03".
[[nodiscard]] std::string durationText(double seconds);

}  // namespace lamap::tools
