#pragma once

#include <lamap_core/bgk/kernel.h>
#include <lamap_core/grid/cell_options.h>
#include <lamap_core/grid/state_thresholds.h>
#include <lamap_core/scan/range_options.h>
#include <lamap_core/training/sampling_rules.h>

#include <cstdint>
#include <optional>

namespace lamap
{
class OptionTable;

/// What a BGK map is made with; fixed for its life.
struct BgkStructure : public BlockOptions
{
  double priorAlpha = 0.003;  ///< α₀ [pseudo-counts], finite, > 0
  double priorBeta = 0.003;   ///< β₀ [pseudo-counts], finite, > 0

  /// @throws std::invalid_argument naming the first illegal option, its value and the legal range.
  void validate() const;

  /// Describes every option, once.
  [[nodiscard]] static const OptionTable& optionTable();

  friend bool operator==(const BgkStructure& a, const BgkStructure& b);
};

/** How scans become evidence. Lengths are in metres; those left empty are given in cells: see resolved(). */
struct BgkInference : public RangeOptions
{
  FreeSpace freeSpace = FreeSpace::Samples;
  TrainingPoints trainingPoints = TrainingPoints::Cells;
  std::optional<double> freeResolution;  ///< distance between free points on a ray; empty: one cell
  std::optional<double> freeMargin;      ///< no free point nearer to its ray's hit; empty: one cell
  double freeWeight = 0.5;               ///< weight of free evidence [-], ≥ 0
  double freeDownsampling = 0.0;  ///< `Centroids`: voxel edge in which free points are averaged; 0: none
  std::optional<double>
      hitDownsampling;  ///< `Centroids`: voxel edge in which hits are averaged; empty: one cell; 0: none
  uint32_t protectHits =
      2;  ///< a cell with so many raw hits in a scan takes no free evidence from it; 0: none is protected
  KernelShape kernel = KernelShape::Sparse;
  std::optional<double> kernelSupport;  ///< l; empty: two cells
  double kernelScale = 1.0;             ///< σ₀ [-], > 0
  StateThresholds thresholds;

  /// The same with the lengths that are given in cells filled in.
  [[nodiscard]] BgkInference resolved(double resolution_m) const;

  /// What decides the training points. Only of resolved options.
  [[nodiscard]] SamplingRules samplingRules() const;
  [[nodiscard]] RangeLimits rangeLimits() const;

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
