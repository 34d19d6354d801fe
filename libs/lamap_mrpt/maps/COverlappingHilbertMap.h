#pragma once

#include <lamap_core/overlapping/map.h>
#include <lamap_core/overlapping/options.h>
#include <lamap_mrpt/files/byte_stream.h>
#include <lamap_mrpt/maps/learner_map.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace lamap
{
class COverlappingHilbertMap;

/// Overlapping Hilbert maps, for LearnerMap.
struct OverlappingLearner : public LearnerTypes<COverlappingHilbertMap, OverlappingHilbertMap,
                                                OverlappingStructure, OverlappingInference, OverlappingPreset>
{
  static constexpr const char* kAlias = "overlappingHilbertMap";
  static constexpr uint8_t kFormatVersion = 4;
  static inline const std::vector<std::string> kPresets{"default", "thesis"};

  static OverlappingHilbertMap make(const OverlappingStructure& structure)
  {
    return OverlappingHilbertMap(structure.resolved());
  }
  static void setAsBefore(OverlappingStructure& creation, uint8_t version)
  {
    if (version < 4) creation.fieldLimit = 0;
  }
  static void validate(const OverlappingInference& insertion, const OverlappingStructure& /*structure*/)
  {
    insertion.validate();
  }
  static OverlappingInference resolved(const OverlappingInference& insertion,
                                       const OverlappingStructure& /*structure*/)
  {
    return insertion;
  }
  static size_t settle(OverlappingHilbertMap& map, const OverlappingInference& insertion, unsigned threads)
  {
    return map.dropUntrainable(insertion, threads);
  }
  static void write(const OverlappingHilbertMap& map, ByteWriter& out);
  static void read(OverlappingHilbertMap& map, ByteReader& in, uint8_t version);
};

extern template class LearnerMap<OverlappingLearner>;

/** 3D occupancy map of overlapping Hilbert maps, thesis chapter 3, as an MRPT map: one logistic regression
 * per scan, fused by log-odds (Algorithm 1).
 *
 * In .ini files: overlappingHilbertMap_count=1, and sections <prefix>_overlappingHilbertMap_00_creationOpts,
 * _insertOpts, _likelihoodOpts and _renderOpts. While it keeps its models the map is continuous: estimateAt()
 * answers at the point itself, and models can be moved to poses that a pose graph found. Stored whole: cells,
 * models, scans that wait for others, every option.
 *
 * With scansPerModel > 1, scans wait until there are enough of them to train one model. Until then, what is
 * read from the map includes the waiting scans, as if no others would follow. A scan that could not be
 * trained is refused when it is inserted; where options that were changed since make it impossible all the
 * same, what is read is the map without the waiting scans.
 *
 * Takes the observations that supportsObservation() names. Others are not inserted, and their likelihood is
 * 0.
 */
class COverlappingHilbertMap : public LearnerMap<OverlappingLearner>
{
  DEFINE_MRPT_OBJECT(COverlappingHilbertMap, lamap)

 public:
  using LearnerMap::LearnerMap;

  /** Adds everything that another map holds, as if its observations had been inserted here.
   * @throws std::invalid_argument if its cells or models are of another kind, or if it has waiting scans. */
  void merge(const COverlappingHilbertMap& other);

  /// Number of models in the map.
  [[nodiscard]] size_t modelCount() const { return core().modelCount(); }
  /// Pose of a model's sensor in the map. @throws std::out_of_range
  [[nodiscard]] mrpt::poses::CPose3D modelPose(size_t model) const;
  /** Moves a model to a better pose of its sensor, e.g. from a pose graph. The map is then the one that would
   * have been built with that pose.
   * @throws std::out_of_range, std::logic_error if creationOpts.keepModels is false; nothing changes then */
  void setModelPose(size_t model, const mrpt::poses::CPose3D& sensor_map);

  // CLearnedMap
  [[nodiscard]] std::optional<CellEstimate> estimateAt(const mrpt::math::TPoint3D& point_map) const override;
  [[nodiscard]] std::optional<CellEstimate> estimateCell(const CellIndex& cell) const override;
  void visitCells(const CellVisitor& visitor) const override;
  [[nodiscard]] std::optional<std::pair<CellIndex, CellIndex>> cellBounds() const override;
  [[nodiscard]] int emptyAround(const CellIndex& cell) const override;
  [[nodiscard]] std::vector<std::string> evidenceNames() const override { return {"logodds"}; }
  [[nodiscard]] std::vector<Fact> facts() const override;
  /// Adds fieldWeight · hitWeight to the cell's log-odds, or subtracts fieldWeight · freeWeight.
  void updateVoxel(double x, double y, double z, bool occupied) override;

 private:
  void contentChanged() override;
  [[nodiscard]] RayWalk follow(const RayStretch& ray) const override;
  void withProbs(const UseProbs& use) const override;
  /// The map including the waiting scans.
  [[nodiscard]] std::shared_ptr<const OverlappingHilbertMap> whole() const;

  Lazy<OverlappingHilbertMap> withPending_;
};

}  // namespace lamap
