#pragma once

#include <lamap_core/features/lattice.h>
#include <lamap_core/features/logodds.h>
#include <lamap_core/features/rows.h>
#include <lamap_core/grid/cell_cubes.h>
#include <lamap_core/hilbert/options.h>
#include <lamap_core/hilbert/point_widths.h>
#include <lamap_core/hilbert/site_reach.h>
#include <lamap_core/hilbert/state.h>
#include <lamap_core/learning/solver.h>
#include <lamap_core/math/workers.h>
#include <lamap_core/scan/lattice_frame.h>
#include <lamap_core/training/hilbert_training.h>

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <vector>

namespace lamap
{
/// A point by its place near an anchor site, so that numbers are small wherever on the map it is.
struct PointAtSite
{
  CellIndex anchorSite;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  ///< [m] from the lowest corner of the anchor site
};

/** What a HilbertMap has learned: weights of one kind of features, on a lattice that is fixed to the map.
 *
 * The lattice holds every site that held a training point, with whatever is known of its weight. A question
 * is as uncertain as the training points near it were, and as it says itself. */
class MapModel
{
 public:
  /// A model of the kind that the structure asks for, which has learned nothing.
  static std::unique_ptr<MapModel> make(const HilbertStructure& structure);
  virtual ~MapModel() = default;
  [[nodiscard]] virtual std::unique_ptr<MapModel> clone() const = 0;

  /** Learns a set on top of what is known.
   * @param set in `frame`; may be changed
   * @throws std::length_error if features would not fit into memory. Whatever is thrown, nothing is learned.
   */
  void learn(HilbertTrainingSet& set, const HilbertFrame& frame, const HilbertInference& inference,
             const Workers& workers);

  /// Where all points of a set are, and how far the farthest of them reach [m].
  struct Extent
  {
    Eigen::AlignedBox3d box_map;
    double reach_m = 0;
    void extend(const Extent& other);
  };
  [[nodiscard]] Extent extentOf(const HilbertTrainingSet& set, const HilbertFrame& frame) const;
  /// Whether learn() finds room for any set of so many points in an extent; false where it would have to be
  /// tried.
  [[nodiscard]] virtual bool isSurelyRoomFor(size_t points, const Extent& extent) const;
  /// @throws std::length_error as learn(), which it does not do
  virtual void requireRoomFor(const HilbertTrainingSet& set, const HilbertFrame& frame);

  [[nodiscard]] ReachedLogodds at(const PointAtSite& point) const;
  /// Expected log-odds at an uncertain point. @param covariance [m²]
  [[nodiscard]] ReachedLogodds at(const PointAtSite& point, const Eigen::Matrix3d& covariance) const;
  /// @param points [m] from the lowest corner of the anchor site; @param out as many, x fastest
  void atRegular(const CellIndex& anchorSite, const RegularPoints& points,
                 std::vector<ReachedLogodds>& out) const;

  [[nodiscard]] virtual size_t weightCount() const = 0;
  [[nodiscard]] virtual size_t memoryBytes() const
  {
    return lattice_.memoryBytes() + widths_.memoryBytes() + nearSites_.memoryBytes();
  }
  [[nodiscard]] const HilbertLattice<SitePosterior>& lattice() const { return lattice_; }
  /// The cells that its sites reach where nothing is uncertain.
  [[nodiscard]] const ReachedBox& reachedBox() const { return reached_; }
  /// Whether some questions are as uncertain as the training points were.
  [[nodiscard]] bool isUncertain() const { return !widths_.empty(); }
  /// As CellCubes::emptyAround(), of what sites may reach.
  [[nodiscard]] int emptyAround(const CellIndex& cell) const { return nearSites_.emptyAround(cell); }

  /// Gives the working memory of learn() back.
  void freeWorkspace() { work_ = std::make_unique<Workspace>(); }

  /// Writes what was learned.
  virtual void save(HilbertState& state) const;
  /// Takes it. @throws std::invalid_argument as HilbertMap::restore()
  virtual void restore(const HilbertState& state);

 protected:
  explicit MapModel(const HilbertStructure& structure)
      : structure_(structure), kernel_(structure.kernel()), widths_(structure)
  {
  }
  MapModel(const MapModel& other)
      : structure_(other.structure_),
        kernel_(other.kernel_),
        lattice_(other.lattice_),
        reached_(other.reached_),
        nearSites_(other.nearSites_),
        widths_(other.widths_),
        sgdSteps_(other.sgdSteps_)
  {
  }
  MapModel& operator=(const MapModel&) = delete;

  /// Learns the weights, as learn().
  virtual void learnWeights(HilbertTrainingSet& set, const HilbertFrame& frame,
                            const HilbertInference& inference, const Workers& workers) = 0;
  // What the weights say of points that are exactly there, or as uncertain as the covariance.
  [[nodiscard]] virtual ReachedLogodds saidAt(const PointAtSite& point) const = 0;
  [[nodiscard]] virtual ReachedLogodds saidAt(const PointAtSite& point,
                                              const Eigen::Matrix3d& covariance) const = 0;
  virtual void saidAtRegular(const CellIndex& anchorSite, const RegularPoints& points,
                             std::vector<ReachedLogodds>& out) const = 0;

  using Growth = LatticeGrowth<SitePosterior>;
  /// Adds the sites of a set to the lattice, those that are not there yet with this weight.
  /// @return what reachedBox() is with them
  [[nodiscard]] ReachedBox addSites(const SiteSet& sites, const HilbertFrame& frame,
                                    const SitePosterior& weight, Growth& growth);
  /// Finds the best weights, from `weights` on. @return what sgdSteps_ then is
  [[nodiscard]] uint64_t solve(const LogisticProblem& problem, const HilbertInference& inference,
                               const Workers& workers, std::vector<float>& weights);

  HilbertStructure structure_;
  CompactKernel kernel_;
  HilbertLattice<SitePosterior> lattice_;
  ReachedBox reached_;   ///< by the sites of the lattice
  CellCubes nearSites_;  ///< around all cells that these may reach, and perhaps more
  PointWidths widths_;
  uint64_t sgdSteps_ = 0;

  /// Of learn(), kept between scans; a copy begins with its own.
  struct Workspace
  {
    std::optional<SiteReach> siteReach;
    CompactRows compact;
    SiteSet reached;
    Solver solver;
    std::vector<float> mean, precision, weights, curvature;
  };
  std::unique_ptr<Workspace> work_ = std::make_unique<Workspace>();

 private:
  void extendReach(const BlockIndex& block, const SiteSet::Bits& sites, bool isNew, ReachedBox& reached);
};

/// Sites of a scan are counted from its anchor; shifted by this, their blocks are those of the lattice.
[[nodiscard]] inline CellIndex shiftOf(const CellIndex& anchorSite)
{
  constexpr int32_t kLow = kScanBlockEdge - 1;
  return {anchorSite.x & kLow, anchorSite.y & kLow, anchorSite.z & kLow};
}

/// A block of a scan's shifted sites, in the lattice.
[[nodiscard]] inline BlockIndex plusAnchor(const BlockIndex& block, const CellIndex& anchorSite)
{
  const BlockIndex anchor = SiteSet::blockOf(anchorSite);
  return {block.x + anchor.x, block.y + anchor.y, block.z + anchor.z};
}

/// Lowest corner of a site [m].
[[nodiscard]] inline Eigen::Vector3d cornerOf(const CellIndex& site, double spacing_m)
{
  return spacing_m * Eigen::Vector3d(site.x, site.y, site.z);
}

}  // namespace lamap
