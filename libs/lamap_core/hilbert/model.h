#pragma once

#include <lamap_core/features/lattice.h>
#include <lamap_core/features/logodds.h>
#include <lamap_core/features/rows.h>
#include <lamap_core/hilbert/options.h>
#include <lamap_core/hilbert/state.h>
#include <lamap_core/learning/solver.h>
#include <lamap_core/math/workers.h>
#include <lamap_core/scan/lattice_frame.h>
#include <lamap_core/training/hilbert_training.h>

#include <memory>
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
 * The lattice holds every site that held a training point, with whatever is known of its weight. */
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
  virtual void learn(HilbertTrainingSet& set, const HilbertFrame& frame, const HilbertInference& inference,
                     const Workers& workers) = 0;

  [[nodiscard]] virtual ReachedLogodds at(const PointAtSite& point) const = 0;
  /// Expected log-odds at an uncertain point. @param covariance [m²]
  [[nodiscard]] virtual ReachedLogodds at(const PointAtSite& point,
                                          const Eigen::Matrix3d& covariance) const = 0;
  /// @param points [m] from the lowest corner of the anchor site; @param out as many, x fastest
  virtual void atRegular(const CellIndex& anchorSite, const RegularPoints& points,
                         std::vector<ReachedLogodds>& out) const = 0;

  [[nodiscard]] virtual size_t weightCount() const = 0;
  [[nodiscard]] virtual size_t memoryBytes() const { return lattice_.memoryBytes(); }
  [[nodiscard]] const HilbertLattice<SitePosterior>& lattice() const { return lattice_; }

  /// Gives the working memory of learn() back.
  void freeWorkspace() { work_ = std::make_unique<Workspace>(); }

  /// Writes what was learned.
  virtual void save(HilbertState& state) const;
  /// Takes it. @throws std::invalid_argument as HilbertMap::restore()
  virtual void restore(const HilbertState& state);

 protected:
  explicit MapModel(const HilbertStructure& structure) : structure_(structure), kernel_(structure.kernel()) {}
  MapModel(const MapModel& other)
      : structure_(other.structure_),
        kernel_(other.kernel_),
        lattice_(other.lattice_),
        sgdSteps_(other.sgdSteps_)
  {
  }
  MapModel& operator=(const MapModel&) = delete;

  using Growth = LatticeGrowth<SitePosterior>;
  /// Adds the sites of a set to the lattice, those that are not there yet with this weight.
  static void addSites(const SiteSet& sites, const HilbertFrame& frame, const SitePosterior& weight,
                       Growth& growth);
  /// Finds the best weights, from `weights` on. @return what sgdSteps_ then is
  [[nodiscard]] uint64_t solve(const LogisticProblem& problem, const HilbertInference& inference,
                               const Workers& workers, std::vector<float>& weights);

  HilbertStructure structure_;
  CompactKernel kernel_;
  HilbertLattice<SitePosterior> lattice_;
  uint64_t sgdSteps_ = 0;

  /// Of learn(), kept between scans; a copy begins with its own.
  struct Workspace
  {
    CompactRows compact;
    SiteSet reached;
    Solver solver;
    std::vector<float> mean, precision, weights, curvature;
  };
  std::unique_ptr<Workspace> work_ = std::make_unique<Workspace>();
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
