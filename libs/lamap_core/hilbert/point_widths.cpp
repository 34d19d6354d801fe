#include <lamap_core/hilbert/point_widths.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace lamap
{
PointWidths::PointWidths(const HilbertStructure& structure)
    : planar_(structure.planar), sum_(structure.kernel(), structure.latticeSpacing, structure.planar)
{
}

CellIndex PointWidths::siteOf(const Eigen::Vector3d& point, const HilbertFrame& frame) const
{
  const auto along = [&](double coordinate, int32_t anchor)
  { return anchor + AxisReaches::siteOf(coordinate, frame.spacing_m); };
  return {along(point.x(), frame.anchorSite.x), along(point.y(), frame.anchorSite.y),
          planar_ ? 0 : along(point.z(), frame.anchorSite.z)};
}

std::vector<PointWidths::Share> PointWidths::prepare(const HilbertTrainingSet& set, const HilbertFrame& frame)
{
  std::vector<Share> shares;
  if (set.variances.empty() && empty()) return shares;
  shares.reserve(set.size());
  for (size_t i = 0; i < set.size(); ++i)
  {
    const CellIndex site = siteOf(set.points[i], frame);
    const float variance = i < set.variances.size() ? set.variances[i] : 0.0f;
    shares.push_back({site, set.weights[i], set.weights[i] * variance});
    if (!(variance > 0) || variances_.find(site) != nullptr) continue;
    SiteSet::Bits bits{};
    const uint32_t offset = SiteSet::offsetOf(site);
    bits[offset / 64] = uint64_t{1} << (offset % 64);
    weights_.addSites(SiteSet::blockOf(site), bits, 0.0f);
    variances_.addSites(SiteSet::blockOf(site), bits, 0.0f);
  }
  return shares;
}

void PointWidths::add(const std::vector<Share>& shares)
{
  for (const Share& share : shares)
  {
    float* variance = variances_.find(share.site);
    if (variance == nullptr) continue;
    *variance += share.variance;
    *weights_.find(share.site) += share.weight;
  }
}

Eigen::Matrix3d PointWidths::covarianceAt(const CellIndex& anchorSite, const Eigen::Vector3d& place) const
{
  const auto weight = static_cast<double>(sum_.at(weights_, anchorSite, place).logodds);
  if (!(weight > 0)) return Eigen::Matrix3d::Zero();
  const double variance = static_cast<double>(sum_.at(variances_, anchorSite, place).logodds) / weight;
  return Eigen::Vector3d(variance, variance, planar_ ? 0 : variance).asDiagonal();
}

void PointWidths::save(HilbertState& state) const
{
  for (const BlockIndex& index : weights_.sortedBlocks())
  {
    const auto& weights = *weights_.find(index);
    const auto& variances = *variances_.find(index);
    HilbertState::WidthBlock kept{index, {}, {}, {}};
    for (uint32_t offset = 0; offset < kScanBlockCells; ++offset)
    {
      if (!weights.has(offset)) continue;
      const size_t place = weights.placeOf(offset);
      if (!(weights.weights[place] > 0)) continue;
      kept.bits[offset / 64] |= uint64_t{1} << (offset % 64);
      kept.weights.push_back(weights.weights[place]);
      kept.variances.push_back(variances.weights[place]);
    }
    if (!kept.weights.empty()) state.widths.push_back(std::move(kept));
  }
}

void PointWidths::restore(const HilbertState& state)
{
  const auto isLegal = [](float sum) { return sum >= 0 && std::isfinite(sum); };
  weights_.clear();
  variances_.clear();
  const BlockIndex* last = nullptr;
  for (const HilbertState::WidthBlock& block : state.widths)
  {
    HilbertState::require(last == nullptr || *last < block.index, "blocks of widths are not in their order");
    last = &block.index;
    HilbertState::require(!planar_ || block.index.z == 0, "a block of widths beside the plane");
    size_t count = 0;
    for (const uint64_t word : block.bits) count += SiteBits::countOf(word);
    HilbertState::require(count > 0 && count == block.weights.size() && count == block.variances.size(),
                          "a block does not have a width for each of its sites");
    HilbertState::require(std::all_of(block.weights.begin(), block.weights.end(), isLegal) &&
                              std::all_of(block.variances.begin(), block.variances.end(), isLegal),
                          "the width of a site is not legal");
    weights_.put(block.index, {{block.bits, {}}, block.weights});
    variances_.put(block.index, {{block.bits, {}}, block.variances});
  }
}

}  // namespace lamap
