#include <lamap_core/bgk/map.h>

#include <lamap_core/bgk/reading_numbers.h>
#include <lamap_core/bgk/scan_inference.h>
#include <lamap_core/grid/cell_accessor_members.h>
#include <lamap_core/grid/evidence_map_members.h>
#include <lamap_core/options/legal_range.h>

#include <utility>

namespace lamap
{
template class EvidenceMap<BgkReading>;
template class CellAccessor<BgkReading>;

RayCounts BgkMap::insert(const Scan& scan, const BgkInference& inference, unsigned threads)
{
  inference.validate(structure().resolution);
  const BgkInference resolved = inference.resolved(structure().resolution);
  const Workers& workers = workers_.with(threads);
  RayCounts counts;
  add(inference_.get().infer(scan, resolved, structure(), planarLayer(), workers, counts),
      inference.thresholds, workers);
  return counts;
}

void BgkMap::setPriorMap(std::shared_ptr<const BgkMap> prior)
{
  reading().setPriorMap(std::move(prior));
}

void BgkMap::addEvidence(const CellIndex& index, double alpha, double beta, const StateThresholds& thresholds)
{
  constexpr double kMaxCount = 1e12;
  requireLegal(alpha >= 0 && alpha <= kMaxCount, "alpha", alpha, "a number from 0 to 1e12");
  requireLegal(beta >= 0 && beta <= kMaxCount, "beta", beta, "a number from 0 to 1e12");
  const CellSums sums{static_cast<uint64_t>(inEvidenceUnits(alpha)),
                      static_cast<uint64_t>(inEvidenceUnits(beta))};
  if (sums.any()) add(evidenceOf(index, sums), thresholds, Workers(1));
}

}  // namespace lamap
