#pragma once

#include <lamap_core/bgk/map.h>
#include <lamap_core/bgk/options.h>
#include <lamap_mrpt/files/byte_stream.h>
#include <lamap_mrpt/maps/learner_map.h>

#include <string>
#include <vector>

namespace lamap
{
class CBGKMap;

/// BGK inference, for LearnerMap.
struct BgkLearner : public LearnerTypes<CBGKMap, BgkMap, BgkStructure, BgkInference, BgkPreset>
{
  struct Creation : public BgkStructure
  {
    /// Map file of a BGK map whose α and β are the prior where it has evidence; "" for none. Read when the
    /// map is made, and stored in it.
    std::string priorMap;

    [[nodiscard]] static const OptionTable& optionTable();
  };
  static constexpr const char* kAlias = "bgkMap";
  static inline const std::vector<std::string> kPresets{"default", "thesis", "la3dm"};

  static BgkMap make(const Creation& creation);
  /** The evidence and the prior map: equal maps give equal bytes.
   *
   * The number of blocks (uint64); for each block, by z, y, x: its index (3 × int32), a byte (1: counts of 64
   * bits, 2: pruned) and its packed words; then 1 and the prior map, with its options of creation before its
   * evidence, or 0. */
  static void write(const BgkMap& map, ByteWriter& out);
  /// @throws std::runtime_error naming the place and what cannot be; the bytes are not trusted.
  static void read(BgkMap& map, ByteReader& in, uint8_t version);
};

extern template class LearnerMap<BgkLearner>;

/** 3D occupancy map by Bayesian generalized kernel inference (BGK), thesis chapter 4, as an MRPT map.
 *
 * In .ini files: bgkMap_count=1, and sections <prefix>_bgkMap_00_creationOpts, _insertOpts, _likelihoodOpts
 * and _renderOpts. Stored whole: evidence in full precision, every option, the prior map.
 *
 * Takes the observations that supportsObservation() names. Others are not inserted, and their likelihood is
 * 0.
 */
class CBGKMap : public LearnerMap<BgkLearner>
{
  DEFINE_MRPT_OBJECT(CBGKMap, lamap)

 public:
  using LearnerMap::LearnerMap;

  /** Adds all evidence of another map, as if its observations had been inserted here.
   * @throws std::invalid_argument if its cells differ. */
  void merge(const CBGKMap& other);

  // CLearnedMap
  [[nodiscard]] std::vector<std::string> evidenceNames() const override { return {"alpha", "beta"}; }
  [[nodiscard]] std::vector<Fact> facts() const override;
  /// Adds kernelScale to α of the cell, or freeWeight · kernelScale to β.
  void updateVoxel(double x, double y, double z, bool occupied) override;
};

}  // namespace lamap
