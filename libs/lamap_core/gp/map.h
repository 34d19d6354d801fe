#pragma once

#include <lamap_core/gp/options.h>
#include <lamap_core/grid/block_grid.h>
#include <lamap_core/grid/cell.h>
#include <lamap_core/scan/ray_selection.h>
#include <lamap_core/scan/scan.h>

#include <functional>
#include <memory>
#include <optional>

namespace lamap
{
class GpScanInference;
struct OctantRule;

/** Gaussian process occupancy map (thesis section 2.3) on a grid of test-data octrees: exact GPs on the
 * blocks of each scan, fused by a Bayesian committee machine. The baseline of the thesis's chapter 4.
 *
 * A cell holds the sums of 1/σ² − 1/σ_f² and of μ/σ² over the GPs that spoke of it, or its log-odds
 * (GpFusion), as whole numbers of 2^-20.
 *
 * Invariants: cells beyond the support of all data hold nothing; any order, batching and merging of the same
 * scans gives the same map (pruning none or lossless), to the byte, for any number of threads; n equal scans
 * give n times the evidence of one, so that any mean that is not zero grows into certainty (thesis eq. 4.23).
 *
 * Thread guarantee: const methods may be called from several threads as long as nobody changes the map.
 */
class GpMap
{
 public:
  /// @throws std::invalid_argument as GpStructure::validate().
  explicit GpMap(const GpStructure& structure = {});
  GpMap(const GpMap& other);
  GpMap& operator=(const GpMap& other);
  GpMap(GpMap&&) noexcept;
  GpMap& operator=(GpMap&&) noexcept;
  ~GpMap();

  [[nodiscard]] const GpStructure& structure() const { return structure_; }

  /** Adds one scan.
   * @param threads how many may work; 0: as many as the machine has. Never changes the result.
   * @return what became of its rays; nothing is changed if none was usable.
   * @throws std::invalid_argument as GpInference::validate(); std::overflow_error if a sum would pass 2^41;
   * std::length_error, with nothing changed, if the scan's rays are too long for cells of this size */
  RayCounts insert(const Scan& scan, const GpInference& inference, unsigned threads = 0);

  /** Adds all evidence of another map, as if its scans had been inserted here.
   * @throws std::invalid_argument if its structure (pruning apart) differs. */
  void merge(const GpMap& other, const StateThresholds& thresholds);

  /// Forgets all evidence; the structure stays.
  void clear() { grid_.clear(); }
  [[nodiscard]] bool empty() const { return grid_.blockCount() == 0; }

  /** What a cell says; nothing where no GP spoke of it.
   *
   * `prob` is eq. (2.25). With GpFusion::Bcm `variance` is that of f, eq. (2.29), and `evidence` holds its
   * inverse and the mean of f, eq. (2.28); with GpFusion::Bayes there is no variance, and `evidence` holds
   * the log-odds. */
  [[nodiscard]] std::optional<CellEstimate> cell(const CellIndex& index,
                                                 const StateThresholds& thresholds) const;
  /// The same for the cell at a point [m]. In a planar map the height of the point does not matter.
  [[nodiscard]] std::optional<CellEstimate> at(const Eigen::Vector3d& point_m,
                                               const StateThresholds& thresholds) const;

  using CellVisitor = std::function<void(const CellIndex&, const CellEstimate&)>;
  /// Every finest cell that has evidence, once, in no promised order.
  void visitCells(const StateThresholds& thresholds, const CellVisitor& visitor) const;

  /** Adds to a cell what a GP with one training point, at the cell's centre, says there.
   * @throws std::overflow_error as insert(). */
  void addObservation(const CellIndex& index, bool occupied, const StateThresholds& thresholds);

  /// The evidence itself, for files and statistics: see GpScanInference.
  [[nodiscard]] const BlockGrid& grid() const { return grid_; }
  [[nodiscard]] BlockGrid& grid() { return grid_; }

  /// The layer of cells of a planar map.
  [[nodiscard]] int32_t planarLayer() const { return planarLayer_; }
  [[nodiscard]] size_t memoryBytes() const { return grid_.memoryBytes(); }

 private:
  [[nodiscard]] OctantRule ruleFor(const StateThresholds& thresholds) const;
  [[nodiscard]] CellEstimate estimate(const Evidence& evidence, const StateThresholds& thresholds) const;

  GpStructure structure_;
  int32_t planarLayer_ = 0;
  BlockGrid grid_;
  std::unique_ptr<GpScanInference> inference_;  ///< working memory of insert(), kept between scans
};

}  // namespace lamap
