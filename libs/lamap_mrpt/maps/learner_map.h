#pragma once

#include <lamap_core/options/option_table.h>
#include <lamap_mrpt/compat/mrpt_compat.h>
#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <lamap_mrpt/options/option_group.h>
#include <mrpt/maps/TMetricMapInitializer.h>
#include <mrpt/serialization/CSerializable.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace lamap
{
/** The types of a learner for LearnerMap, with what most learners have in common. Each learner derives its
 * own from it.
 * @tparam MapClass the class for MRPT
 * @tparam CoreMap the map in lamap_core
 * @tparam StructureOptions what a map is made with
 * @tparam InferenceOptions how scans are learned
 * @tparam Presets names for sets of both */
template <typename MapClass, typename CoreMap, typename StructureOptions, typename InferenceOptions,
          typename Presets>
struct LearnerTypes
{
  using Map = MapClass;
  using Core = CoreMap;
  using Structure = StructureOptions;
  using Creation = StructureOptions;  ///< with the options that only MRPT's class has
  using Insertion = InferenceOptions;
  using Preset = Presets;

  /// What a map that was read from a file does first. @return waiting scans that it cannot keep
  static size_t settle(Core& /*map*/, const Insertion& /*insertion*/, unsigned /*threads*/) { return 0; }

  static constexpr uint8_t kFormatVersion = 3;  ///< of map files; older ones are read too, see file-format.md

  static Core make(const Creation& creation) { return Core(creation); }
  /// Sets options that files of an older version may not hold to what their maps did.
  static void setAsBefore(Creation& /*creation*/, uint8_t /*version*/) {}
  /// @throws std::invalid_argument naming the first illegal option, its value and what is legal
  static void validate(const Insertion& insertion, const Structure& structure)
  {
    insertion.validate(structure.resolution);
  }
  /// A copy in which no length is left empty.
  static Insertion resolved(const Insertion& insertion, const Structure& structure)
  {
    return insertion.resolved(structure.resolution);
  }
};

/** What the MRPT classes of all learners share: definition, options, .ini sections, serialization, and
 * forwarding to the core's map. The class of each learner derives from it and adds the rest.
 *
 * A file holds the core's map and every option. The members are defined in learner_map_impl.h and
 * instantiated in the source of each class.
 *
 * @tparam Learner a LearnerTypes with kAlias (the name in .ini files), kPresets (the names of the presets, in
 * the order of the enumeration), and write(const Core&, ByteWriter&) and read(Core&, ByteReader&, version)
 * for the content of a map file that follows the creation options */
template <typename Learner>
class LearnerMap : public CLearnedMap
{
 public:
  using Map = typename Learner::Map;
  using Core = typename Learner::Core;
  using Structure = typename Learner::Structure;
  using Insertion = typename Learner::Insertion;
  using Preset = typename Learner::Preset;

  /// What the map is made with; fixed for its life.
  struct TCreationOptions : public OptionGroup<TCreationOptions>, public Learner::Creation
  {
    /// The set that the other options started from; only a record.
    Preset preset{};

    [[nodiscard]] const OptionTable& optionTable() const override;
    void validate() const override
    {
      TOptionGroup::validate();
      Learner::Creation::validate();
    }

   protected:
    std::vector<std::string> foreignFlags() const override;
  };

  /// How observations become evidence; may be changed at any time. A length that is left empty depends on the
  /// size of the cells.
  struct TInsertionOptions : public OptionGroup<TInsertionOptions>, public Insertion
  {
    TInsertionOptions() = default;
    explicit TInsertionOptions(const Insertion& insertion) : Insertion(insertion) {}

    [[nodiscard]] const OptionTable& optionTable() const override;
    /// Checks only what does not depend on the map's structure.
    void validate() const override { TOptionGroup::validate(); }
  };
  TInsertionOptions insertionOptions;

  LearnerMap(const LearnerMap& other) = default;
  /// All or nothing: if it throws, nothing is changed.
  LearnerMap& operator=(const LearnerMap& other);
  explicit LearnerMap(double resolution_m = 0.10);
  /// @throws std::invalid_argument naming an illegal option; std::runtime_error if a file that an option
  /// names cannot be read.
  explicit LearnerMap(const TCreationOptions& options);

  [[nodiscard]] const TCreationOptions& creationOptions() const { return creationOptions_; }

  /// The map itself, without MRPT.
  [[nodiscard]] const Core& core() const { return map_; }

  // CLearnedMap
  [[nodiscard]] double resolution() const override { return map_.structure().resolution; }
  [[nodiscard]] std::optional<CellEstimate> estimateAt(const mrpt::math::TPoint3D& point_map) const override;
  [[nodiscard]] std::optional<CellEstimate> estimateCell(const CellIndex& cell) const override;
  void visitCells(const CellVisitor& visitor) const override;
  [[nodiscard]] std::optional<std::pair<CellIndex, CellIndex>> cellBounds() const override;
  [[nodiscard]] int emptyAround(const CellIndex& cell) const override;
  [[nodiscard]] std::string alias() const override { return Learner::kAlias; }
  [[nodiscard]] size_t memoryBytes() const override { return map_.memoryBytes(); }
  [[nodiscard]] std::optional<int32_t> planarLayer() const override { return map_.structure().planarLayer(); }
  [[nodiscard]] StateThresholds stateThresholds() const override { return insertionOptions.thresholds; }
  [[nodiscard]] RangeOptions rangeLimits() const override { return insertionOptions.rangeLimits(); }
  void visitOptionGroups(const VisitGroup& visit) const override;

  // CMetricMap
  [[nodiscard]] bool isEmpty() const override { return map_.empty(); }

  // What MRPT's MAP_DEFINITION macros would declare.
  struct TMapDefinition : public mrpt::maps::TMetricMapInitializer
  {
    TCreationOptions creationOpts;
    TInsertionOptions insertionOpts;
    TLikelihoodOptions likelihoodOpts;
    TRenderingOptions renderingOpts;

    TMapDefinition();
    /// Sets the creation and insertion options to those of creationOpts.preset.
    void usePreset();
    /// The insertion options for a map with these creation options, with no length left empty.
    /// @throws std::invalid_argument if the two contradict each other
    [[nodiscard]] TInsertionOptions resolvedInsertion() const;
    /// As loadFromConfigFile() reads it, with no length left empty.
    void saveToConfigFile(mrpt::config::CConfigFileBase& target,
                          const std::string& sectionPrefix) const override;

   protected:
    void loadFromConfigFile_map_specific(const mrpt::config::CConfigFileBase& source,
                                         const std::string& sectionNamePrefix) override;
    void dumpToTextStream_map_specific(std::ostream& out) const override;

   private:
    [[nodiscard]] TMapDefinition untouched() const;
    void warnOfIdleSettings(const mrpt::config::CConfigFileBase& source, const std::string& prefix) const;
  };
  static compat::CreatedDefinition MapDefinition();
  static compat::CreatedOf<Map> CreateFromMapDefinition(const mrpt::maps::TMetricMapInitializer& definition);
  static compat::CreatedMap internal_CreateFromMapDefinition(
      const mrpt::maps::TMetricMapInitializer& definition);

 protected:
  [[nodiscard]] Core& map() { return map_; }
  void internal_clear() override;
  [[nodiscard]] RayWalk follow(const RayStretch& ray) const override;
  void withProbs(const UseProbs& use) const override;
  /// All facts: those about the cells, the learner's own, and those that all maps have.
  [[nodiscard]] std::vector<Fact> factsWith(std::vector<Fact> ofCells, const std::vector<Fact>& own) const;

  uint8_t serializeGetVersion() const override;
  void serializeTo(mrpt::serialization::CArchive& out) const override;
  void serializeFrom(mrpt::serialization::CArchive& in, uint8_t version) override;

 private:
  RayCounts learnScan(const Scan& scan) override;
  void requireLegalInsertion() const override { Learner::validate(insertionOptions, creationOptions_); }
  [[nodiscard]] TInsertionOptions resolvedInsertion() const;
  /// Options are plain members, which programs may set to anything. @throws std::invalid_argument naming the
  /// first illegal one, its value and what is legal
  void validateOptions() const;

  TCreationOptions creationOptions_;
  Core map_;
};

}  // namespace lamap
