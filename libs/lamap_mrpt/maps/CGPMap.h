#pragma once

#include <lamap_core/gp/map.h>
#include <lamap_core/gp/options.h>
#include <lamap_mrpt/compat/mrpt_compat.h>
#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <mrpt/maps/TMetricMapInitializer.h>
#include <mrpt/serialization/CSerializable.h>

#include <optional>
#include <string>
#include <vector>

namespace lamap
{
/** 3D occupancy map by Gaussian process regression, thesis section 2.3, as an MRPT map: an exact GP on each
 * block of a scan, fused by a Bayesian committee machine. The baseline that chapter 4 of the thesis compares
 * BGK maps with; where a robot stands still it grows ever surer, and its walls ever thicker (section 4.3.3).
 *
 * In .ini files: gpMap_count=1, and sections <prefix>_gpMap_00_creationOpts, _insertOpts, _likelihoodOpts and
 * _renderOpts. Stored whole: evidence in full precision, every option.
 *
 * Takes the observations of supportsObservation(); others are refused when inserted, and their likelihood is
 * 0.
 */
class CGPMap : public CLearnedMap
{
  DEFINE_SERIALIZABLE(CGPMap, lamap)

 public:
  /// What the map is made with; fixed for its life.
  struct TCreationOptions : public TOptionGroup, public GpStructure
  {
    /// Where the other options started from; kept as a record.
    GpPreset preset = GpPreset::Default;

    [[nodiscard]] const OptionTable& optionTable() const override;
    void validate() const override { GpStructure::validate(); }

   protected:
    std::vector<std::string> foreignFlags() const override;
  };

  /// How observations become evidence; may be changed at any time. Lengths left empty are given in cells.
  struct TInsertionOptions : public TOptionGroup, public GpInference
  {
    TInsertionOptions() = default;
    explicit TInsertionOptions(const GpInference& inference) : GpInference(inference) {}

    [[nodiscard]] const OptionTable& optionTable() const override;
    /// What does not depend on the resolution; GpInference::validate() has the rest.
    void validate() const override;
  };
  TInsertionOptions insertionOptions;

  explicit CGPMap(double resolution_m = 0.10);
  /// @throws std::invalid_argument naming an illegal option.
  explicit CGPMap(const TCreationOptions& options);

  [[nodiscard]] const TCreationOptions& creationOptions() const { return creationOptions_; }

  /// The map itself, without MRPT.
  [[nodiscard]] const GpMap& core() const { return map_; }

  /** Adds all evidence of another map, as if its observations had been inserted here.
   * @throws std::invalid_argument if it was made with other creation options, pruning and preset apart. */
  void merge(const CGPMap& other);

  // CLearnedMap
  [[nodiscard]] double resolution() const override { return map_.structure().resolution; }
  [[nodiscard]] std::optional<CellEstimate> estimateAt(const mrpt::math::TPoint3D& point_map) const override;
  [[nodiscard]] std::optional<CellEstimate> estimateCell(const CellIndex& cell) const override;
  void visitCells(const CellVisitor& visitor) const override;
  /// The inverse variance and the mean of f; with creationOpts.fusion = bayes the log-odds.
  [[nodiscard]] std::vector<std::string> evidenceNames() const override;
  [[nodiscard]] std::string alias() const override { return "gpMap"; }
  [[nodiscard]] std::vector<Fact> facts() const override;
  [[nodiscard]] std::optional<int32_t> planarLayer() const override;
  [[nodiscard]] size_t memoryBytes() const override { return map_.grid().memoryBytes(); }
  [[nodiscard]] StateThresholds stateThresholds() const override { return insertionOptions.thresholds; }
  [[nodiscard]] RangeLimits rangeLimits() const override;
  /// Adds to the cell what a GP with one training point, at its centre, says there.
  void updateVoxel(double x, double y, double z, bool occupied) override;
  void visitOptionGroups(const VisitGroup& visit) const override;

  // CMetricMap
  [[nodiscard]] bool isEmpty() const override { return map_.empty(); }

  MAP_DEFINITION_START(CGPMap)
  TCreationOptions creationOpts;
  TInsertionOptions insertionOpts;
  TLikelihoodOptions likelihoodOpts;
  TRenderingOptions renderingOpts;
  void usePreset();
  [[nodiscard]] TInsertionOptions resolvedInsertion() const;
  /// As loadFromConfigFile() reads it, with what is left empty resolved.
  void saveToConfigFile(mrpt::config::CConfigFileBase& target,
                        const std::string& sectionPrefix) const override;
  MAP_DEFINITION_END(CGPMap)

 private:
  void internal_clear() override;
  RayCounts learnScan(const Scan& scan, const ScanPose& pose) override;

  TCreationOptions creationOptions_;
  GpMap map_;
};

}  // namespace lamap
