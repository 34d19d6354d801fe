#pragma once

#include <lamap_core/features/compact_sum.h>
#include <lamap_core/features/packed_sites.h>
#include <lamap_core/grid/evidence_block.h>
#include <lamap_core/overlapping/options.h>
#include <lamap_core/scan/depth_view.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace lamap
{
/** Where a model's frame lies in the map: its origin within an anchor cell, and its axes.
 *
 * Moving a model by whole cells changes the anchor alone. In a planar map poses turn about the vertical only
 * and heights do not matter. */
struct ModelPose
{
  CellIndex anchor;
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();      ///< of the origin, from the anchor's lowest corner
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< from the model's frame to the map's

  /** @param pose of the model's frame in the map [m]
   *  @throws std::invalid_argument unless the pose is finite, its rotation is one and cells can address it */
  static ModelPose of(const Eigen::Isometry3d& pose, double resolution_m, bool planar);
  /// @throws std::runtime_error if it is none that of() could have made, e.g. one from a file.
  void check(double resolution_m, bool planar) const;
  [[nodiscard]] Eigen::Isometry3d isometry(double resolution_m) const;

  /// @param fromAnchor_m position [m] from the anchor's lowest corner. @return [m] in the model's frame
  [[nodiscard]] Eigen::Vector3d toModel(const Eigen::Vector3d& fromAnchor_m) const;
  /// A vector from the map's axes to the model's, in an order of operations that is always the same.
  [[nodiscard]] Eigen::Vector3d turnedBack(const Eigen::Vector3d& d) const;
  /// A position [m] in the model's frame, from the anchor's lowest corner [m].
  [[nodiscard]] Eigen::Vector3d fromModel(const Eigen::Vector3d& p) const;

  friend bool operator==(const ModelPose& a, const ModelPose& b)
  {
    return a.anchor == b.anchor && a.offset_m == b.offset_m && a.rotation == b.rotation;
  }
};

/** What the models of a map have in common. */
struct ModelShape
{
  explicit ModelShape(const OverlappingStructure& structure);

  HilbertFeatures features;
  double gamma;      ///< [m⁻²]
  double cutoff;     ///< taken off the kernel; 0: nothing
  double support_m;  ///< the kernel is (`Nystroem`: all but) 0 from here on
  double spacing_m;  ///< of the lattice
  double resolution_m;
  bool planar;
  std::optional<CompactSum> sum;  ///< of compact features
  bool speaksOutOfField;          ///< does a model say anything outside of its field?

  /// What an uncertain question's log-odds are smaller by, see widened(). @param variance [m²]
  [[nodiscard]] double shareOf(double variance) const;
  /** The shape as a model whose training points have this variance along each axis is asked: the expected
   * kernel of a point x is share·exp(−γd²/(1 + 2γ·variance)), and the share is in the model's weights. */
  [[nodiscard]] ModelShape widened(double variance) const;
  /// The variance, or as much of it as leaves a kernel that the lattice can have.
  [[nodiscard]] double askable(double variance) const;

  [[nodiscard]] bool compact() const { return features == HilbertFeatures::Compact; }
  /// Height of all positions in the models of a planar map [m].
  [[nodiscard]] double flatHeight() const { return 0.5 * spacing_m; }
  /// Whether a position [m] is one that a model may have in its frame.
  [[nodiscard]] bool holds(const Eigen::Vector3d& p) const;
};

/** One classifier, trained on one scan (or several together), in a frame of its own: P(occupied) by log-odds
 * f(x) = bias + Σ weight·k(|x − centre|), with the box and the fields of view in which it speaks.
 *
 * Plain state; all positions in metres in the model's frame. */
struct HilbertModel
{
  PackedSites sites;  ///< `Compact`: weights are never 0
  // Nyström: inducing points and their weights.
  std::vector<Eigen::Vector3d> inducing;
  std::vector<float> kernelWeights;
  float bias = 0;

  Eigen::Vector3d boxLow = Eigen::Vector3d::Zero();
  Eigen::Vector3d boxHigh = Eigen::Vector3d::Zero();
  std::vector<DepthView> views;
  /** Where rays ended in cells that the weights alone call free, or nearly so. What the model says of such a
   * cell is at least kHitLogodds: the free space around a thin thing is far more than its hits. */
  std::vector<Eigen::Vector3f> hits;
  double fieldWeight = 1;  ///< of log-odds in the field
  /// Mean of the training points' variances along each axis [m²]: questions are as uncertain.
  double variance = 0;
  uint32_t scans = 1;  ///< it was trained on

  /// Smallest weight of a site: log-odds of exactly 0 mean that no feature reaches.
  static constexpr float kSmallestWeight = 0x1p-40f;

  [[nodiscard]] bool inBox(const Eigen::Vector3d& p, bool planar) const
  {
    const bool inPlane =
        p.x() >= boxLow.x() && p.x() <= boxHigh.x() && p.y() >= boxLow.y() && p.y() <= boxHigh.y();
    return inPlane && (planar || (p.z() >= boxLow.z() && p.z() <= boxHigh.z()));
  }
  /// What the views see of four places.
  [[nodiscard]] DepthView::Seen seen(const std::array<Eigen::Vector3d, 4>& places) const;

  /// Log-odds, at least, of a cell in which a ray of the model ended: P(occupied) is 0.73.
  static constexpr float kHitLogodds = 1.0f;
  /// Hits are kept up to these log-odds of their cells, for a model that moves may lie otherwise to the
  /// cells.
  static constexpr float kKeptHitLogodds = 1.5f;

  /// Leaves out the hits in whose cells the weights alone say enough. @param logodds of each hit's cell
  void keepWeakHits(const std::vector<float>& logodds);

  /// The cell of the map that holds each of `hits`, in their order; nothing where cells cannot address it.
  [[nodiscard]] std::vector<std::optional<CellIndex>> hitCells(const ModelPose& pose, const ModelShape& shape,
                                                               int32_t layer) const;

  /// Log-odds at a point; nothing where no feature reaches it.
  [[nodiscard]] std::optional<float> logoddsAt(const ModelShape& shape, const Eigen::Vector3d& p) const;

  /// Evidence from log-odds at a place in the box; none where the model does not speak. A place in the field
  /// that is not open (see DepthView) and that the log-odds call free counts as outside.
  [[nodiscard]] CellSums evidenceOf(const ModelShape& shape, float logodds, bool inField, bool open) const;
  /// What the model says of a point. @param inHitCell whether one of `hits` lies in the same cell of the map
  [[nodiscard]] CellSums evidenceAt(const ModelShape& shape, const Eigen::Vector3d& p, bool inHitCell) const;

  /// Calls visit(centre, weight) for each kernel.
  template <typename Visit>
  void forEachKernel(const ModelShape& shape, Visit&& visit) const;

  [[nodiscard]] size_t kernelCount() const { return sites.weights.size() + kernelWeights.size(); }
  [[nodiscard]] size_t memoryBytes() const;

  /// @throws std::runtime_error if it is no model that training could have left, e.g. one from a file. Where
  /// it is let in, no index that follows from it overflows.
  void check(const ModelShape& shape) const;

  friend bool operator==(const HilbertModel& a, const HilbertModel& b);
};

/// Log-odds, weighted, in units of 2^-20; those beyond ±1000 are held to that.
[[nodiscard]] int64_t logoddsUnits(float logodds, double weight);

template <typename Visit>
void HilbertModel::forEachKernel(const ModelShape& shape, Visit&& visit) const
{
  sites.forEach(
      [&](const CellIndex& site, float weight)
      {
        visit(Eigen::Vector3d((site.x + 0.5) * shape.spacing_m, (site.y + 0.5) * shape.spacing_m,
                              (site.z + 0.5) * shape.spacing_m),
              weight);
      });
  for (size_t k = 0; k < inducing.size(); ++k) visit(inducing[k], kernelWeights[k]);
}

}  // namespace lamap
