#include "stop_request.h"

#include <atomic>
#include <csignal>

namespace lamap::app
{
namespace
{
std::atomic<bool> requested{false};
}  // namespace

void catchStopSignals()
{
  struct sigaction action = {};
  action.sa_handler = [](int) { requested = true; };
  action.sa_flags = SA_RESTART | static_cast<int>(SA_RESETHAND);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

bool stopRequested()
{
  return requested;
}

}  // namespace lamap::app
