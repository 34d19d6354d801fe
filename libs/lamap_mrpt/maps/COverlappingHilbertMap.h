#pragma once

#include <lamap_core/overlapping/map.h>
#include <lamap_core/overlapping/options.h>
#include <lamap_mrpt/compat/mrpt_compat.h>
#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <lamap_mrpt/maps/uncertain_inputs.h>
#include <mrpt/maps/TMetricMapInitializer.h>
#include <mrpt/serialization/CSerializable.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace lamap
{
/** 3D occupancy map of overlapping Hilbert maps, thesis chapter 3, as an MRPT map: one logistic regression a
 * scan, fused by log-odds (Algorithm 1).
 *
 * In .ini files: overlappingHilbertMap_count=1, and sections <prefix>_overlappingHilbertMap_00_creationOpts,
 * _insertOpts, _likelihoodOpts and _renderOpts. While it keeps its models the map is continuous: estimateAt()
 * answers at the point itself, and models can be moved to poses that a pose graph found. Stored whole: cells,
 * models, scans that wait for others, every option.
 *
 * With scansPerModel > 1, scans wait until so many are there to train one model on; what is read from the map
 * meanwhile has them in it all the same, as if they were all that will come.
 *
 * Takes the observations of supportsObservation(); others are refused when inserted, and their likelihood is
 * 0.
 */
class COverlappingHilbertMap : public CLearnedMap
{
  DEFINE_SERIALIZABLE(COverlappingHilbertMap, lamap)

 public:
  /// What the map is made with; fixed for its life.
  struct TCreationOptions : public TOptionGroup, public OverlappingStructure
  {
    /// Where the other options started from; kept as a record.
    OverlappingPreset preset = OverlappingPreset::Default;

    [[nodiscard]] const OptionTable& optionTable() const override;
    void validate() const override { OverlappingStructure::validate(); }

   protected:
    std::vector<std::string> foreignFlags() const override;
  };

  /// How observations become models and these become evidence; may be changed at any time.
  struct TInsertionOptions : public TOptionGroup, public OverlappingInference, public UncertainInputs
  {
    [[nodiscard]] const OptionTable& optionTable() const override;
    void validate() const override { OverlappingInference::validate(); }
  };
  TInsertionOptions insertionOptions;

  explicit COverlappingHilbertMap(double resolution_m = 0.10);
  /// @throws std::invalid_argument naming an illegal option.
  explicit COverlappingHilbertMap(const TCreationOptions& options);

  [[nodiscard]] const TCreationOptions& creationOptions() const { return creationOptions_; }

  /// The map itself, without MRPT; scans that wait are not in its cells.
  [[nodiscard]] const OverlappingHilbertMap& core() const { return map_; }

  /** Adds all that another map holds, as if its observations had been inserted here.
   * @throws std::invalid_argument if it is made of other cells or models, or has scans that wait. */
  void merge(const COverlappingHilbertMap& other);

  /// How many models the map keeps.
  [[nodiscard]] size_t modelCount() const { return map_.modelCount(); }
  /// Pose of a model's sensor in the map. @throws std::out_of_range
  [[nodiscard]] mrpt::poses::CPose3D modelPose(size_t model) const;
  /** Moves a model to where its sensor is now thought to have been, e.g. by a pose graph; the map is then the
   * one that would have been built with that pose.
   * @throws std::out_of_range, std::logic_error if creationOpts.keepModels is false; nothing is changed then
   */
  void setModelPose(size_t model, const mrpt::poses::CPose3D& sensor_map);

  // CLearnedMap
  [[nodiscard]] double resolution() const override { return map_.structure().resolution; }
  [[nodiscard]] std::optional<CellEstimate> estimateAt(const mrpt::math::TPoint3D& point_map) const override;
  [[nodiscard]] std::optional<CellEstimate> estimateCell(const CellIndex& cell) const override;
  void visitCells(const CellVisitor& visitor) const override;
  [[nodiscard]] std::vector<std::string> evidenceNames() const override { return {"logodds"}; }
  [[nodiscard]] std::string alias() const override { return "overlappingHilbertMap"; }
  [[nodiscard]] std::vector<Fact> facts() const override;
  [[nodiscard]] size_t memoryBytes() const override { return map_.memoryBytes(); }
  [[nodiscard]] std::optional<int32_t> planarLayer() const override;
  [[nodiscard]] StateThresholds stateThresholds() const override { return insertionOptions.thresholds; }
  [[nodiscard]] RangeLimits rangeLimits() const override { return insertionOptions.rangeLimits(); }
  /// Adds fieldWeight · hitWeight to the cell's log-odds, or takes fieldWeight · freeWeight off.
  void updateVoxel(double x, double y, double z, bool occupied) override;
  void visitOptionGroups(const VisitGroup& visit) const override;

  // CMetricMap
  [[nodiscard]] bool isEmpty() const override { return map_.empty(); }

  MAP_DEFINITION_START(COverlappingHilbertMap)
  TCreationOptions creationOpts;
  TInsertionOptions insertionOpts;
  TLikelihoodOptions likelihoodOpts;
  TRenderingOptions renderingOpts;
  void usePreset();
  [[nodiscard]] TInsertionOptions resolvedInsertion() const;
  /// As loadFromConfigFile() reads it.
  void saveToConfigFile(mrpt::config::CConfigFileBase& target,
                        const std::string& sectionPrefix) const override;
  MAP_DEFINITION_END(COverlappingHilbertMap)

 private:
  void internal_clear() override;
  RayCounts learnScan(const Scan& scan, const ScanPose& pose) override;
  void cellsChanged();
  /// The map with the scans that wait in it.
  [[nodiscard]] std::shared_ptr<const OverlappingHilbertMap> whole() const;

  TCreationOptions creationOptions_;
  OverlappingHilbertMap map_;
  Lazy<OverlappingHilbertMap> withPending_;
};

}  // namespace lamap
