#pragma once

#include <lamap_core/features/lattice.h>
#include <lamap_core/features/logodds.h>
#include <lamap_core/grid/cell.h>
#include <lamap_core/hilbert/options.h>
#include <lamap_core/scan/ray_selection.h>
#include <lamap_core/scan/scan.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace lamap
{
class MapModel;
struct HilbertState;
struct PointAtSite;

/** A Hilbert map with one model (thesis 2.4): logistic regression on features of place, P = 1/(1 + e^−f).
 *
 * `Incremental`: a lattice fixed to the map has a Gaussian posterior (μ, Λ) for the weight of each feature;
 * a scan minimizes Σ w·loss + ½ΣΛⱼ(uⱼ − μⱼ)² from μ and then adds Σ w·p(1 − p)·F² to Λ, Laplace's
 * approximation. Depends on the order of scans by construction.
 *
 * With training points at the centres of cells, what the model says is the prior of what the rays of each
 * cell said by themselves, see SeenCells.
 *
 * Invariants: log-odds are 0 and a cell has no evidence where no feature reaches; for any number of threads
 * and on any processor the same bits; moving all scans by whole cells that are whole sites moves a map of
 * compact features, bit by bit where points are farther than 1e-6 m from the faces of cells.
 * With Nyström's features, evidence is where a site of the lattice that held a training point is no more than
 * the kernel's support away along each axis.
 *
 * Thread guarantee: const methods may be called from several threads as long as nobody changes the map.
 */
class HilbertMap
{
 public:
  /// @throws std::invalid_argument as HilbertStructure::validate().
  explicit HilbertMap(const HilbertStructure& structure = {});
  HilbertMap(const HilbertMap& other);
  HilbertMap& operator=(const HilbertMap& other);
  HilbertMap(HilbertMap&&) noexcept;
  HilbertMap& operator=(HilbertMap&&) noexcept;
  ~HilbertMap();

  [[nodiscard]] const HilbertStructure& structure() const { return structure_; }

  /** Learns one scan.
   * @param uncertainty of its points, in the map's frame; null: none
   * @param threads how many may work; 0: as many as the machine has. Never changes the result.
   * @return what became of its rays; nothing is changed if none was usable.
   * @throws std::invalid_argument as the options' validate(); std::length_error if the scan reaches too many
   *  cells. Whatever is thrown, the map is as it was. */
  RayCounts insert(const Scan& scan, const HilbertInference& inference,
                   const HilbertUncertainty* uncertainty = nullptr, unsigned threads = 0);

  void clear();
  [[nodiscard]] bool empty() const;

  /// `Batch`: whether points were inserted that no model was trained on yet; the next query trains one,
  /// with the options and the number of threads of the last insertion.
  [[nodiscard]] bool isStale() const;
  /// Trains now if it is stale. @throws std::length_error if features would not fit into memory.
  void train(unsigned threads = 0) const;

  /// Log-odds at a point [m]; nothing where no feature reaches. The height does not matter in a planar map.
  [[nodiscard]] std::optional<double> logoddsAt(const Eigen::Vector3d& point_map) const;
  /** Expected log-odds at an uncertain point; the rays of its cell count if its standard deviation, over all
   * axes, is at most 2.5 cells. @param covariance [m²] */
  [[nodiscard]] std::optional<double> logoddsAt(const Eigen::Vector3d& point_map,
                                                const Eigen::Matrix3d& covariance) const;
  /// At the centre of a cell.
  [[nodiscard]] std::optional<double> logoddsOf(const CellIndex& cell) const;
  /// At many points, in their order.
  void logoddsAt(const std::vector<Eigen::Vector3d>& points_map, std::vector<ReachedLogodds>& out) const;
  /// At the centres of the cells in a box, x fastest, then y, then z. Where cells cannot be addressed:
  /// nothing.
  void logoddsOf(const CellIndex& first, const std::array<int, 3>& counts,
                 std::vector<ReachedLogodds>& out) const;

  /// What the map says at a point [m], or of a cell; nothing where no feature reaches.
  [[nodiscard]] std::optional<CellEstimate> at(const Eigen::Vector3d& point_map,
                                               const StateThresholds& thresholds) const;
  [[nodiscard]] std::optional<CellEstimate> cell(const CellIndex& cell,
                                                 const StateThresholds& thresholds) const;
  using EstimateVisitor = std::function<void(const CellIndex&, const CellEstimate&)>;
  /// As visitCells() below.
  void visitCells(const StateThresholds& thresholds, const EstimateVisitor& visitor,
                  unsigned threads = 1) const;

  using CellVisitor = std::function<void(const CellIndex&, double logodds)>;
  /// Every cell whose centre a feature reaches, once, in no promised order. @param threads as insert()
  void visitCells(const CellVisitor& visitor, unsigned threads = 1) const;

  /// The smallest and the largest index of these cells along each axis. Without a walk of them, unless
  /// training points were uncertain: then cells at the faces of a larger box are asked.
  [[nodiscard]] std::optional<std::pair<CellIndex, CellIndex>> cellBounds() const;
  /// A cube of 2^n cells around a cell, aligned to its size, and those beside it hold none of these cells.
  /// @return the largest n that is known, or 0
  [[nodiscard]] int emptyAround(const CellIndex& cell) const;

  [[nodiscard]] size_t weightCount() const;         ///< features of the model
  [[nodiscard]] size_t trainingPointCount() const;  ///< kept, `Batch` only
  [[nodiscard]] size_t memoryBytes() const;

  /// What was learned; trains first if it is stale.
  [[nodiscard]] HilbertState state() const;
  /** Takes what another map of the same structure had learned: from then on, both behave alike.
   * @throws std::invalid_argument saying what does not fit the structure or is no legal state. */
  void restore(const HilbertState& state);

  /// The lattice, for statistics.
  [[nodiscard]] const HilbertLattice<SitePosterior>& lattice() const;

 private:
  /// The model and, for `Batch`, what it is trained on.
  struct Learned;
  struct Sampling;

  [[nodiscard]] const MapModel& trained() const;
  void addScansAt(const Eigen::Vector3d& point_map, ReachedLogodds& said) const;
  [[nodiscard]] bool isAnyReached(const std::array<int32_t, 3>& low,
                                  const std::array<int32_t, 3>& high) const;
  [[nodiscard]] std::optional<PointAtSite> placeOf(const Eigen::Vector3d& point_map) const;

  HilbertStructure structure_;
  std::unique_ptr<Learned> learned_;
  std::unique_ptr<Sampling> sampling_;  ///< made by the first insert()
};

}  // namespace lamap
