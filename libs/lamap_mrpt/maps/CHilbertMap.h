#pragma once

#include <lamap_core/hilbert/map.h>
#include <lamap_core/hilbert/options.h>
#include <lamap_mrpt/files/byte_stream.h>
#include <lamap_mrpt/maps/learner_map.h>

#include <optional>
#include <string>
#include <vector>

namespace lamap
{
class CHilbertMap;

/// One Hilbert map, for LearnerMap.
struct HilbertLearner
    : public LearnerTypes<CHilbertMap, HilbertMap, HilbertStructure, HilbertInference, HilbertPreset>
{
  static constexpr const char* kAlias = "hilbertMap";
  static constexpr uint8_t kFormatVersion = 4;
  static inline const std::vector<std::string> kPresets{"default", "thesis"};

  static HilbertMap make(const HilbertStructure& structure) { return HilbertMap(structure.resolved()); }
  static void validate(const HilbertInference& insertion, const HilbertStructure& structure)
  {
    insertion.validate(structure);
  }
  static HilbertInference resolved(const HilbertInference& insertion, const HilbertStructure& structure)
  {
    return insertion.resolved(structure);
  }
  static void write(const HilbertMap& map, ByteWriter& out);
  static void read(HilbertMap& map, ByteReader& in, uint8_t version);
};

extern template class LearnerMap<HilbertLearner>;

/** 3D occupancy map by one logistic regression in a Hilbert space of features (Hilbert map), thesis sections
 * 2.4 and 3, as an MRPT map: incremental by Laplace's approximation, of all scans together, or by stochastic
 * gradient descent.
 *
 * In .ini files: hilbertMap_count=1, and sections <prefix>_hilbertMap_00_creationOpts, _insertOpts,
 * _likelihoodOpts and _renderOpts. The map is continuous: estimateAt() answers at the point itself, and cells
 * are a view of it, read at their centres. Stored whole: the model, every option, and with `training = batch`
 * all training points.
 *
 * Takes the observations that supportsObservation() names. Others are not inserted, and their likelihood is
 * 0.
 */
class CHilbertMap : public LearnerMap<HilbertLearner>
{
  DEFINE_MRPT_OBJECT(CHilbertMap, lamap)

 public:
  using LearnerMap::LearnerMap;

  /** Expected log-odds at an uncertain point of the map frame (thesis 3.2.4).
   * @param covariance [m²], symmetric, positive semidefinite
   * @return nothing where no feature reaches */
  [[nodiscard]] std::optional<double> expectedLogoddsAt(const mrpt::math::TPoint3D& point_map,
                                                        const mrpt::math::CMatrixDouble33& covariance) const;

  // CLearnedMap
  void visitCells(const CellVisitor& visitor) const override;
  [[nodiscard]] std::vector<std::string> evidenceNames() const override { return {"logodds"}; }
  [[nodiscard]] std::vector<Fact> facts() const override;
  /// @throws std::logic_error always, because cells are only a view of the model.
  void updateVoxel(double x, double y, double z, bool occupied) override;
};

}  // namespace lamap
