#pragma once

#include <lamap_core/bgk/kernel.h>
#include <lamap_core/grid/cell_options.h>
#include <lamap_core/grid/state_thresholds.h>
#include <lamap_core/training/sampling_options.h>

#include <optional>

namespace lamap
{
class OptionTable;

/// What a BGK map is made with; fixed for its life.
struct BgkStructure : public BlockOptions
{
  double priorAlpha = 0.003;  ///< α₀ [pseudo-counts], finite, > 0
  double priorBeta = 0.003;   ///< β₀ [pseudo-counts], finite, > 0
  /// A cell reads as if it had this much evidence at most [pseudo-counts], in the proportions of what it has;
  /// 0: no limit.
  double maxEvidence = 0;

  /// @throws std::invalid_argument naming the first illegal option, its value and the legal range.
  void validate() const;

  /// Describes every option, once.
  [[nodiscard]] static const OptionTable& optionTable();

  friend bool operator==(const BgkStructure& a, const BgkStructure& b);
};

/** How scans become evidence. Lengths are in metres; those left empty are given in cells: see resolved(). */
struct BgkInference : public SamplingOptions
{
  BgkInference() { beamWidth = BeamWidth::Spacing; }

  FreeSpace freeSpace = FreeSpace::Samples;
  double freeWeight = 0.5;  ///< weight of free evidence [-], ≥ 0
  KernelShape kernel = KernelShape::Sparse;
  std::optional<double> kernelSupport;  ///< l; empty: two cells
  double kernelScale = 1.0;             ///< σ₀ [-], > 0
  StateThresholds thresholds;

  /// The same with the lengths that are given in cells filled in.
  [[nodiscard]] BgkInference resolved(double resolution_m) const;

  /// What decides the training points. Only of resolved options.
  [[nodiscard]] SamplingRules samplingRules() const;
  [[nodiscard]] RangeOptions rangeLimits() const { return limitsWith(freeSpace); }
  /// Whether, in a 3D map, free evidence of kernels alone counts only in cells with free space all around.
  /// Beams must speak for the gaps between them then.
  [[nodiscard]] bool keepsUnseenSpace() const
  {
    return beamWidth == BeamWidth::Spacing && protectHits > 0 && freeSpace == FreeSpace::Samples &&
           trainingPoints == TrainingPoints::Cells;
  }

  /// @throws std::invalid_argument naming the first illegal option, its value and the legal range.
  void validate(double resolution_m) const;

  /// Describes every option, once.
  [[nodiscard]] static const OptionTable& optionTable();

  friend bool operator==(const BgkInference& a, const BgkInference& b);
};

/// Named sets of both kinds of options.
enum class BgkPreset
{
  Default,
  Thesis,  ///< as chapter 4 of the thesis did
  La3dm    ///< as the thesis's library LA3DM ships
};

struct BgkOptions
{
  BgkStructure structure;
  BgkInference inference;
};

[[nodiscard]] BgkOptions presetOptions(BgkPreset preset);

}  // namespace lamap
