#include <lamap_tools/report/counted.h>
#include <lamap_tools/report/progress_bar.h>
#include <mrpt/core/format.h>

#include <algorithm>
#include <cmath>

namespace lamap::tools
{
namespace
{
std::string barText(double share)
{
  constexpr size_t kWidth = 24;
  const auto filled = static_cast<size_t>(std::floor(std::min(share, 1.0) * static_cast<double>(kWidth)));
  return "[" + std::string(filled, '#') + std::string(kWidth - filled, '.') + "]";
}
}  // namespace

std::string durationText(double seconds)
{
  const auto whole = static_cast<long long>(std::llround(std::max(0.0, seconds)));
  if (whole < 3600) return mrpt::format("%lld:%02lld", whole / 60, whole % 60);
  return mrpt::format("%lld:%02lld:%02lld", whole / 3600, whole / 60 % 60, whole % 60);
}

ProgressBar::~ProgressBar()
{
  if (isTerminal_ && drawn_) out_ << "\n" << std::flush;
}

void ProgressBar::show(const Progress& progress, Clock::time_point now)
{
  if (!started_)
  {
    started_ = true;
    begin_ = lastDrawn_ = now;
  }
  const bool known = progress.expected > 0;  // the total
  const bool atEnd = known && progress.done >= progress.expected;
  const auto pause = isTerminal_ ? std::chrono::milliseconds(100) : std::chrono::seconds(10);
  const bool atBegin = isTerminal_ && !drawn_;
  // Without a terminal, no line at the end: the final report follows at once.
  if (!atBegin && now - lastDrawn_ < pause && !(isTerminal_ && atEnd)) return;
  lastDrawn_ = now;
  drawn_ = true;

  const double seconds = std::chrono::duration<double>(now - begin_).count();
  const double rate = seconds > 0 ? static_cast<double>(progress.done) / seconds : 0;
  std::string text = known ? std::to_string(progress.done) + " of " + counted(progress.expected, unit_)
                           : counted(progress.done, unit_);
  if (rate > 0 && !known) text += mrpt::format(", %.1f per second", rate);
  if (rate > 0 && known)
  {
    const double left =
        static_cast<double>(progress.expected - std::min(progress.done, progress.expected)) / rate;
    text += mrpt::format(", %.1f per second, %s left", rate, durationText(left).c_str());
  }
  if (isTerminal_)
  {
    const double share =
        known ? static_cast<double>(progress.done) / static_cast<double>(progress.expected) : 0;
    out_ << "\r" << (known ? barText(share) + " " : "") << text << "\x1b[K" << std::flush;
  }
  else
    out_ << text << std::endl;
}

}  // namespace lamap::tools
