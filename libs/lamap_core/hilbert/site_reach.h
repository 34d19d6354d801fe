#pragma once

#include <lamap_core/features/compact_kernel.h>
#include <lamap_core/features/site_set.h>
#include <lamap_core/grid/cell.h>
#include <lamap_core/grid/evidence_block.h>
#include <lamap_core/hilbert/options.h>

#include <array>
#include <cstdint>
#include <limits>
#include <unordered_map>
#include <vector>

namespace lamap
{
/// The smallest and the largest index of some cells along each axis.
struct ReachedBox
{
  static constexpr int32_t kNone = std::numeric_limits<int32_t>::max();
  std::array<int32_t, 3> low{kNone, kNone, kNone};
  std::array<int32_t, 3> high{-kNone, -kNone, -kNone};

  [[nodiscard]] bool any() const { return low[0] <= high[0]; }
};

/** Which cells sites of a map's lattice reach by themselves, where nothing is uncertain, as the questions to
 * a MapModel find out: to the last bit, but without asking for cells. Not to be shared between threads. */
class SiteReach
{
 public:
  explicit SiteReach(const HilbertStructure& structure);

  /// Extends a box by the cells that the sites of a block reach.
  void extend(ReachedBox& box, const BlockIndex& block, const SiteSet::Bits& sites);

 private:
  /// The cells along an axis that a site may reach, and the kernel's factor of each.
  struct AxisCells
  {
    int32_t first = 0;
    std::vector<float> factors;  ///< neither end is 0
    float largest = 0;

    [[nodiscard]] int32_t last() const { return first + static_cast<int32_t>(factors.size()) - 1; }
    [[nodiscard]] float factor(int32_t cell) const { return factors[static_cast<size_t>(cell - first)]; }
  };
  using Row = std::array<const AxisCells*, kScanBlockEdge>;

  [[nodiscard]] const AxisCells& cellsOf(size_t axis, int32_t site);
  [[nodiscard]] AxisCells findCells(size_t axis, int32_t site);
  [[nodiscard]] float factorOf(size_t axis, int32_t site, int32_t cell);
  void extend(ReachedBox& box, const std::array<const AxisCells*, 3>& cells) const;

  HilbertStructure structure_;
  double reach_m_;  ///< at least the distance along an axis from a site to a cell that it reaches
  int reach_sites_;
  float cutoff_;  ///< what the product of the factors must pass
  AxisReaches reaches_;
  std::array<std::unordered_map<int32_t, AxisCells>, 3> remembered_;  ///< by site along the axis
};

}  // namespace lamap
