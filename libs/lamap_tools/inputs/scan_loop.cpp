#include <lamap_tools/inputs/scan_loop.h>

#include <algorithm>

namespace lamap::tools
{
bool visitScans(const std::vector<std::unique_ptr<ScanSource>>& sources,
                const std::function<bool()>& shouldStop, const ProgressSink& report,
                const std::function<void(const ScanItem&)>& visitor)
{
  Progress progress;
  for (const auto& source : sources) progress.expected += source->expectedItems();
  for (const auto& source : sources)
  {
    progress.input = source->path();
    while (!shouldStop())
    {
      const auto item = source->next();
      if (!item) break;
      visitor(*item);
      ++progress.done;
      if (report) report(progress);
    }
    if (shouldStop()) return false;
  }
  return true;
}

bool damaged(const std::vector<InputReport>& inputs)
{
  return std::any_of(inputs.begin(), inputs.end(),
                     [](const InputReport& input) { return !input.damages.empty(); });
}

std::vector<InputReport> reportsOf(const std::vector<std::unique_ptr<ScanSource>>& sources)
{
  std::vector<InputReport> reports;
  reports.reserve(sources.size());
  for (const auto& source : sources) reports.push_back({source->path(), source->notes(), source->damages()});
  return reports;
}

}  // namespace lamap::tools
