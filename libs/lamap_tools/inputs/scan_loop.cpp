#include <lamap_tools/files/text_fields.h>
#include <lamap_tools/inputs/scan_loop.h>

#include <algorithm>

namespace lamap::tools
{
namespace
{
std::string namesOf(const std::vector<std::unique_ptr<ScanSource>>& sources)
{
  std::vector<std::string> paths;
  for (const auto& source : sources) paths.push_back(source->path());
  return firstFewOf(paths);
}

void requireChosen(const std::vector<std::unique_ptr<ScanSource>>& sources)
{
  if (sources.empty() || !sources.front()->chooser()) return;
  sources.front()->chooser()->requireTaken(namesOf(sources));
}
}  // namespace

bool visitScans(const std::vector<std::unique_ptr<ScanSource>>& sources,
                const std::function<bool()>& shouldStop, const ProgressSink& report,
                const ScanVisitor& visitor)
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
      visitor(*item, *source);
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
  for (const auto& source : sources)
  {
    reports.push_back({source->path(), source->notes(), source->damages()});
    std::vector<std::string>& notes = reports.back().notes;
    notes.insert(notes.end(), source->readingNotes().begin(), source->readingNotes().end());
  }
  if (sources.size() == 1 && sources.front()->chooser())
    reports.front().notes.push_back(sources.front()->chooser()->summary());
  return reports;
}

std::vector<std::string> jointNotesOf(const std::vector<std::unique_ptr<ScanSource>>& sources)
{
  std::vector<std::string> notes;
  for (const auto& source : sources)
    notes.insert(notes.end(), source->jointNotes().begin(), source->jointNotes().end());
  if (sources.size() > 1 && sources.front()->chooser())
    notes.push_back(namesOf(sources) + ": " + sources.front()->chooser()->summary());
  return notes;
}

std::vector<std::string> allNotesOf(const std::vector<std::unique_ptr<ScanSource>>& sources)
{
  std::vector<std::string> notes;
  for (const InputReport& input : reportsOf(sources))
    for (const std::string& note : input.notes) notes.push_back(input.path + ": " + note);
  const std::vector<std::string> joint = jointNotesOf(sources);
  notes.insert(notes.end(), joint.begin(), joint.end());
  return notes;
}

}  // namespace lamap::tools
