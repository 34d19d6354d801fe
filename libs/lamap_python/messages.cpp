#include <lamap_python/messages.h>
#include <pybind11/pybind11.h>

#include <string_view>

namespace py = pybind11;

namespace lamap::python
{
namespace
{
thread_local Messages* listening = nullptr;

int pythonLevel(mrpt::system::VerbosityLevel level)
{
  switch (level)
  {
    case mrpt::system::LVL_INFO:
      return 20;
    case mrpt::system::LVL_WARN:
      return 30;
    case mrpt::system::LVL_ERROR:
      return 40;
    default:
      return 10;
  }
}
}  // namespace

CollectedMessages::CollectedMessages(Messages& messages) : before_(listening)
{
  listening = &messages;
}

CollectedMessages::~CollectedMessages()
{
  listening = before_;
}

void redirectMessages(mrpt::system::COutputLogger& map)
{
  if (!map.logging_enable_console_output) return;  // a copy of one that is redirected already
  map.logging_enable_console_output = false;
  map.logRegisterCallback(
      [](std::string_view text, mrpt::system::VerbosityLevel level, std::string_view /*logger*/,
         mrpt::Clock::time_point /*time*/)
      {
        if (listening != nullptr) listening->emplace_back(pythonLevel(level), std::string(text));
      });
}

void logMessages(const Messages& messages)
{
  if (messages.empty()) return;
  const py::object logger = py::module_::import("logging").attr("getLogger")("lamap");
  for (const auto& [level, text] : messages) logger.attr("log")(level, "%s", text);
}

}  // namespace lamap::python
