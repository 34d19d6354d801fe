#include <lamap_core/scan_labels.h>
#include <lamap_mrpt/CLearnedMap.h>
#include <lamap_mrpt/cell_hash.h>
#include <lamap_mrpt/observation_rays.h>
#include <lamap_tools/held_out.h>
#include <lamap_tools/usage_error.h>
#include <mrpt/maps/CColouredOctoMap.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/maps/COctoMap.h>
#include <tsl/robin_map.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <variant>

namespace lamap::tools
{
namespace
{
std::string sensorOf(const ScanItem& item)
{
  if (const auto* observed = std::get_if<ObservedScan>(&item)) return observed->observation->sensorLabel;
  if (const auto* points = std::get_if<PointScan>(&item)) return points->kind;
  return "";
}

/// How often scans showed a cell occupied and free.
struct CellVotes
{
  uint64_t occupied = 0;
  uint64_t free = 0;
};

/** Gives scans to a map or keeps them from it. What the kept ones show is counted cell by cell, so that the
 * memory depends on the place and not on the number of scans. */
class HoldingOut
{
 public:
  HoldingOut(mrpt::maps::CMetricMap& map, const LabelRules& rules, size_t every)
      : inserter_(map), rules_(rules), every_(every)
  {
  }

  void take(const ScanItem& item)
  {
    const auto scan = scanOf(item);
    if (!scan || ++scansOf_[sensorOf(item)] % every_ != 0) return inserter_.insert(item);
    ++heldOut_;
    const ScanLabels labels = labelCells(*scan, rules_);
    for (const CellIndex& cell : labels.occupied) ++votes_[cell].occupied;
    for (const CellIndex& cell : labels.free) ++votes_[cell].free;
  }

  void ask(const CellMap& cells, PredictionTally& tally) const
  {
    for (const auto& [cell, votes] : votes_)
    {
      const Eigen::Vector3d centre = cellCentre(cell, rules_.resolution_m);
      tally.add(cells.estimateAt({centre.x(), centre.y(), centre.z()}), votes.occupied, votes.free);
    }
  }

  [[nodiscard]] const InsertionTally& tally() const { return inserter_.tally(); }
  [[nodiscard]] size_t heldOut() const { return heldOut_; }
  [[nodiscard]] bool hasLabels() const { return !votes_.empty(); }
  /// Of the sensor that gave most.
  [[nodiscard]] size_t mostScans() const
  {
    size_t most = 0;
    for (const auto& entry : scansOf_) most = std::max(most, entry.second);
    return most;
  }

 private:
  ScanInserter inserter_;
  LabelRules rules_;
  size_t every_;
  size_t heldOut_ = 0;
  std::map<std::string, size_t> scansOf_;
  tsl::robin_map<CellIndex, CellVotes, CellIndexHash> votes_;
};

void requireLegalOptions(const HeldOutOptions& options)
{
  if (options.every < 2)
    throw UsageError("--held-out " + std::to_string(options.every) +
                     ": must be a whole number >= 2; with 10 every tenth scan is scored");
  if (!(options.maxRange_m >= 0) || !std::isfinite(options.maxRange_m))
    throw UsageError("--max-range: must be a length > 0, in m");
}

std::string namesOf(const InputOptions& inputs)
{
  std::string names;
  for (const std::string& path : inputs.paths) names += (names.empty() ? "" : ", ") + path;
  return names;
}

std::string reasonsOf(const InsertionTally& tally)
{
  std::string reasons;
  for (const auto& [what, count] : tally.leftOut)
    reasons += "\n  " + std::to_string(count) + " " + what.first + ": " + what.second;
  return reasons;
}

void requireScans(const HoldingOut& holding, const HeldOutOptions& options)
{
  const std::string inputs = namesOf(options.inputs);
  if (holding.heldOut() == 0)
    throw std::runtime_error(inputs + ": " + std::to_string(holding.mostScans()) +
                             " usable scans of a sensor, fewer than " + std::to_string(options.every) +
                             ": none would be held out" + reasonsOf(holding.tally()));
  if (holding.tally().usedCount() == 0)
    throw std::runtime_error(inputs + ": not one scan that the map takes" + reasonsOf(holding.tally()));
  if (!holding.hasLabels())
    throw std::runtime_error(inputs + ": the scans that were held out show neither hits nor free space");
}
}  // namespace

bool HeldOutReport::damaged() const
{
  return std::any_of(inputs.begin(), inputs.end(),
                     [](const InputReport& input) { return !input.damages.empty(); });
}

std::optional<Scan> scanOf(const ScanItem& item)
{
  if (const auto* points = std::get_if<PointScan>(&item)) return scanOf(*points);
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
  report.maxRange_m = options.maxRange_m > 0 ? options.maxRange_m : maxRangeOf(*map);
  LabelRules rules;
  rules.resolution_m = cells->resolution();
  rules.maxRange_m = report.maxRange_m;
  rules.layer = layerOf(map.get());
  HoldingOut holding(*map, rules, options.every);
  report.stopped = !visitScans(sources, options.inputs.shouldStop, progress,
                               [&](const ScanItem& item) { holding.take(item); });
  report.scans = holding.tally();
  report.heldOut = holding.heldOut();
  for (const auto& source : sources)
    report.inputs.push_back({source->path(), source->notes(), source->damages()});
  if (report.stopped) return report;

  requireScans(holding, options);
  report.scores.name = definition.name;
  report.scores.className = cells->className();
  report.scores.resolution_m = cells->resolution();
  PredictionTally tally;
  holding.ask(*cells, tally);
  tally.scoreInto(report.scores, options.thresholds);
  return report;
}

}  // namespace lamap::tools
