#pragma once

#include <lamap_core/hilbert_kernel.h>
#include <lamap_core/hilbert_lattice.h>
#include <lamap_core/hilbert_nystroem.h>

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

}  // namespace lamap
