#pragma once

#include <lamap_core/features/compact_sum.h>
#include <lamap_core/features/lattice.h>
#include <lamap_core/hilbert/options.h>
#include <lamap_core/hilbert/state.h>
#include <lamap_core/scan/lattice_frame.h>
#include <lamap_core/training/hilbert_training.h>

#include <vector>

namespace lamap
{
/** How surely the training points of a map are placed: the mean variance of those nearby, from errors of
 * poses, ranges and points. (The widths of beams are none: what lies between beams is there.)
 *
 * A model that was trained on uncertain points is asked with their variance, or it would be surer of an exact
 * point than its training points were placed. Sites of the lattice hold the sums of the weights and of the
 * weighted variances of the points in them, from their first uncertain point on; nothing is held while all
 * are certain.
 *
 * Thread guarantee: const methods may be called from several threads. */
class PointWidths
{
 public:
  explicit PointWidths(const HilbertStructure& structure);

  /// What a training point adds to its site.
  struct Share
  {
    CellIndex site;
    float weight;
    float variance;  ///< weighted [m²]
  };
  /// Makes room for a set, which changes nothing that is said. @param set in `frame`. @return what it adds
  [[nodiscard]] std::vector<Share> prepare(const HilbertTrainingSet& set, const HilbertFrame& frame);
  /// Adds what there is room for. Cannot fail.
  void add(const std::vector<Share>& shares);

  [[nodiscard]] bool empty() const { return weights_.blockCount() == 0; }
  /// [m²] of the points near a place, the same along all axes; 0 if they are certain, and for the height in a
  /// planar map. @param place [m] from the anchor site's lowest corner
  [[nodiscard]] Eigen::Matrix3d covarianceAt(const CellIndex& anchorSite, const Eigen::Vector3d& place) const;

  [[nodiscard]] size_t memoryBytes() const { return weights_.memoryBytes() + variances_.memoryBytes(); }

  void save(HilbertState& state) const;
  /// @throws std::invalid_argument saying what is wrong with the state
  void restore(const HilbertState& state);

 private:
  [[nodiscard]] CellIndex siteOf(const Eigen::Vector3d& point, const HilbertFrame& frame) const;

  bool planar_;
  CompactSum sum_;
  HilbertLattice<float> weights_;    ///< Σ w
  HilbertLattice<float> variances_;  ///< Σ w·variance [m²], of the same sites
};

}  // namespace lamap
