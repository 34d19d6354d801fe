#pragma once

#include <lamap_core/features/compact_kernel.h>
#include <lamap_core/features/lattice.h>
#include <lamap_core/features/nystroem.h>

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

namespace lamap
{
/// Log-odds at a point, and whether any feature reaches it; exactly 0 where none does.
struct ReachedLogodds
{
  float logodds = 0;
  bool reached = false;
};

/** Log-odds at one point, to the last bit those of CompactQuery; allocates nothing.
 * @param point [m] from the lowest corner of the anchor site */
template <typename Weight>
[[nodiscard]] ReachedLogodds compactLogoddsAt(const HilbertLattice<Weight>& lattice,
                                              const CompactKernel& kernel, double spacing_m, bool planar,
                                              const CellIndex& anchorSite, const Eigen::Vector3d& point);

/** Reads log-odds f(x) = Σⱼ uⱼ·k(|x − cⱼ|) from the weights of compact features.
 *
 * Positions are in metres from the lowest corner of an anchor site. A point by itself, in a list or in a
 * block has the same log-odds to the last bit, wherever the anchor is. Keeps working memory: not to be shared
 * between threads. */
class CompactQuery
{
 public:
  /// @param weights must outlive the query. @throws std::invalid_argument as AxisReaches.
  CompactQuery(const SiteWeights& weights, const CompactKernel& kernel, double spacing_m, bool planar);

  [[nodiscard]] ReachedLogodds at(const CellIndex& anchorSite, const Eigen::Vector3d& point);

  /// Expected log-odds at an uncertain point, see CompactKernel. @param covariance [m²]
  [[nodiscard]] ReachedLogodds at(const CellIndex& anchorSite, const Eigen::Vector3d& point,
                                  const Eigen::Matrix3d& covariance);

  /// @param out as many as points, in their order
  void atList(const CellIndex& anchorSite, const std::vector<Eigen::Vector3d>& points,
              std::vector<ReachedLogodds>& out);

  /** At regular points, x fastest, then y, then z: 8³ cells a call are a good size, more are cut up.
   *  In a planar map only counts[2] = 1 makes sense; the height does not matter. */
  void atRegular(const CellIndex& anchorSite, const RegularPoints& points, std::vector<ReachedLogodds>& out);

 private:
  struct Row
  {
    float yz;      ///< factor of the kernel
    size_t begin;  ///< of the row in the box
  };

  void windowsOf(const Eigen::Vector3d& first, double step, const std::array<int, 3>& counts);
  void listRows(const AxisWindow& y, const AxisWindow& z, float largestX);
  [[nodiscard]] ReachedLogodds sumRows(const AxisWindow& x) const;
  [[nodiscard]] bool reaches(const AxisWindow& x) const;
  void tileAt(const CellIndex& anchorSite, const RegularPoints& points, const std::array<int, 3>& from,
              const std::array<int, 3>& counts, std::vector<ReachedLogodds>& out);

  const SiteWeights& weights_;
  CompactKernel kernel_;
  double spacing_m_;
  bool planar_;
  AxisReaches reaches_;
  SiteBox box_;
  std::vector<Row> rows_;
  std::array<std::vector<AxisWindow>, 3> windows_;
  std::array<std::vector<AxisReach>, 3> held_;  ///< what windows_ point at
};

template <typename Weight>
ReachedLogodds compactLogoddsAt(const HilbertLattice<Weight>& lattice, const CompactKernel& kernel,
                                double spacing_m, bool planar, const CellIndex& anchorSite,
                                const Eigen::Vector3d& point)
{
  std::array<AxisReach, 2> held;
  AxisReach alongZ;
  const auto windowOf = [&](double coordinate, int32_t anchor, AxisReach& reach)
  {
    const int32_t site = AxisReaches::find(kernel, spacing_m, coordinate, reach);
    return AxisWindow{site + anchor + reach.first, &reach};
  };
  const AxisWindow x = windowOf(point.x(), anchorSite.x, held[0]);
  const AxisWindow y = windowOf(point.y(), anchorSite.y, held[1]);
  const AxisWindow z = planar ? AxisReaches::flat() : windowOf(point.z(), anchorSite.z, alongZ);

  constexpr int kBits = kScanBlockLog2Edge;
  // A window of kMaxSites sites lies in three blocks along an axis at most.
  std::array<const typename HilbertLattice<Weight>::Block*, 27> blocks{};
  const BlockIndex low{x.first >> kBits, y.first >> kBits, z.first >> kBits};
  for (int32_t k = low.z; k <= z.last() >> kBits; ++k)
    for (int32_t j = low.y; j <= y.last() >> kBits; ++j)
      for (int32_t i = low.x; i <= x.last() >> kBits; ++i)
        blocks[static_cast<size_t>(((k - low.z) * 3 + (j - low.y)) * 3 + (i - low.x))] =
            lattice.find(BlockIndex{i, j, k});

  std::array<float, 4> sums{};
  ReachedLogodds result;
  for (int32_t k = 0; k < z.count(); ++k)
    for (int32_t j = 0; j < y.count(); ++j)
    {
      const float yz = y.factor(j) * z.factor(k);
      if (!(kernel.fromFactors(yz, 1.0f) > 0)) continue;
      for (int32_t i = 0; i < x.count(); ++i)
      {
        const CellIndex site{x.first + i, y.first + j, z.first + k};
        const auto* block =
            blocks[static_cast<size_t>((((site.z >> kBits) - low.z) * 3 + ((site.y >> kBits) - low.y)) * 3 +
                                       ((site.x >> kBits) - low.x))];
        const uint32_t offset = SiteSet::offsetOf(site);
        if (block == nullptr || !block->has(offset)) continue;
        const float factor = kernel.fromFactors(yz, x.factor(i));
        sums[static_cast<size_t>(i % 4)] += factor * meanOf(block->weights[block->placeOf(offset)]);
        result.reached = result.reached || factor > 0;
      }
    }
  result.logodds = (sums[0] + sums[1]) + (sums[2] + sums[3]);
  return result;
}

}  // namespace lamap
