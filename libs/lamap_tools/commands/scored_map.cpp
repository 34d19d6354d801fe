#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <lamap_tools/commands/scored_map.h>
#include <lamap_tools/files/usage_error.h>

#include <cmath>

namespace lamap::tools
{
ScoredMap::ScoredMap(const std::string& shownName, const MapDefinition& definition, unsigned threads,
                     double maxRange_m, const std::string& purpose)
    : name(shownName), map(createMap(definition)), cells(cellsOf(map))
{
  if (!cells)
    throw UsageError("-m " + name + ": a " + map->GetRuntimeClass()->className + " has no cells to " +
                     purpose);
  if (auto* learned = dynamic_cast<CLearnedMap*>(map.get())) learned->setThreadCount(threads);
  rules = labelRulesFor(*map, *cells, maxRange_m);
  inserter = std::make_unique<ScanInserter>(*map);
}

MapScores ScoredMap::scores(const std::vector<double>& thresholds)
{
  return tally.scores(name, *cells, thresholds);
}

MapScores ScoredMap::heldOutScores(ScoredRays rays, const HeldOutCells& shown,
                                   const std::vector<double>& thresholds)
{
  shown.ask(rays, *cells, tally);
  return scores(thresholds);
}

void requireLegalScoring(size_t every, double maxRange_m)
{
  if (every < 2)
    throw UsageError("--held-out " + std::to_string(every) +
                     ": must be a whole number >= 2; with 10 every tenth scan is scored");
  if (!(maxRange_m >= 0) || !std::isfinite(maxRange_m))
    throw UsageError("--max-range: must be a length > 0, in m");
}

}  // namespace lamap::tools
