#include <lamap_tools/commands/thin_log.h>
#include <lamap_tools/files/output_paths.h>

#include "command_line.h"

namespace lamap::app
{
namespace
{
struct ThinArguments
{
  tools::ThinOptions options;
  ChoiceArguments choice;
  bool allowTruncated = false;
};

void describe(CLI::App& command, ThinArguments& arguments)
{
  tools::ThinOptions& options = arguments.options;
  command.add_option("-i,--input", options.inPath, "The log: .rawlog, .simplemap or .simplemap.gz")
      ->required();
  command.add_option("-o,--output", options.outPath, "Where to save it; must be the same kind of log")
      ->required();
  command.add_option("--keep-every", options.every, "Keep every Nth ray of each 2D scan and point cloud")
      ->check(wholeNumber(1, kMostEvery));
  addChoiceOptions(command, arguments.choice, options.choice);
  addAllowTruncated(command, arguments.allowTruncated);
}

void check(const CLI::App& command, const ThinArguments& /*arguments*/)
{
  for (const char* flag : {"--keep-every", "--sensors", "--every", "--from", "--to"})
    if (command.count(flag) > 0) return;
  throw CLI::ValidationError("thin",
                             "give --keep-every N, or what to keep: --sensors, --every, --from, --to");
}

int thin(ThinArguments& arguments)
{
  tools::ThinOptions& options = arguments.options;
  tools::requireOwnPlaces({options.outPath}, {options.inPath});
  prepareChoice(arguments.choice, options.choice);
  catchStopSignals();
  options.shouldStop = stopRequested;
  const tools::ThinReport report =
      withProgressBar([&](const auto& progress) { return tools::thinLog(options, progress); }, "entry");
  if (report.stopped) return stoppedByUser("; nothing is saved");
  tools::printReport(report, options, results());
  std::vector<std::string> damages;
  if (report.damage) damages.push_back(*report.damage);
  return tellDamages(arguments.allowTruncated, {{options.inPath, {}, damages}});
}
}  // namespace

void addThin(CLI::App& app, Action& action)
{
  addCommand<ThinArguments, thin>(app, action, "thin",
                                  "Rewrite a log as if its sensors had fewer beams, or a part of it",
                                  describe, check);
}

}  // namespace lamap::app
