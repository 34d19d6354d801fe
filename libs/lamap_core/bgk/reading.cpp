#include <lamap_core/bgk/reading.h>

#include <lamap_core/bgk/map.h>
#include <lamap_core/bgk/reading_numbers.h>
#include <lamap_core/grid/cell_accessor.h>
#include <lamap_core/options/legal_range.h>
#include <lamap_core/options/option_table.h>

#include <string>
#include <utility>

namespace lamap
{
namespace
{
/// Refuses another map whose cells are not those of this one. @param whose "of the other map"
void requireSameCells(BgkStructure theirs, const BgkStructure& ours, const std::string& whose)
{
  const double height = std::exchange(theirs.planarHeight, ours.planarHeight);
  theirs.pruning = ours.pruning;
  theirs.priorAlpha = ours.priorAlpha;
  theirs.priorBeta = ours.priorBeta;
  theirs.maxEvidence = ours.maxEvidence;
  requireSameOptions(theirs, ours, whose, "that of this map");
  theirs.planarHeight = height;
  requireLegal(theirs.planarLayer() == ours.planarLayer(), ("planarHeight " + whose).c_str(), height,
               "in the layer of this map");
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
  const PseudoCounts counts(sums, prior, structure_.maxEvidence);
  CellEstimate estimate;
  estimate.prob = bgkMean(counts.alpha, counts.beta);
  estimate.variance = bgkVariance(counts.alpha, counts.beta);
  estimate.state = bgkState(estimate.prob, *estimate.variance, thresholds);
  estimate.evidence = {prior[0] + counts.hits, prior[1] + counts.free};
  return estimate;
}

void BgkReading::requireAddable(const BgkReading& other) const
{
  requireSameCells(other.structure_, structure_, "of the other map");
}

void BgkReading::setPriorMap(std::shared_ptr<const BgkMap> prior)
{
  if (prior)
  {
    BgkStructure theirs = prior->structure();
    theirs.blockDepth = structure_.blockDepth;
    requireSameCells(theirs, structure_, "of the prior map");
  }
  priorMap_ = std::move(prior);
}

bool BgkReading::priorKnows(const CellIndex& cell) const
{
  return priorMap_ && priorMap_->cell(cell, {}).has_value();
}

void BgkReading::visitPriorCells(const std::function<void(const CellIndex&)>& visit) const
{
  if (priorMap_) priorMap_->visitCells({}, [&](const CellIndex& cell, const CellEstimate&) { visit(cell); });
}

void BgkReading::visitPriorCells(const CellIndex& low, const CellIndex& high,
                                 const std::function<void(const CellIndex&)>& visit) const
{
  if (!priorMap_) return;
  BgkMap::Accessor prior(*priorMap_, {});
  prior.visitBox(low, high, [&](const KnownCell& known) { visit(known.cell); });
}

std::optional<std::pair<CellIndex, CellIndex>> BgkReading::priorBounds() const
{
  return priorMap_ ? priorMap_->cellBounds() : std::nullopt;
}

int BgkReading::priorEmptyAround(const CellIndex& cell) const
{
  return priorMap_ ? priorMap_->emptyAround(cell) : ReadingOf::priorEmptyAround(cell);
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
