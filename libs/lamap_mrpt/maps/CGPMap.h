#pragma once

#include <lamap_core/gp/map.h>
#include <lamap_core/gp/options.h>
#include <lamap_mrpt/files/byte_stream.h>
#include <lamap_mrpt/maps/learner_map.h>

#include <string>
#include <vector>

namespace lamap
{
class CGPMap;

/// Gaussian processes, for LearnerMap.
struct GpLearner : public LearnerTypes<CGPMap, GpMap, GpStructure, GpInference, GpPreset>
{
  static constexpr const char* kAlias = "gpMap";
  static inline const std::vector<std::string> kPresets{"default", "thesis", "la3dm"};

  static void setAsBefore(GpStructure& creation, uint8_t version)
  {
    if (version < 3) creation.maxEvidence = 0;
  }
  static void write(const GpMap& map, ByteWriter& out);
  static void read(GpMap& map, ByteReader& in, uint8_t version);
};

extern template class LearnerMap<GpLearner>;

/** 3D occupancy map by Gaussian process regression, thesis section 2.3, as an MRPT map: an exact GP on each
 * block of a scan, fused by a Bayesian committee machine. The baseline that chapter 4 of the thesis compares
 * BGK maps with; while a robot stands still, it becomes ever more certain, and its walls ever thicker
 * (section 4.3.3), unless evidence counts up to creationOpts.maxEvidence only, which is the default.
 *
 * In .ini files: gpMap_count=1, and sections <prefix>_gpMap_00_creationOpts, _insertOpts, _likelihoodOpts and
 * _renderOpts. Stored whole: evidence in full precision, every option.
 *
 * Takes the observations that supportsObservation() names. Others are not inserted, and their likelihood is
 * 0.
 */
class CGPMap : public LearnerMap<GpLearner>
{
  DEFINE_MRPT_OBJECT(CGPMap, lamap)

 public:
  using LearnerMap::LearnerMap;

  /** Adds all evidence of another map, as if its observations had been inserted here.
   * @throws std::invalid_argument if it was made with other creation options, maxEvidence, pruning and preset
   * apart. */
  void merge(const CGPMap& other);

  // CLearnedMap
  /// The inverse variance and the mean of f; with creationOpts.fusion = bayes the log-odds.
  [[nodiscard]] std::vector<std::string> evidenceNames() const override;
  [[nodiscard]] std::vector<Fact> facts() const override;
  /// Adds to the cell what a GP with one training point, at its centre, says there.
  void updateVoxel(double x, double y, double z, bool occupied) override;
};

}  // namespace lamap
