#include <lamap_core/hilbert/compact_model.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace lamap
{
namespace
{
/// Finds the weights of sites that come sorted, looking up a block once for its row.
class SiteCursor
{
 public:
  SiteCursor(HilbertLattice<SitePosterior>& lattice, const CellIndex& anchorSite) : lattice_(lattice)
  {
    constexpr int32_t kBlock = ~(kScanBlockEdge - 1);
    low_ = {anchorSite.x & kBlock, anchorSite.y & kBlock, anchorSite.z & kBlock};
  }
  /// @param shifted site, which must be there
  SitePosterior& at(const CellIndex& shifted)
  {
    const CellIndex site{shifted.x + low_.x, shifted.y + low_.y, shifted.z + low_.z};
    const BlockIndex index = SiteSet::blockOf(site);
    if (block_ == nullptr || !(index == last_))
    {
      block_ = lattice_.find(index);
      last_ = index;
    }
    return block_->weights[block_->placeOf(SiteSet::offsetOf(site))];
  }

 private:
  HilbertLattice<SitePosterior>& lattice_;
  CellIndex low_;
  BlockIndex last_;
  HilbertLattice<SitePosterior>::Block* block_ = nullptr;
};

float boundedPrecision(float precision)
{
  constexpr float kMost = 1e30f;
  return std::isnan(precision) ? kMost : std::clamp(precision, std::numeric_limits<float>::min(), kMost);
}

}  // namespace

void CompactMapModel::learnWeights(HilbertTrainingSet& set, const HilbertFrame& frame,
                                   const HilbertInference& inference, const Workers& workers)
{
  CompactRows& compact = work_->compact;
  compact.findSites(set, kernel_, structure_.latticeSpacing, structure_.planar, shiftOf(frame.anchorSite));
  if (compact.sites().blocks().empty()) return;  // all points are too uncertain to say anything
  const auto prior = static_cast<float>(structure_.priorPrecision);
  Growth growth(lattice_, compact.sites().blocks().size());
  const ReachedBox reached =
      addSites(compact.sites(), frame, {0.0f, keepsPrecision() ? prior : 0.0f}, growth);
  addReachedSites(frame);
  compact.build(set, workers);
  readPrior(frame);
  const LogisticProblem problem{compact.rows(), set.labels, set.weights, work_->mean, work_->precision};
  work_->weights = work_->mean;
  const uint64_t steps = solve(problem, inference, workers, work_->weights);
  if (keepsPrecision()) work_->solver.finalCurvature(problem, work_->curvature, workers);
  // Nothing fails from here on.
  keepPosterior(frame);
  sgdSteps_ = steps;
  reached_ = reached;
  growth.keep();
}

void CompactMapModel::requireRoomFor(const HilbertTrainingSet& set, const HilbertFrame& frame)
{
  MapModel::requireRoomFor(set, frame);
  SiteSet& reached = work_->reached;
  reached = work_->compact.sites();
  reached.dilate(work_->compact.reach_sites(), structure_.planar);
}

/// The scan also speaks of features that are there already and that its points reach.
void CompactMapModel::addReachedSites(const HilbertFrame& frame)
{
  SiteSet& reached = work_->reached;
  reached = work_->compact.sites();
  reached.dilate(work_->compact.reach_sites(), structure_.planar);
  for (size_t i = 0; i < reached.blocks().size(); ++i)
  {
    const BlockIndex& block = reached.blocks()[i];
    SiteSet::Bits bits = lattice_.bitsOf(plusAnchor(block, frame.anchorSite));
    bool any = false;
    for (size_t word = 0; word < bits.size(); ++word)
    {
      bits[word] &= reached.bits(i)[word];
      any = any || bits[word] != 0;
    }
    if (any) work_->compact.sites().insert(block, bits);
  }
}

void CompactMapModel::readPrior(const HilbertFrame& frame)
{
  const SiteNumbers& numbers = work_->compact.numbers();
  work_->mean.assign(work_->compact.rows().weights(), 0.0f);
  work_->precision.assign(work_->compact.rows().weights(), 0.0f);
  SiteCursor cursor(lattice_, frame.anchorSite);
  for (size_t j = 0; j < numbers.sites().size(); ++j)
  {
    const SitePosterior& posterior = cursor.at(numbers.sites()[j]);
    work_->mean[numbers.used()[j]] = posterior.mean;
    work_->precision[numbers.used()[j]] =
        keepsPrecision() ? posterior.precision : static_cast<float>(structure_.priorPrecision);
  }
}

void CompactMapModel::keepPosterior(const HilbertFrame& frame)
{
  const SiteNumbers& numbers = work_->compact.numbers();
  SiteCursor cursor(lattice_, frame.anchorSite);
  for (size_t j = 0; j < numbers.sites().size(); ++j)
  {
    SitePosterior& posterior = cursor.at(numbers.sites()[j]);
    posterior.mean = boundedWeight(work_->weights[numbers.used()[j]]);
    if (keepsPrecision()) posterior.precision = boundedPrecision(work_->curvature[numbers.used()[j]]);
  }
}

ReachedLogodds CompactMapModel::saidAt(const PointAtSite& point) const
{
  return sum_.at(lattice_, point.anchorSite, point.place);
}

ReachedLogodds CompactMapModel::saidAt(const PointAtSite& point, const Eigen::Matrix3d& covariance) const
{
  return sum_.at(lattice_, point.anchorSite, point.place, covariance);
}

void CompactMapModel::saidAtRegular(const CellIndex& anchorSite, const RegularPoints& points,
                                    std::vector<ReachedLogodds>& out) const
{
  sum_.atRegular(lattice_, anchorSite, points, out);
}

void CompactMapModel::restore(const HilbertState& state)
{
  HilbertState::require(state.inducing.empty(), "inducing points, though its features are compact");
  HilbertState::require(state.classifier.empty(), "a classifier, though its features are compact");
  MapModel::restore(state);
}

}  // namespace lamap
