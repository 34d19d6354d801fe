#pragma once

#include <lamap_core/features/compact_kernel.h>
#include <lamap_core/features/lattice.h>
#include <lamap_core/features/logodds.h>

#include <Eigen/Core>
#include <array>
#include <vector>

namespace lamap
{
/** The log-odds f(x) = Σⱼ uⱼ·k(|x − cⱼ|) that weights u of compact features on a lattice say.
 *
 * Positions are in metres from the lowest corner of an anchor site. A point by itself and one among regular
 * points have the same log-odds to the last bit, wherever the anchor is. In a planar map heights do not
 * matter.
 * Immutable: may be shared between threads. */
class CompactSum
{
 public:
  /// @throws std::invalid_argument as AxisReaches
  CompactSum(const CompactKernel& kernel, double spacing_m, bool planar);

  /// Allocates nothing. @tparam Sites HilbertLattice or PackedSites
  template <typename Sites>
  [[nodiscard]] ReachedLogodds at(const Sites& sites, const CellIndex& anchorSite,
                                  const Eigen::Vector3d& point) const;

  /// Expected log-odds at an uncertain point, see CompactKernel. @param covariance [m²]
  [[nodiscard]] ReachedLogodds at(const SiteWeights& sites, const CellIndex& anchorSite,
                                  const Eigen::Vector3d& point, const Eigen::Matrix3d& covariance) const;

  /// At regular points, x fastest, then y, then z. In a planar map only counts[2] = 1 makes sense.
  void atRegular(const SiteWeights& sites, const CellIndex& anchorSite, const RegularPoints& points,
                 std::vector<ReachedLogodds>& out) const;

 private:
  CompactKernel kernel_;
  double spacing_m_;
  bool planar_;
};

template <typename Sites>
ReachedLogodds CompactSum::at(const Sites& sites, const CellIndex& anchorSite,
                              const Eigen::Vector3d& point) const
{
  constexpr int kBits = kScanBlockLog2Edge;
  std::array<AxisReach, 3> reaches;
  std::array<double, 3> places_m{};
  const auto windowOf = [&](size_t axis, int32_t anchor)
  {
    if (planar_ && axis == 2) return AxisReaches::flat();
    const int32_t site = AxisReaches::findRange(kernel_, spacing_m_, point[static_cast<int>(axis)],
                                                reaches[axis], places_m[axis]);
    return AxisWindow{site + anchor + reaches[axis].first, &reaches[axis]};
  };
  const AxisWindow x = windowOf(0, anchorSite.x);
  const AxisWindow y = windowOf(1, anchorSite.y);
  const AxisWindow z = windowOf(2, anchorSite.z);

  // A window of kMaxSites sites lies in three blocks along an axis at most.
  const BlockIndex low{x.first >> kBits, y.first >> kBits, z.first >> kBits};
  std::array<decltype(sites.find(low)), 27> blocks{};
  const auto numberOf = [&](int32_t i, int32_t j, int32_t k)
  { return static_cast<size_t>(((k - low.z) * 3 + (j - low.y)) * 3 + (i - low.x)); };
  for (int32_t k = low.z; k <= z.last() >> kBits; ++k)
    for (int32_t j = low.y; j <= y.last() >> kBits; ++j)
      for (int32_t i = low.x; i <= x.last() >> kBits; ++i)
        blocks[numberOf(i, j, k)] = sites.find(BlockIndex{i, j, k});

  std::array<float, 4> sums{};
  ReachedLogodds result;
  bool foundFactors = false;  // most questions meet no site
  const auto addRow = [&](const auto& block, const CellIndex& first, int32_t j, int32_t k)
  {
    const int32_t begin = std::max(x.first - first.x, 0);
    const int32_t end = std::min(x.last() - first.x + 1, kScanBlockEdge);
    const uint32_t offset = SiteSet::offsetOf(first);
    uint64_t row = block.rowAt(offset) & ((uint64_t{1} << end) - (uint64_t{1} << begin));
    if (row == 0) return;
    for (size_t axis = 0; axis < (planar_ ? 2 : 3) && !foundFactors; ++axis)
      AxisReaches::findFactors(kernel_, spacing_m_, places_m[axis], reaches[axis]);
    foundFactors = true;
    const float yz = y.factor(j) * z.factor(k);
    size_t place = block.placeOf(offset + static_cast<uint32_t>(__builtin_ctzll(row)));
    for (; row != 0; row &= row - 1, ++place)
    {
      const int32_t i = first.x + __builtin_ctzll(row) - x.first;
      const float factor = kernel_.fromFactors(yz, x.factor(i));
      sums[static_cast<size_t>(i % 4)] += factor * block.meanAt(place);
      result.reached = result.reached || factor > 0;
    }
  };
  for (int32_t k = 0; k < z.count(); ++k)
    for (int32_t j = 0; j < y.count(); ++j)
      for (int32_t i = low.x; i <= x.last() >> kBits; ++i)
      {
        const CellIndex first{i * kScanBlockEdge, y.first + j, z.first + k};
        if (const auto& block = blocks[numberOf(i, first.y >> kBits, first.z >> kBits)])
          addRow(*block, first, j, k);
      }
  result.logodds = (sums[0] + sums[1]) + (sums[2] + sums[3]);
  return result;
}

}  // namespace lamap
