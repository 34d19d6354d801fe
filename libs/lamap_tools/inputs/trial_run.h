#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace lamap::tools
{
/// How an attempt in a child process went.
struct TrialRun
{
  uint64_t steps = 0;                  ///< that it had done when it ended
  std::optional<std::string> failure;  ///< why it did not come to its end; nothing if it did
  bool stopped = false;                ///< because it was asked to
  std::vector<uint8_t> found;          ///< what the attempt returned, if it came to its end
};

/** Tries in a copy of this process what might crash it, hang or take all memory, such as reading a damaged
 * file with MRPT, whose readers trust what they read: a wrong length or type can make them write where they
 * must not.
 *
 * The attempt calls `step` as it goes on. It counts as failed when it dies of a signal, ends with an
 * exception, or does not take a step for a minute. Nothing it does but that count and what it returns reaches
 * this process.
 * @throws std::runtime_error if the system gives no process */
[[nodiscard]] TrialRun tryInChild(
    const std::function<std::vector<uint8_t>(const std::function<void()>& step)>& attempt,
    const std::function<bool()>& shouldStop);

}  // namespace lamap::tools
