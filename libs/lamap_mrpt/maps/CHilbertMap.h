#pragma once

#include <lamap_core/hilbert/map.h>
#include <lamap_core/hilbert/options.h>
#include <lamap_mrpt/compat/mrpt_compat.h>
#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <lamap_mrpt/maps/uncertain_inputs.h>
#include <mrpt/maps/TMetricMapInitializer.h>
#include <mrpt/serialization/CSerializable.h>

#include <optional>
#include <string>
#include <vector>

namespace lamap
{
/** 3D occupancy map by one logistic regression in a Hilbert space of features (Hilbert map), thesis sections
 * 2.4 and 3, as an MRPT map: incremental by Laplace's approximation, of all scans together, or by stochastic
 * gradient descent.
 *
 * In .ini files: hilbertMap_count=1, and sections <prefix>_hilbertMap_00_creationOpts, _insertOpts,
 * _likelihoodOpts and _renderOpts. The map is continuous: estimateAt() answers at the point itself, and cells
 * are a view of it, read at their centres. Stored whole: the model, every option, and with `training = batch`
 * all training points.
 *
 * Takes the observations of supportsObservation(); others are refused when inserted, and their likelihood is
 * 0.
 */
class CHilbertMap : public CLearnedMap
{
  DEFINE_SERIALIZABLE(CHilbertMap, lamap)

 public:
  /// Named sets of options.
  enum class Preset
  {
    Default,
    Thesis  ///< global Hilbert map (thesis 3.2): batch, 100 Nyström components, SGD with L1, points as they
            ///< are
  };

  /// What the map is made with; fixed for its life.
  struct TCreationOptions : public TOptionGroup, public HilbertStructure
  {
    /// Where the other options started from; kept as a record.
    Preset preset = Preset::Default;

    [[nodiscard]] const OptionTable& optionTable() const override;
    void validate() const override { HilbertStructure::validate(); }

   protected:
    std::vector<std::string> foreignFlags() const override;
  };

  /// How observations are learned; may be changed at any time.
  struct TInsertionOptions : public TOptionGroup, public HilbertInference, public UncertainInputs
  {
    [[nodiscard]] const OptionTable& optionTable() const override;
    /// With what the training decides filled in. @throws std::invalid_argument if the two do not fit together
    [[nodiscard]] TInsertionOptions resolved(const HilbertStructure& structure) const;
  };
  TInsertionOptions insertionOptions;

  explicit CHilbertMap(double resolution_m = 0.10);
  /// @throws std::invalid_argument naming an illegal option.
  explicit CHilbertMap(const TCreationOptions& options);

  [[nodiscard]] const TCreationOptions& creationOptions() const { return creationOptions_; }

  /// The map itself, without MRPT.
  [[nodiscard]] const HilbertMap& core() const { return map_; }

  /** Expected log-odds at an uncertain point of the map frame (thesis 3.2.4).
   * @param covariance [m²], symmetric, positive semidefinite
   * @return nothing where no feature reaches */
  [[nodiscard]] std::optional<double> expectedLogoddsAt(const mrpt::math::TPoint3D& point_map,
                                                        const mrpt::math::CMatrixDouble33& covariance) const;

  // CLearnedMap
  [[nodiscard]] double resolution() const override { return map_.structure().resolution; }
  [[nodiscard]] std::optional<CellEstimate> estimateAt(const mrpt::math::TPoint3D& point_map) const override;
  [[nodiscard]] std::optional<CellEstimate> estimateCell(const CellIndex& cell) const override;
  void visitCells(const CellVisitor& visitor) const override;
  [[nodiscard]] std::vector<std::string> evidenceNames() const override { return {"logodds"}; }
  [[nodiscard]] std::string alias() const override { return "hilbertMap"; }
  [[nodiscard]] std::vector<Fact> facts() const override;
  [[nodiscard]] size_t memoryBytes() const override { return map_.memoryBytes(); }
  [[nodiscard]] std::optional<int32_t> planarLayer() const override;
  [[nodiscard]] StateThresholds stateThresholds() const override { return insertionOptions.thresholds; }
  [[nodiscard]] RangeLimits rangeLimits() const override { return insertionOptions.rangeLimits(); }
  /// @throws std::logic_error always: cells are a view of the model, there is nothing to write into.
  void updateVoxel(double x, double y, double z, bool occupied) override;
  void visitOptionGroups(const VisitGroup& visit) const override;

  // CMetricMap
  [[nodiscard]] bool isEmpty() const override { return map_.empty(); }

  MAP_DEFINITION_START(CHilbertMap)
  TCreationOptions creationOpts;
  TInsertionOptions insertionOpts;
  TLikelihoodOptions likelihoodOpts;
  TRenderingOptions renderingOpts;
  void usePreset();
  [[nodiscard]] TInsertionOptions resolvedInsertion() const;
  /// As loadFromConfigFile() reads it, with what other options decide filled in.
  void saveToConfigFile(mrpt::config::CConfigFileBase& target,
                        const std::string& sectionPrefix) const override;
  MAP_DEFINITION_END(CHilbertMap)

 private:
  void internal_clear() override;
  RayCounts learnScan(const Scan& scan, const ScanPose& pose) override;
  [[nodiscard]] CellEstimate estimate(double logodds) const;

  TCreationOptions creationOptions_;
  HilbertMap map_;
};

}  // namespace lamap
