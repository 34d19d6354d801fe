#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <lamap_mrpt/observations/observation_rays.h>
#include <lamap_tools/scores/held_out_cells.h>
#include <mrpt/maps/CColouredOctoMap.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/maps/COctoMap.h>

#include <algorithm>
#include <stdexcept>
#include <variant>

namespace lamap::tools
{
namespace
{
std::optional<CellEstimate> estimateOf(const CellMap& map, const CellIndex& cell, double resolution_m)
{
  const Eigen::Vector3d centre = cellCentre(cell, resolution_m);
  return map.estimateAt({centre.x(), centre.y(), centre.z()});
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

ScanLabels labelsBy(ScoredRays rays, const Scan& scan, LabelRules rules)
{
  rules.noReturnIsFree = rays == ScoredRays::All;
  return labelCells(scan, rules);
}

void HeldOutCells::count(const ScanLabels& labels, CellVotes& votes)
{
  for (const CellIndex& cell : labels.occupied) ++votes[cell].occupied;
  for (const CellIndex& cell : labels.free) ++votes[cell].free;
}

void HeldOutCells::add(const Scan& scan, const LabelRules& rules)
{
  count(labelsBy(ScoredRays::All, scan, rules), byAll_);
  count(labelsBy(ScoredRays::Returned, scan, rules), byReturned_);
}

void HeldOutCells::ask(ScoredRays rays, const CellMap& map, PredictionTally& tally) const
{
  for (const auto& [cell, votes] : rays == ScoredRays::All ? byAll_ : byReturned_)
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
  catch (const std::exception&)
  {
    return std::nullopt;
  }
}

double maxRangeOf(const mrpt::maps::CMetricMap& map)
{
  if (const auto* learned = dynamic_cast<const CLearnedMap*>(&map)) return learned->rangeLimits().maxRange;
  if (const auto* octo = dynamic_cast<const mrpt::maps::COctoMap*>(&map))
    return std::max(0.0, octo->insertionOptions.maxrange);
  if (const auto* coloured = dynamic_cast<const mrpt::maps::CColouredOctoMap*>(&map))
    return std::max(0.0, coloured->insertionOptions.maxrange);
  if (const auto* grid = dynamic_cast<const mrpt::maps::COccupancyGridMap2D*>(&map))
    return std::max(0.0, static_cast<double>(grid->insertionOptions.maxDistanceInsertion));
  return 0;
}

}  // namespace lamap::tools
