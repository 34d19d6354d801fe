#pragma once

#include <lamap_core/bgk/options.h>
#include <lamap_core/grid/block_grid.h>
#include <lamap_core/grid/cell.h>
#include <lamap_core/scan/ray_selection.h>
#include <lamap_core/scan/scan.h>

#include <functional>
#include <memory>
#include <optional>

namespace lamap
{
class BgkScanInference;
struct OctantRule;

/** BGK occupancy map: Bayesian generalized kernel inference (thesis chapter 4) on a grid of test-data
 * octrees.
 *
 * A cell holds the sums ȳ and k̄ − ȳ (eq. 4.5, 4.6) of every scan, as two integers with 20 fractional bits;
 * the prior is kept apart. A scan's sums are formed first, without rounding that depends on an order, rounded
 * once and added.
 *
 * Invariants: the evidence of a cell is positive exactly where a training point lies within the support of
 * the kernel; any order, batching and merging of the same scans gives the same map (pruning none or
 * lossless), for any number of threads; cells without evidence have the prior.
 *
 * Thread guarantee: const methods may be called from several threads as long as nobody changes the map.
 */
class BgkMap
{
 public:
  /// @throws std::invalid_argument as BgkStructure::validate().
  explicit BgkMap(const BgkStructure& structure = {});
  BgkMap(const BgkMap& other);
  BgkMap& operator=(const BgkMap& other);
  BgkMap(BgkMap&&) noexcept;
  BgkMap& operator=(BgkMap&&) noexcept;
  ~BgkMap();

  [[nodiscard]] const BgkStructure& structure() const { return structure_; }

  /** Adds one scan (eq. 4.3, 4.4).
   * @param threads how many may work; 0: as many as the machine has. Never changes the result.
   * @return what became of its rays; nothing is changed if none was usable.
   * @throws std::invalid_argument as BgkInference::validate(); std::overflow_error if a count would pass
   * 2^63. */
  RayCounts insert(const Scan& scan, const BgkInference& inference, unsigned threads = 0);

  /** Adds all evidence of another map, as if its scans had been inserted here.
   * @throws std::invalid_argument if its structure (the prior and pruning apart) differs. */
  void merge(const BgkMap& other, const StateThresholds& thresholds);

  /// Forgets all evidence; structure and prior map stay.
  void clear();
  [[nodiscard]] bool empty() const { return grid_.blockCount() == 0; }

  /** Makes another map the prior: α₀ and β₀ of a cell that has evidence there are its α and β
   * (thesis 4.2.1, 5.1).
   * @throws std::invalid_argument if its resolution or planar layer differs. */
  void setPriorMap(std::shared_ptr<const BgkMap> prior);
  [[nodiscard]] const std::shared_ptr<const BgkMap>& priorMap() const { return priorMap_; }

  /// α, β and what follows from them; nothing where neither this map nor its prior map has evidence.
  [[nodiscard]] std::optional<CellEstimate> cell(const CellIndex& index,
                                                 const StateThresholds& thresholds) const;
  /// The same at a point [m]. In a planar map the height of the point does not matter.
  [[nodiscard]] std::optional<CellEstimate> at(const Eigen::Vector3d& point_m,
                                               const StateThresholds& thresholds) const;

  using CellVisitor = std::function<void(const CellIndex&, const CellEstimate&)>;
  /// Every finest cell that has evidence here or in the prior map, once, in no promised order.
  void visitCells(const StateThresholds& thresholds, const CellVisitor& visitor) const;

  /** Adds pseudo-counts to one cell directly, e.g. a cell known from elsewhere. Counts are rounded to 2^-20.
   * @param alpha, beta [pseudo-counts], finite, ≥ 0
   * @throws std::invalid_argument naming the count; std::overflow_error as insert(). */
  void addEvidence(const CellIndex& index, double alpha, double beta, const StateThresholds& thresholds);

  /// The evidence itself, for files and statistics.
  [[nodiscard]] const BlockGrid& grid() const { return grid_; }
  [[nodiscard]] BlockGrid& grid() { return grid_; }

  /// The layer of cells of a planar map.
  [[nodiscard]] int32_t planarLayer() const { return planarLayer_; }
  [[nodiscard]] size_t memoryBytes() const { return grid_.memoryBytes(); }

  /// α₀ and β₀ of a cell, from the prior map where it has evidence.
  [[nodiscard]] std::array<double, 2> priorOf(const CellIndex& index) const;

 private:
  [[nodiscard]] OctantRule ruleFor(const BlockIndex& block, const StateThresholds& thresholds) const;
  [[nodiscard]] CellEstimate estimate(const std::array<double, 2>& prior, const Evidence& evidence,
                                      const StateThresholds& thresholds) const;

  BgkStructure structure_;
  int32_t planarLayer_ = 0;
  BlockGrid grid_;
  std::shared_ptr<const BgkMap> priorMap_;
  std::unique_ptr<BgkScanInference> inference_;  ///< working memory of insert(), kept between scans
};

/// Eq. (4.1): mean; eq. (4.2): variance; eq. (4.9): state.
[[nodiscard]] double bgkMean(double alpha, double beta);
[[nodiscard]] double bgkVariance(double alpha, double beta);
[[nodiscard]] CellState bgkState(double mean, double variance, const StateThresholds& thresholds);

}  // namespace lamap
