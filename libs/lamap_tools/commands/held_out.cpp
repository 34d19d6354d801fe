#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <lamap_mrpt/observations/observation_rays.h>
#include <lamap_tools/commands/held_out.h>
#include <lamap_tools/files/usage_error.h>
#include <mrpt/maps/CColouredOctoMap.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/maps/COctoMap.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <variant>

#include <lamap_tools/commands/held_out_cells.h>

namespace lamap::tools
{
namespace
{
void requireLegalOptions(const HeldOutOptions& options)
{
  if (options.every < 2)
    throw UsageError("--held-out " + std::to_string(options.every) +
                     ": must be a whole number >= 2; with 10 every tenth scan is scored");
  if (!(options.maxRange_m >= 0) || !std::isfinite(options.maxRange_m))
    throw UsageError("--max-range: must be a length > 0, in m");
}

std::optional<CellEstimate> estimateOf(const CellMap& map, const CellIndex& cell, double resolution_m)
{
  const Eigen::Vector3d centre = cellCentre(cell, resolution_m);
  return map.estimateAt({centre.x(), centre.y(), centre.z()});
}

std::string namesOf(const InputOptions& inputs)
{
  std::string names;
  for (const std::string& path : inputs.paths) names += (names.empty() ? "" : ", ") + path;
  return names;
}

void requireScans(const HeldOutChoice& choice, const HeldOutCells& shown, const InsertionTally& tally,
                  const HeldOutOptions& options)
{
  const std::string inputs = namesOf(options.inputs);
  if (choice.heldOut() == 0)
    throw std::runtime_error(inputs + ": " + std::to_string(choice.mostScans()) +
                             " usable scans of a sensor, fewer than " + std::to_string(options.every) +
                             ": none would be held out" + reasonsOf(tally));
  if (tally.usedCount() == 0)
    throw std::runtime_error(inputs + ": not one scan that the map takes" + reasonsOf(tally));
  if (shown.empty())
    throw std::runtime_error(inputs + ": the scans that were held out show neither hits nor free space");
}
}  // namespace

bool HeldOutChoice::isHeldOut(const ScanItem& item)
{
  std::string sensor;
  if (const auto* observed = std::get_if<ObservedScan>(&item)) sensor = observed->observation->sensorLabel;
  if (++scansOf_[sensor] % every_ != 0) return false;
  ++heldOut_;
  return true;
}

size_t HeldOutChoice::mostScans() const
{
  size_t most = 0;
  for (const auto& entry : scansOf_) most = std::max(most, entry.second);
  return most;
}

void HeldOutCells::add(const ScanLabels& labels)
{
  for (const CellIndex& cell : labels.occupied) ++votes_[cell].occupied;
  for (const CellIndex& cell : labels.free) ++votes_[cell].free;
}

void HeldOutCells::ask(const CellMap& map, PredictionTally& tally) const
{
  for (const auto& [cell, votes] : votes_)
    tally.add(estimateOf(map, cell, resolution_m_), votes.occupied, votes.free);
}

void askAboutLabels(const CellMap& map, const ScanLabels& labels, PredictionTally& tally)
{
  const double resolution_m = map.resolution();
  for (const CellIndex& cell : labels.occupied) tally.add(estimateOf(map, cell, resolution_m), 1, 0);
  for (const CellIndex& cell : labels.free) tally.add(estimateOf(map, cell, resolution_m), 0, 1);
}

LabelRules labelRulesFor(const mrpt::maps::CMetricMap& map, const CellMap& cells, double maxRange_m)
{
  LabelRules rules;
  rules.resolution_m = cells.resolution();
  rules.maxRange_m = maxRange_m > 0 ? maxRange_m : maxRangeOf(map);
  rules.layer = layerOf(&map);
  return rules;
}

std::optional<Scan> scanOf(const ScanItem& item)
{
  if (const auto* points = std::get_if<PointScan>(&item)) return points->scan;
  const auto* observed = std::get_if<ObservedScan>(&item);
  if (observed == nullptr || !supportsObservation(*observed->observation)) return std::nullopt;
  try
  {
    return raysOf(*observed->observation, observed->robotPose_map);
  }
  catch (const std::runtime_error&)
  {
    return std::nullopt;
  }
}

double maxRangeOf(const mrpt::maps::CMetricMap& map)
{
  if (const auto* learned = dynamic_cast<const CLearnedMap*>(&map)) return learned->rangeLimits().max_m;
  if (const auto* octo = dynamic_cast<const mrpt::maps::COctoMap*>(&map))
    return std::max(0.0, octo->insertionOptions.maxrange);
  if (const auto* coloured = dynamic_cast<const mrpt::maps::CColouredOctoMap*>(&map))
    return std::max(0.0, coloured->insertionOptions.maxrange);
  if (const auto* grid = dynamic_cast<const mrpt::maps::COccupancyGridMap2D*>(&map))
    return std::max(0.0, static_cast<double>(grid->insertionOptions.maxDistanceInsertion));
  return 0;
}

HeldOutReport scoreHeldOut(const HeldOutOptions& options, const ProgressSink& progress)
{
  requireLegalOptions(options);
  const MapDefinition definition = readMapDefinition(options.map);
  const auto map = createMap(definition);
  if (auto* learned = dynamic_cast<CLearnedMap*>(map.get())) learned->setThreadCount(options.threads);
  const auto cells = cellsOf(map);
  if (!cells)
    throw UsageError("-m " + definition.name + ": a " + map->GetRuntimeClass()->className +
                     " has no cells to score");
  const auto sources = openInputs(options.inputs);

  HeldOutReport report;
  const LabelRules rules = labelRulesFor(*map, *cells, options.maxRange_m);
  report.maxRange_m = rules.maxRange_m;
  HeldOutChoice choice(options.every);
  HeldOutCells shown(rules.resolution_m);
  ScanInserter inserter(*map);
  report.stopped = !visitScans(sources, options.inputs.shouldStop, progress,
                               [&](const ScanItem& item)
                               {
                                 const auto scan = scanOf(item);
                                 if (scan && choice.isHeldOut(item))
                                   shown.add(labelCells(*scan, rules));
                                 else
                                   inserter.insert(item);
                               });
  report.scans = inserter.tally();
  report.heldOut = choice.heldOut();
  report.inputs = reportsOf(sources);
  if (report.stopped) return report;

  requireScans(choice, shown, report.scans, options);
  report.scores.name = definition.name;
  report.scores.className = cells->className();
  report.scores.resolution_m = cells->resolution();
  PredictionTally tally;
  shown.ask(*cells, tally);
  tally.scoreInto(report.scores, options.thresholds);
  return report;
}

}  // namespace lamap::tools
