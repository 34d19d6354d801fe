#include "commands.h"

#include <lamap_tools/commands/progress_bar.h>
#include <lamap_tools/commands/thin_log.h>
#include <lamap_tools/files/output_paths.h>

#include <iostream>
#include <memory>

#include "legal_values.h"
#include "log_arguments.h"
#include "stop_request.h"

namespace lamap::app
{
namespace
{
struct ThinArguments
{
  tools::ThinOptions options;
  bool allowTruncated = false;
};

int thin(ThinArguments arguments)
{
  tools::requireOwnPlaces({arguments.options.outPath}, {arguments.options.inPath});
  catchStopSignals();
  arguments.options.shouldStop = stopRequested;
  tools::ThinReport report;
  {
    tools::ProgressBar bar(std::cerr, isTerminal(), "entries");
    report =
        tools::thinLog(arguments.options, [&](const tools::BuildProgress& progress) { bar.show(progress); });
  }
  if (report.stopped)
  {
    std::cerr << "lamap: stopped by the user; nothing is saved\n";
    return kStopped;
  }
  tools::printReport(report, arguments.options, std::cout);
  if (!report.damage) return 0;
  std::cerr << "lamap: " << arguments.options.inPath << ": cut short or damaged: " << *report.damage << "\n";
  return arguments.allowTruncated ? 0 : kFailed;
}
}  // namespace

void addThin(CLI::App& app, Action& action)
{
  auto arguments = std::make_shared<ThinArguments>();
  CLI::App* command =
      app.add_subcommand("thin", "Write a log again as a sensor with fewer beams would have taken it");
  tools::ThinOptions& options = arguments->options;
  command->add_option("-i,--input", options.inPath, "The log: .rawlog, .simplemap or .simplemap.gz")
      ->required();
  command->add_option("-o,--output", options.outPath, "Where to save, the same kind of log")->required();
  command
      ->add_option("--keep-every", options.every,
                   "Of each 2D scan and point cloud, every so many-th ray is kept")
      ->required()
      ->check(wholeNumber(1, 1000000000));
  command->add_flag("--allow-truncated", arguments->allowTruncated, "A log that was cut short is no failure");
  command->callback([&action, arguments] { action = [arguments] { return thin(*arguments); }; });
}

}  // namespace lamap::app
