#pragma once

#include <lamap_core/bgk/map.h>
#include <lamap_core/bgk/options.h>
#include <lamap_mrpt/compat/mrpt_compat.h>
#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <mrpt/maps/TMetricMapInitializer.h>
#include <mrpt/serialization/CSerializable.h>

#include <optional>
#include <string>
#include <vector>

namespace lamap
{
/** 3D occupancy map by Bayesian generalized kernel inference (BGK), thesis chapter 4, as an MRPT map.
 *
 * In .ini files: bgkMap_count=1, and sections <prefix>_bgkMap_00_creationOpts, _insertOpts, _likelihoodOpts
 * and _renderOpts. Stored whole: evidence in full precision, every option, the prior map.
 *
 * Takes the observations of supportsObservation(); others are refused when inserted, and their likelihood is
 * 0.
 */
class CBGKMap : public CLearnedMap
{
  DEFINE_SERIALIZABLE(CBGKMap, lamap)

 public:
  /// What the map is made with; fixed for its life.
  struct TCreationOptions : public TOptionGroup, public BgkStructure
  {
    /// Where the other options started from; kept as a record.
    BgkPreset preset = BgkPreset::Default;
    /// Map file of a BGK map whose α and β are the prior where it has evidence; "" for none. Read when the
    /// map is made, and stored in it.
    std::string priorMap;

    [[nodiscard]] const OptionTable& optionTable() const override;
    void validate() const override { BgkStructure::validate(); }

   protected:
    std::vector<std::string> foreignFlags() const override;
  };

  /// How observations become evidence; may be changed at any time. Lengths left empty are given in cells.
  struct TInsertionOptions : public TOptionGroup, public BgkInference
  {
    TInsertionOptions() = default;
    explicit TInsertionOptions(const BgkInference& inference) : BgkInference(inference) {}

    [[nodiscard]] const OptionTable& optionTable() const override;
    /// What does not depend on the resolution; BgkInference::validate() has the rest.
    void validate() const override;
  };
  TInsertionOptions insertionOptions;

  explicit CBGKMap(double resolution_m = 0.10);
  /// @throws std::invalid_argument naming an illegal option; std::runtime_error if the prior map cannot be
  /// read.
  explicit CBGKMap(const TCreationOptions& options);

  [[nodiscard]] const TCreationOptions& creationOptions() const { return creationOptions_; }

  /// The map itself, without MRPT.
  [[nodiscard]] const BgkMap& core() const { return map_; }

  /** Adds all evidence of another map, as if its observations had been inserted here.
   * @throws std::invalid_argument if it is made of other cells. */
  void merge(const CBGKMap& other);

  // CLearnedMap
  [[nodiscard]] double resolution() const override { return map_.structure().resolution; }
  [[nodiscard]] std::optional<CellEstimate> estimateAt(const mrpt::math::TPoint3D& point_map) const override;
  [[nodiscard]] std::optional<CellEstimate> estimateCell(const CellIndex& cell) const override;
  void visitCells(const CellVisitor& visitor) const override;
  [[nodiscard]] std::vector<std::string> evidenceNames() const override { return {"alpha", "beta"}; }
  [[nodiscard]] std::string alias() const override { return "bgkMap"; }
  [[nodiscard]] std::vector<Fact> facts() const override;
  [[nodiscard]] size_t memoryBytes() const override { return map_.grid().memoryBytes(); }
  [[nodiscard]] std::optional<int32_t> planarLayer() const override;
  [[nodiscard]] StateThresholds stateThresholds() const override { return insertionOptions.thresholds; }
  [[nodiscard]] RangeLimits rangeLimits() const override;
  /// Adds kernelScale to α of the cell, or freeWeight · kernelScale to β.
  void updateVoxel(double x, double y, double z, bool occupied) override;
  void visitOptionGroups(const VisitGroup& visit) const override;

  // CMetricMap
  [[nodiscard]] bool isEmpty() const override { return map_.empty(); }

  MAP_DEFINITION_START(CBGKMap)
  TCreationOptions creationOpts;
  TInsertionOptions insertionOpts;
  TLikelihoodOptions likelihoodOpts;
  TRenderingOptions renderingOpts;
  void usePreset();
  [[nodiscard]] TInsertionOptions resolvedInsertion() const;
  /// As loadFromConfigFile() reads it, with the lengths that are given in cells resolved.
  void saveToConfigFile(mrpt::config::CConfigFileBase& target,
                        const std::string& sectionPrefix) const override;
  MAP_DEFINITION_END(CBGKMap)

 private:
  void internal_clear() override;
  RayCounts learnScan(const Scan& scan, const ScanPose& pose) override;

  TCreationOptions creationOptions_;
  BgkMap map_;
};

}  // namespace lamap
