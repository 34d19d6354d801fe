#include <lamap_tools/commands/held_out.h>
#include <lamap_tools/commands/scored_map.h>
#include <lamap_tools/files/text_fields.h>
#include <lamap_tools/files/usage_error.h>
#include <lamap_tools/report/counted.h>
#include <lamap_tools/scores/held_out_cells.h>

#include <stdexcept>

namespace lamap::tools
{
namespace
{
void requireScans(const HeldOutChoice& choice, const HeldOutCells& shown, const InsertionTally& tally,
                  const HeldOutOptions& options)
{
  const std::string inputs = joined(options.inputs.paths);
  if (choice.heldOut() == 0)
    throw std::runtime_error(inputs + ": " + counted(choice.mostScans(), "usable scan") +
                             " of a sensor, fewer than " + std::to_string(options.every) +
                             ": none would be held out" + reasonsOf(tally));
  if (tally.usedCount() == 0)
    throw std::runtime_error(inputs + ": not one scan that the map takes" + reasonsOf(tally));
  if (shown.empty())
    throw std::runtime_error(inputs + ": the scans that were held out show neither hits nor free space");
}
}  // namespace

HeldOutReport scoreHeldOut(const HeldOutOptions& options, const ProgressSink& progress)
{
  requireLegalScoring(options.every, options.maxRange_m);
  const MapDefinition definition = readMapDefinition(options.map);
  ScoredMap scored(definition.name, definition, options.threads, options.maxRange_m, "score");
  const auto sources = openInputs(options.inputs);

  HeldOutReport report;
  report.maxRange_m = scored.rules.maxRange_m;
  HeldOutChoice choice(options.every);
  HeldOutCells shown(scored.rules.resolution_m);
  report.stopped = !visitScans(sources, options.inputs.shouldStop, progress,
                               [&](const ScanItem& item, const ScanSource& /*source*/)
                               {
                                 const auto scan = scanOf(item);
                                 if (scan && choice.isHeldOut(item))
                                   shown.add(*scan, scored.rules);
                                 else
                                   scored.inserter->insert(item);
                               });
  report.scans = scored.inserter->tally();
  report.heldOut = choice.heldOut();
  report.inputs = reportsOf(sources);
  report.inputNotes = allNotesOf(sources);
  if (report.stopped) return report;

  requireScans(choice, shown, report.scans, options);
  report.scores = scored.heldOutScores(ScoredRays::All, shown, options.thresholds);
  report.scoresOfReturned = scored.heldOutScores(ScoredRays::Returned, shown, options.thresholds);
  return report;
}

}  // namespace lamap::tools
