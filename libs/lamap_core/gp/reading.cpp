#include <lamap_core/gp/reading.h>

#include <lamap_core/math/portable_math.h>

#include <algorithm>

namespace lamap
{
namespace
{
double sumOf(uint64_t code)
{
  return static_cast<double>(SignedSums::decoded(code).value_or(0)) * kEvidenceUnit;
}
}  // namespace

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

CellEstimate GpReading::read(const CellIndex& /*cell*/, const CellSums& sums,
                             const StateThresholds& thresholds) const
{
  CellEstimate cell;
  if (structure_.fusion == GpFusion::Bayes)
  {
    const double logodds = sumOf(sums.second);
    cell.prob = logistic(logodds);
    cell.evidence = {logodds, 0.0};
    cell.state = stateOf(cell.prob, thresholds);
    return cell;
  }
  const double prior = 1.0 / structure_.signalVariance;
  const double given = std::max(sumOf(sums.first), 0.0);
  const double factor = evidenceFactor(given, *structure_.maxEvidence);
  const double precision = prior + factor * given;
  const double weighted = factor * sumOf(sums.second);
  cell.variance = 1.0 / precision;                                        // Eq. (2.29)
  cell.evidence = {prior + given, sumOf(sums.second) / (prior + given)};  // Eq. (2.28)
  cell.prob = logistic(structure_.squash() * weighted);  // Eq. (2.25): ω is σ²_min·mean/variance
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
