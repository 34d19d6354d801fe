#include <lamap_core/gp/reading.h>

#include <lamap_core/gp/reading_numbers.h>

#include <algorithm>

namespace lamap
{
void GpReading::requireAddable(const GpReading& other) const
{
  GpStructure theirs = other.structure_;
  theirs.pruning = structure_.pruning;
  theirs.maxEvidence = structure_.maxEvidence;
  requireSameOptions(theirs, structure_, "of the other map", "that of this map");
}

GpReading::GpReading(const GpStructure& structure) : ReadingOf(structure)
{
  structure_ = structure.resolved();
}

CellEstimate GpReading::read(const CellIndex& index, const CellSums& sums,
                             const StateThresholds& thresholds) const
{
  CellEstimate cell;
  if (structure_.fusion == GpFusion::Bayes)
  {
    cell.prob = probOf(*this, index, sums);
    cell.evidence = {evidenceSum(sums.second), 0.0};
    cell.state = stateOf(cell.prob, thresholds);
    return cell;
  }
  const double prior = 1.0 / structure_.signalVariance;
  const double given = std::max(evidenceSum(sums.first), 0.0);
  const double factor = evidenceFactor(given, *structure_.maxEvidence);
  cell.variance = 1.0 / (prior + factor * given);                               // Eq. (2.29)
  cell.evidence = {prior + given, evidenceSum(sums.second) / (prior + given)};  // Eq. (2.28)
  cell.prob = probOf(*this, index, sums);
  if (!(thresholds.variance > 0) || *cell.variance < thresholds.variance)
    cell.state = stateOf(cell.prob, thresholds);
  return cell;
}

SignedSums GpReading::sumsOf(const GpStructure& structure, double precision, double weighted)
{
  if (structure.fusion == GpFusion::Bayes)  // Eq. (2.25)
  {
    // As far from 0 as no probability tells: extreme options would reach what a sum can hold within a few
    // scans.
    constexpr double kMostLogodds = 1000;
    const double logodds = std::clamp(structure.squash() * weighted, -kMostLogodds, kMostLogodds);
    return {std::nullopt, inEvidenceUnits(logodds)};
  }
  return {std::max<int64_t>(inEvidenceUnits(precision), 0), inEvidenceUnits(weighted)};
}

}  // namespace lamap
