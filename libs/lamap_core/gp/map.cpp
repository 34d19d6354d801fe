#include <lamap_core/gp/map.h>

#include <lamap_core/gp/reading_numbers.h>
#include <lamap_core/gp/scan_inference.h>
#include <lamap_core/grid/cell_accessor_members.h>
#include <lamap_core/grid/evidence_map_members.h>

namespace lamap
{
template class EvidenceMap<GpReading>;
template class CellAccessor<GpReading>;

RayCounts GpMap::insert(const Scan& scan, const GpInference& inference, unsigned threads)
{
  inference.validate(structure().resolution);
  const GpInference resolved = inference.resolved(structure().resolution);
  const Workers& workers = workers_.with(threads);
  RayCounts counts;
  add(inference_.get().infer(scan, resolved, structure(), planarLayer(), workers, counts),
      resolved.thresholds, workers);
  return counts;
}

void GpMap::addObservation(const CellIndex& index, bool occupied, const StateThresholds& thresholds)
{
  // Variance σ_f²·σ_n²/(σ_f² + σ_n²) and mean ±σ_f²/(σ_f² + σ_n²).
  const double precision = 1.0 / structure().noiseVariance;
  const SignedSums sums = GpReading::sumsOf(structure(), precision, occupied ? precision : -precision);
  add(evidenceOf(index, sums.coded()), thresholds, Workers(1));
}

}  // namespace lamap
