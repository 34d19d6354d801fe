#pragma once

#include <lamap_core/grid/cell_accessor.h>
#include <lamap_core/grid/evidence_map.h>
#include <lamap_core/math/workers.h>
#include <lamap_core/overlapping/model_index.h>
#include <lamap_core/overlapping/options.h>
#include <lamap_core/overlapping/pending_scans.h>
#include <lamap_core/overlapping/reading.h>
#include <lamap_core/scan/ray_selection.h>
#include <lamap_core/scan/scan.h>

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace lamap
{
class HilbertModelTrainer;
class ModelFusion;
extern template class EvidenceMap<OverlappingReading>;
extern template class CellAccessor<OverlappingReading>;

/** Overlapping Hilbert map (thesis chapter 3): one classifier per scan, fused by log-odds (eq. 3.1, prior
 * 0.5).
 *
 * Each model is trained in its sensor's frame and is rigid. It speaks of the cells in its box: of those in
 * its perceptual field with a weight, of the others with little to say. A cell holds the two sums; the second
 * is held to a limit and read only where no scan had the cell in its field. Sums are whole numbers of 2^-20.
 *
 * What a cell says: `evidence` holds its log-odds, and 1 where some scan had it in its field, else 0.
 *
 * Invariants: cells that no model speaks of hold nothing; any order, batching and merging of the same models
 * gives the same cells (pruning none or lossless), to the byte, for any number of threads; queries at points
 * read the same two sums from the models themselves, and agree with the cells at their centres.
 *
 * Thread guarantee: const methods may be called from several threads as long as nobody changes the map.
 */
class OverlappingHilbertMap : public EvidenceMap<OverlappingReading>
{
 public:
  /// @throws std::invalid_argument as OverlappingStructure::validate().
  explicit OverlappingHilbertMap(const OverlappingStructure& structure = {});

  /** Adds one scan (Algorithm 1). With scansPerModel > 1 it waits for that many scans, or for trainPending():
   * until then it affects neither cells nor queries. The model is trained in the sensor's frame, with its
   * origin where the rays come from; of scans that wait, in the first one's.
   * @param uncertainty of its points, axes and centre in the map; models are trained with the expected kernel
   * then. Null, or all zero: they are certain.
   * @param threads how many may work; 0: as many as the machine has. Never changes the result.
   * @return what became of its rays; nothing is changed if none was usable.
   * @throws std::invalid_argument as validate() of the options and of the uncertainty, and ModelPose::of();
   * std::length_error if the scan, together with those that wait, has too many cells or points. Nothing is
   * changed then: a scan that cannot be trained does not wait either. */
  RayCounts insert(const Scan& scan, const OverlappingInference& inference,
                   const HilbertUncertainty* uncertainty = nullptr, unsigned threads = 0);

  /// Trains the scans that wait, now. @return whether there were any
  bool trainPending(const OverlappingInference& inference, unsigned threads = 0);

  /** Forgets the scans that wait if they cannot be trained together, e.g. those of a file.
   * @return how many were forgotten */
  size_t dropUntrainable(const OverlappingInference& inference, unsigned threads = 0);
  /// Forgets the scans that wait.
  void dropPending() { pending_ = {}; }

  /** Adds all that another map holds, as if its scans had been inserted here after this map's own.
   * @throws std::invalid_argument if its structure (pruning apart) differs, or if it has scans that wait. */
  void merge(const OverlappingHilbertMap& other, const StateThresholds& thresholds);

  /// Forgets everything; the structure stays.
  void clear();
  /// Neither cells, nor models, nor scans that wait.
  [[nodiscard]] bool empty() const;

  /** The continuous map (thesis 3.3): the models' own answer at a point [m], and what addEvidence() told the
   * cell that holds it. At the centres of cells the same as cell(), but for pruning by state.
   * @throws std::logic_error if the map does not keep its models */
  [[nodiscard]] std::optional<CellEstimate> continuousAt(const Eigen::Vector3d& point_m,
                                                         const StateThresholds& thresholds) const;

  /** The map at another resolution, from its models; what addEvidence() told cells is left behind.
   * @throws std::logic_error if the map does not keep its models; std::invalid_argument as validate() */
  [[nodiscard]] OverlappingHilbertMap resampled(double resolution_m, const StateThresholds& thresholds,
                                                unsigned threads = 0) const;

  /** Adds log-odds to one cell directly, as seen in a field. Rounded to 2^-20.
   * @param logodds within ±1000. @throws std::invalid_argument, std::overflow_error */
  void addEvidence(const CellIndex& index, double logodds, const StateThresholds& thresholds);

  [[nodiscard]] size_t modelCount() const { return models_.size(); }
  [[nodiscard]] Eigen::Isometry3d modelPose(size_t model) const;

  using MovedModel = std::pair<size_t, Eigen::Isometry3d>;
  /** Moves models to new poses, e.g. those that a pose graph found; then the cells are those of a map built
   * with the new poses. Only blocks that a moved model touches are worked out anew.
   * @throws std::out_of_range, std::invalid_argument as ModelPose::of(); nothing is changed then.
   * std::logic_error if the map does not keep its models */
  void setModelPoses(const std::vector<MovedModel>& moved, const StateThresholds& thresholds,
                     unsigned threads = 0);
  void setModelPose(size_t model, const Eigen::Isometry3d& pose, const StateThresholds& thresholds,
                    unsigned threads = 0)
  {
    setModelPoses({{model, pose}}, thresholds, threads);
  }

  // The whole state, for files: structure(), evidence(), writtenEvidence(), models() and pending().
  /// The part of it that came by addEvidence(), never pruned.
  [[nodiscard]] const Evidence& writtenEvidence() const { return written_; }
  [[nodiscard]] const std::vector<PlacedModel>& models() const { return models_; }
  [[nodiscard]] const PendingScans& pending() const { return pending_; }
  /// As EvidenceMap::restoreEvidence(). @param written the part of it that came by addEvidence()
  void restoreEvidence(Evidence&& evidence, Evidence&& written);
  /** Puts models and waiting scans in the place of those there, e.g. from a file; cells stay as they are.
   * @throws std::runtime_error if this map could not have them */
  void restore(std::vector<PlacedModel> models, PendingScans pending);

  /// Of the kept models alone.
  [[nodiscard]] size_t modelBytes() const;
  /// Of cells and models.
  [[nodiscard]] size_t memoryBytes() const;

  /// The same state to the last bit.
  friend bool operator==(const OverlappingHilbertMap& a, const OverlappingHilbertMap& b);

 private:
  /// Made when first asked for. Copies of a map share it until one of them changes.
  struct LazyIndex;

  void requireModels(const char* what) const;
  [[nodiscard]] const HilbertModelIndex& index() const;
  [[nodiscard]] CellSums sumsAt(const Eigen::Vector3d& point_m, const CellIndex& cell) const;
  /// @throws std::length_error if the scans that wait cannot be trained together
  void requireTrainable(const OverlappingInference& inference, const Workers& workers);
  /// @param wanted as in ModelFusion::infer()
  [[nodiscard]] Evidence inferModel(const HilbertModel& model, const ModelPose& pose,
                                    const std::vector<BlockIndex>* wanted, const Workers& workers);
  [[nodiscard]] Evidence fusedAnew(const std::vector<PlacedModel>& models,
                                   const std::vector<BlockIndex>& blocks, const StateThresholds& thresholds,
                                   const Workers& workers);

  ModelShape shape_;
  Evidence written_;
  std::vector<PlacedModel> models_;
  PendingScans pending_;
  std::shared_ptr<LazyIndex> index_;
  WorkingMemory<HilbertModelTrainer> trainer_;
  WorkingMemory<ModelFusion> fusion_;
  KeptWorkers workers_;
};

}  // namespace lamap
