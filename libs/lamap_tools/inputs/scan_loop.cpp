#include <lamap_tools/files/text_fields.h>
#include <lamap_tools/inputs/scan_loop.h>

#include <algorithm>

namespace lamap::tools
{
namespace
{
void requireChosen(const std::vector<std::unique_ptr<ScanSource>>& sources)
{
  if (sources.empty() || !sources.front()->chooser()) return;
  std::vector<std::string> paths;
  for (const auto& source : sources) paths.push_back(source->path());
  sources.front()->chooser()->requireTaken(joined(paths));
}
}  // namespace

bool visitScans(const std::vector<std::unique_ptr<ScanSource>>& sources,
                const std::function<bool()>& shouldStop, const ProgressSink& report,
                const std::function<void(const ScanItem&)>& visitor)
{
  Progress progress;
  for (const auto& source : sources) progress.expected += source->expectedItems();
  size_t before = 0;
  for (const auto& source : sources)
  {
    progress.input = source->path();
    while (!shouldStop())
    {
      const auto item = source->next();
      if (!item) break;
      visitor(*item);
      progress.done = before + source->readItems();
      if (report) report(progress);
    }
    if (shouldStop()) return false;
    before += source->readItems();
  }
  requireChosen(sources);
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
  // The choice counts through all inputs, so it is told with the last one.
  if (!reports.empty() && sources.back()->chooser())
    reports.back().notes.push_back(sources.back()->chooser()->summary());
  return reports;
}

}  // namespace lamap::tools
