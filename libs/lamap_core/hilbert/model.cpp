#include <lamap_core/hilbert/model.h>

#include <lamap_core/hilbert/compact_model.h>
#include <lamap_core/hilbert/nystroem_model.h>
#include <lamap_core/hilbert/reached_cells.h>

#include <algorithm>
#include <cmath>

namespace lamap
{
std::unique_ptr<MapModel> MapModel::make(const HilbertStructure& structure)
{
  if (structure.features == HilbertFeatures::Compact) return std::make_unique<CompactMapModel>(structure);
  return std::make_unique<NystroemMapModel>(structure);
}

void MapModel::learn(HilbertTrainingSet& set, const HilbertFrame& frame, const HilbertInference& inference,
                     const Workers& workers)
{
  const std::vector<PointWidths::Share> shares = widths_.prepare(set, frame);
  learnWeights(set, frame, inference, workers);
  widths_.add(shares);
}

ReachedLogodds MapModel::at(const PointAtSite& point) const
{
  return widths_.empty() ? saidAt(point) : at(point, Eigen::Matrix3d::Zero());
}

ReachedLogodds MapModel::at(const PointAtSite& point, const Eigen::Matrix3d& covariance) const
{
  if (widths_.empty()) return saidAt(point, covariance);
  const Eigen::Matrix3d whole = covariance + widths_.covarianceAt(point.anchorSite, point.place);
  return whole.isZero(0) ? saidAt(point) : saidAt(point, whole);
}

void MapModel::atRegular(const CellIndex& anchorSite, const RegularPoints& points,
                         std::vector<ReachedLogodds>& out) const
{
  saidAtRegular(anchorSite, points, out);
  if (widths_.empty()) return;
  size_t i = 0;
  for (int z = 0; z < points.counts[2]; ++z)
    for (int y = 0; y < points.counts[1]; ++y)
      for (int x = 0; x < points.counts[0]; ++x, ++i)
      {
        const PointAtSite point{anchorSite, points.first + points.step_m * Eigen::Vector3d(x, y, z)};
        const Eigen::Matrix3d covariance = widths_.covarianceAt(anchorSite, point.place);
        if (!covariance.isZero(0)) out[i] = saidAt(point, covariance);
      }
}

void MapModel::Extent::extend(const Extent& other)
{
  box_map.extend(other.box_map);
  reach_m = std::max(reach_m, other.reach_m);
}

MapModel::Extent MapModel::extentOf(const HilbertTrainingSet& set, const HilbertFrame& frame) const
{
  Extent extent;
  const Eigen::Vector3d corner = cornerOf(frame.anchorSite, frame.spacing_m);
  for (const Eigen::Vector3d& point : set.points) extent.box_map.extend(corner + point);
  extent.reach_m = kernel_.support_m();
  for (const Eigen::Matrix3d& covariance : set.covariances)
    extent.reach_m =
        std::max(extent.reach_m, kernel_.reach_m(GaussianBlur(covariance, kernel_.gamma())).maxCoeff());
  return extent;
}

bool MapModel::isSurelyRoomFor(size_t /*points*/, const Extent& extent) const
{
  const double block_m = kScanBlockEdge * structure_.latticeSpacing;
  const auto along = [&](int axis)
  { return (extent.box_map.sizes()[axis] + 2 * extent.reach_m) / block_m + 3; };
  return along(0) * along(1) * (structure_.planar ? 1 : along(2)) <=
         static_cast<double>(ScanBlocks::kMaxBlocks);
}

void MapModel::requireRoomFor(const HilbertTrainingSet& set, const HilbertFrame& frame)
{
  work_->compact.findSites(set, kernel_, structure_.latticeSpacing, structure_.planar,
                           shiftOf(frame.anchorSite));
}

ReachedBox MapModel::addSites(const SiteSet& sites, const HilbertFrame& frame, const SitePosterior& weight,
                              Growth& growth)
{
  ReachedBox reached = reached_;
  for (size_t i = 0; i < sites.blocks().size(); ++i)
  {
    const BlockIndex block = plusAnchor(sites.blocks()[i], frame.anchorSite);
    const bool isNew = lattice_.find(block) == nullptr;
    extendReach(block, growth.addSites(block, sites.bits(i), weight), isNew, reached);
  }
  return reached;
}

/// @param sites of a block that are new; @param isNew the block itself is
void MapModel::extendReach(const BlockIndex& block, const SiteSet::Bits& sites, bool isNew,
                           ReachedBox& reached)
{
  if (!work_->siteReach) work_->siteReach.emplace(structure_);
  work_->siteReach->extend(reached, block, sites);
  if (!isNew) return;
  const auto [low, high] = cellsNearBlocks(structure_, block, block);
  constexpr int32_t kEdge = 1 << CellCubes::kFinest;
  const auto cubeOf = [](int32_t cell) { return cell >> CellCubes::kFinest; };
  for (int32_t z = cubeOf(low.z); z <= cubeOf(high.z); ++z)
    for (int32_t y = cubeOf(low.y); y <= cubeOf(high.y); ++y)
      for (int32_t x = cubeOf(low.x); x <= cubeOf(high.x); ++x)
        nearSites_.add({x * kEdge, y * kEdge, z * kEdge});
}

uint64_t MapModel::solve(const LogisticProblem& problem, const HilbertInference& inference,
                         const Workers& workers, std::vector<float>& weights)
{
  const HilbertTraining training = structure_.training;
  const SolverSettings settings{inference.solverFor(training),
                                static_cast<int>(inference.iterationsFor(training)), inference,
                                structure_.seed};
  return work_->solver.solve(problem, settings, sgdSteps_, weights, workers);
}

void MapModel::save(HilbertState& state) const
{
  for (const BlockIndex& index : lattice_.sortedBlocks())
  {
    const auto* block = lattice_.find(index);
    state.blocks.push_back({index, block->bits, block->weights});
  }
  state.sgdSteps = sgdSteps_;
  widths_.save(state);
}

void MapModel::restore(const HilbertState& state)
{
  constexpr int32_t kLastBlock = 1 << (30 - kScanBlockLog2Edge);
  const auto fits = [](int32_t i) { return i >= -kLastBlock && i <= kLastBlock; };
  lattice_.clear();
  reached_ = {};
  nearSites_.clear();
  const BlockIndex* last = nullptr;
  for (const HilbertState::Block& block : state.blocks)
  {
    const BlockIndex& index = block.index;
    HilbertState::require(fits(index.x) && fits(index.y) && fits(index.z), "a block is out of range");
    HilbertState::require(!structure_.planar || index.z == 0, "a block beside the plane");
    HilbertState::require(last == nullptr || *last < index, "blocks are not in their order");
    last = &block.index;
    size_t count = 0;
    for (const uint64_t word : block.bits) count += static_cast<size_t>(__builtin_popcountll(word));
    HilbertState::require(count > 0 && count == block.weights.size(),
                          "a block does not have one weight for each of its sites");
    const bool isPosterior = structure_.training == HilbertTraining::Incremental;
    for (const SitePosterior& weight : block.weights)
      HilbertState::require(isLegalWeight(weight.mean) && std::isfinite(weight.precision) &&
                                (isPosterior ? weight.precision > 0 : weight.precision >= 0),
                            "a weight is not finite or too large, or its precision not positive");
    lattice_.put(index, {{block.bits, {}}, block.weights});
    extendReach(index, block.bits, true, reached_);
  }
  sgdSteps_ = state.sgdSteps;
  widths_.restore(state);
}

}  // namespace lamap
