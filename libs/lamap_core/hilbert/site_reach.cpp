#include <lamap_core/hilbert/nystroem_model.h>
#include <lamap_core/hilbert/site_reach.h>
#include <lamap_core/scan/lattice_frame.h>

#include <algorithm>

namespace lamap
{
SiteReach::SiteReach(const HilbertStructure& structure)
    : structure_(structure),
      reach_m_(structure.kernel().support_m() + structure.latticeSpacing),
      reach_sites_(NystroemMapModel::reachInSites(structure)),
      cutoff_(structure.features == HilbertFeatures::Compact ? structure.kernel().cutoffF() : 0.0f),
      reaches_(structure.kernel(), structure.latticeSpacing)
{
}

/// The kernel's factor along an axis for the centre of a cell; Nyström's features count sites.
float SiteReach::factorOf(size_t axis, int32_t site, int32_t cell)
{
  std::array<int32_t, 3> cells{};
  cells[axis] = cell;
  const auto frame = HilbertFrame::atCell({cells[0], cells[1], cells[2]}, structure_.resolution,
                                          structure_.latticeSpacing, structure_.planar);
  if (!frame) return 0;
  const std::array<int32_t, 3> anchor{frame->anchorSite.x, frame->anchorSite.y, frame->anchorSite.z};
  const double place = frame->position(Eigen::Vector3d::Constant(0.5))[static_cast<int>(axis)];
  if (structure_.features == HilbertFeatures::Nystroem)
  {
    const int32_t own = anchor[axis] + AxisReaches::siteOf(place, structure_.latticeSpacing);
    return std::abs(own - site) <= reach_sites_ ? 1.0f : 0.0f;
  }
  const AxisWindow window = reaches_.of(place);
  const int32_t i = site - anchor[axis] - window.first;
  return i >= 0 && i < window.count() ? window.factor(i) : 0.0f;
}

SiteReach::AxisCells SiteReach::findCells(size_t axis, int32_t site)
{
  if (structure_.planar && axis == 2) return {*structure_.planarLayer(), {1.0f}, 1.0f};
  const double corner_m = site * structure_.latticeSpacing;
  AxisCells cells;
  cells.first = heldCell((corner_m - reach_m_) / structure_.resolution);
  const int32_t last = heldCell((corner_m + structure_.latticeSpacing + reach_m_) / structure_.resolution);
  for (int32_t cell = cells.first; cell <= last; ++cell)
  {
    const float factor = factorOf(axis, site, cell);
    if (factor == 0 && cells.factors.empty())
      ++cells.first;
    else
      cells.factors.push_back(factor);
  }
  while (!cells.factors.empty() && cells.factors.back() == 0) cells.factors.pop_back();
  for (const float factor : cells.factors) cells.largest = std::max(cells.largest, factor);
  return cells;
}

const SiteReach::AxisCells& SiteReach::cellsOf(size_t axis, int32_t site)
{
  auto& remembered = remembered_[axis];
  const auto found = remembered.find(site);
  if (found != remembered.end()) return found->second;
  return remembered.emplace(site, findCells(axis, site)).first->second;
}

void SiteReach::extend(ReachedBox& box, const BlockIndex& block, const SiteSet::Bits& sites)
{
  constexpr size_t kMostRemembered = 4096;
  const std::array<int32_t, 3> index{block.x, block.y, block.z};
  std::array<Row, 3> rows{};
  bool isInside = true;
  for (size_t axis = 0; axis < 3; ++axis)
  {
    if (remembered_[axis].size() > kMostRemembered) remembered_[axis].clear();
    for (int32_t i = 0; i < kScanBlockEdge; ++i)
    {
      const AxisCells& cells = cellsOf(axis, index[axis] * kScanBlockEdge + i);
      rows[axis][static_cast<size_t>(i)] = &cells;
      isInside = isInside && cells.first >= box.low[axis] && cells.last() <= box.high[axis];
    }
  }
  if (isInside) return;
  SiteBits::forEach(sites, {},
                    [&](const CellIndex& site)
                    {
                      extend(box, {rows[0][static_cast<size_t>(site.x)], rows[1][static_cast<size_t>(site.y)],
                                   rows[2][static_cast<size_t>(site.z)]});
                    });
}

/** By the cells of one site. Factors only fall with the distance, so the site reaches a layer of cells if it
 * reaches the cell there that is nearest along the other axes. */
void SiteReach::extend(ReachedBox& box, const std::array<const AxisCells*, 3>& cells) const
{
  if (cells[0]->factors.empty() || cells[1]->factors.empty() || cells[2]->factors.empty()) return;
  for (size_t axis = 0; axis < 3; ++axis)
  {
    const auto reaches = [&](int32_t cell)
    {
      const auto along = [&](size_t a) { return a == axis ? cells[a]->factor(cell) : cells[a]->largest; };
      const float yz = along(1) * along(2);  // in the order in which a question multiplies
      return yz * along(0) > cutoff_;
    };
    int32_t low = cells[axis]->first;
    while (low < box.low[axis] && low <= cells[axis]->last() && !reaches(low)) ++low;
    if (low <= cells[axis]->last()) box.low[axis] = std::min(box.low[axis], low);
    int32_t high = cells[axis]->last();
    while (high > box.high[axis] && high >= cells[axis]->first && !reaches(high)) --high;
    if (high >= cells[axis]->first) box.high[axis] = std::max(box.high[axis], high);
  }
}

}  // namespace lamap
