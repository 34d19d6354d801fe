#include <lamap_core/bgk/reading.h>

#include <lamap_core/bgk/map.h>
#include <lamap_core/options/legal_range.h>

#include <cmath>
#include <string>

namespace lamap
{
namespace
{
double layerOf(const BgkStructure& structure)
{
  return std::floor(structure.planarHeight / structure.resolution);
}
}  // namespace

double bgkMean(double alpha, double beta)
{
  return alpha / (alpha + beta);
}  // Eq. (4.1)

double bgkVariance(double alpha, double beta)  // Eq. (4.2)
{
  const double sum = alpha + beta;
  return (alpha / sum) * (beta / sum) / (sum + 1.0);
}

CellState bgkState(double mean, double variance, const StateThresholds& thresholds)  // Eq. (4.9)
{
  if (thresholds.variance > 0 && !(variance < thresholds.variance)) return CellState::Unknown;
  return stateOf(mean, thresholds);
}

CellEstimate BgkReading::read(const CellIndex& cell, const CellSums& sums,
                              const StateThresholds& thresholds) const
{
  const std::array<double, 2> prior = priorOf(cell);
  const double alpha = prior[0] + static_cast<double>(sums.first) * kEvidenceUnit;
  const double beta = prior[1] + static_cast<double>(sums.second) * kEvidenceUnit;
  CellEstimate estimate;
  estimate.prob = bgkMean(alpha, beta);
  estimate.variance = bgkVariance(alpha, beta);
  estimate.state = bgkState(estimate.prob, *estimate.variance, thresholds);
  estimate.evidence = {alpha, beta};
  return estimate;
}

void BgkReading::requireAddable(const BgkReading& other) const
{
  const BgkStructure& theirs = other.structure_;
  requireLegal(theirs.resolution == structure_.resolution, "resolution of the other map", theirs.resolution,
               "that of this map, " + std::to_string(structure_.resolution));
  requireLegal(theirs.blockDepth == structure_.blockDepth, "blockDepth of the other map", theirs.blockDepth,
               "that of this map, " + std::to_string(structure_.blockDepth));
  requireLegal(theirs.planar == structure_.planar && layerOf(theirs) == layerOf(structure_),
               "planarHeight of the other map", theirs.planarHeight, "in the layer of this map");
}

bool BgkReading::priorKnows(const CellIndex& cell) const
{
  return priorMap_ && priorMap_->cell(cell, {}).has_value();
}

void BgkReading::visitPriorCells(const std::function<void(const CellIndex&)>& visit) const
{
  if (priorMap_) priorMap_->visitCells({}, [&](const CellIndex& cell, const CellEstimate&) { visit(cell); });
}

std::array<double, 2> BgkReading::priorOf(const CellIndex& cell) const
{
  if (priorMap_)
  {
    if (const auto known = priorMap_->cell(cell, {})) return known->evidence;
  }
  return {structure_.priorAlpha, structure_.priorBeta};
}

}  // namespace lamap
