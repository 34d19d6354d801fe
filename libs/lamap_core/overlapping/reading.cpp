#include <lamap_core/overlapping/reading.h>

#include <lamap_core/overlapping/reading_numbers.h>

#include <algorithm>
#include <cmath>

namespace lamap
{
double logoddsOf(const CellSums& sums, double outOfFieldLimit)
{
  const SignedSums decoded = SignedSums::of(sums);
  if (decoded.first) return static_cast<double>(*decoded.first) * kEvidenceUnit;
  const double outside = static_cast<double>(decoded.second.value_or(0)) * kEvidenceUnit;
  return std::clamp(outside, -outOfFieldLimit, outOfFieldLimit);
}

double saturated(double logodds, double limit)
{
  const double share = std::abs(logodds) / limit;
  const double less = share > 1 ? 1 / share : share;  // its powers do not overflow
  const double root = std::sqrt(std::sqrt(1 + less * less * less * less));
  return share > 1 ? std::copysign(limit / root, logodds) : logodds / root;
}

CellEstimate OverlappingReading::read(const CellIndex& index, const CellSums& sums,
                                      const StateThresholds& thresholds) const
{
  CellEstimate cell;
  cell.prob = probOf(*this, index, sums);
  cell.state = stateOf(cell.prob, thresholds);
  cell.evidence = {logoddsOf(sums, structure_.outOfFieldLimit), sums.first != 0 ? 1.0 : 0.0};
  return cell;
}

void OverlappingReading::requireAddable(const OverlappingReading& other) const
{
  OverlappingStructure theirs = other.structure_;
  theirs.pruning = structure_.pruning;
  theirs.fieldLimit = structure_.fieldLimit;
  requireSameOptions(theirs, structure_, "of the other map", "that of this map");
}

bool OverlappingReading::mean(const CellSums* cells, uint32_t count, CellSums& mean) const
{
  const bool inField = cells[0].first != 0;
  const bool alike =
      std::all_of(cells, cells + count, [&](const CellSums& cell) { return (cell.first != 0) == inField; });
  if (alike) mean = meanSums(kKind, cells, count);
  return alike;
}

}  // namespace lamap
