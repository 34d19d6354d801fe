#pragma once

#include <lamap_core/options/option_table.h>
#include <lamap_mrpt/compat/mrpt_compat.h>
#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <lamap_mrpt/options/option_group.h>
#include <mrpt/maps/TMetricMapInitializer.h>
#include <mrpt/serialization/CSerializable.h>

#include <optional>
#include <string>
#include <vector>

namespace lamap
{
/** What LearnerMap needs to know of a learner; a learner's own derives from it and says the rest.
 * @tparam MapClass MRPT's class; @tparam CoreMap the core's map; @tparam MadeOf its options; @tparam Learning
 * how scans are learned; @tparam Presets named sets of both */
template <typename MapClass, typename CoreMap, typename MadeOf, typename Learning, typename Presets>
struct LearnerTypes
{
  using Map = MapClass;
  using Core = CoreMap;
  using Structure = MadeOf;
  using Creation = MadeOf;  ///< with what only MRPT's class has
  using Insertion = Learning;
  using Preset = Presets;

  static constexpr uint8_t kFormatVersion = 1;

  static Core make(const Creation& creation) { return Core(creation); }
  /// @throws std::invalid_argument naming the first illegal option, its value and what is legal
  static void validate(const Insertion& insertion, const Structure& structure)
  {
    insertion.validate(structure.resolution);
  }
  /// The same with what is left empty filled in.
  static Insertion resolved(const Insertion& insertion, const Structure& structure)
  {
    return insertion.resolved(structure.resolution);
  }
};

/** What the MRPT classes of all learners share: definition, options, .ini sections, serialization, forwarding
 * to the core's map. The class of a learner derives from it and adds what is its own.
 *
 * Stored whole: the core's map, every option. The members are defined in learner_map_impl.h and instantiated
 * in the source of each class.
 *
 * @tparam Learner a LearnerTypes with kAlias (the name in .ini files), kPresets (the names of the presets in
 * their order), and write(const Core&, ByteWriter&) and read(Core&, ByteReader&) for the content of a map
 * file after its options of creation */
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
    /// Where the other options started from; kept as a record.
    Preset preset{};

    [[nodiscard]] const OptionTable& optionTable() const override;
    void validate() const override { Learner::Creation::validate(); }

   protected:
    std::vector<std::string> foreignFlags() const override;
  };

  /// How observations become evidence; may be changed at any time. Some lengths may be left empty: they are
  /// then given in cells.
  struct TInsertionOptions : public OptionGroup<TInsertionOptions>, public Insertion
  {
    TInsertionOptions() = default;
    explicit TInsertionOptions(const Insertion& insertion) : Insertion(insertion) {}

    [[nodiscard]] const OptionTable& optionTable() const override;
    /// What does not depend on the map's structure.
    void validate() const override { TOptionGroup::validate(); }
  };
  TInsertionOptions insertionOptions;

  explicit LearnerMap(double resolution_m = 0.10);
  /// @throws std::invalid_argument naming an illegal option; std::runtime_error if a file that they name
  /// cannot be read.
  explicit LearnerMap(const TCreationOptions& options);

  [[nodiscard]] const TCreationOptions& creationOptions() const { return creationOptions_; }

  /// The map itself, without MRPT.
  [[nodiscard]] const Core& core() const { return map_; }

  // CLearnedMap
  [[nodiscard]] double resolution() const override { return map_.structure().resolution; }
  [[nodiscard]] std::optional<CellEstimate> estimateAt(const mrpt::math::TPoint3D& point_map) const override;
  [[nodiscard]] std::optional<CellEstimate> estimateCell(const CellIndex& cell) const override;
  void visitCells(const CellVisitor& visitor) const override;
  [[nodiscard]] std::string alias() const override { return Learner::kAlias; }
  [[nodiscard]] size_t memoryBytes() const override { return map_.memoryBytes(); }
  [[nodiscard]] std::optional<int32_t> planarLayer() const override { return map_.structure().planarLayer(); }
  [[nodiscard]] StateThresholds stateThresholds() const override { return insertionOptions.thresholds; }
  [[nodiscard]] RangeLimits rangeLimits() const override { return insertionOptions.rangeLimits(); }
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
    /// Sets creation and insertion options to what creationOpts.preset names.
    void usePreset();
    /// Insertion options as they hold for a map of these creation options, with what is left empty filled in.
    /// @throws std::invalid_argument if the two do not fit together
    [[nodiscard]] TInsertionOptions resolvedInsertion() const;
    /// As loadFromConfigFile() reads it, with what is left empty filled in.
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
  /// A report: facts about the cells, those of the learner, and those that all maps have.
  [[nodiscard]] std::vector<Fact> factsWith(std::vector<Fact> ofCells, const std::vector<Fact>& own) const;

  uint8_t serializeGetVersion() const override;
  void serializeTo(mrpt::serialization::CArchive& out) const override;
  void serializeFrom(mrpt::serialization::CArchive& in, uint8_t version) override;

 private:
  [[nodiscard]] TInsertionOptions resolvedInsertion() const;

  TCreationOptions creationOptions_;
  Core map_;
};

}  // namespace lamap
