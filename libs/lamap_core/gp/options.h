#pragma once

#include <lamap_core/grid/cell_options.h>
#include <lamap_core/grid/state_thresholds.h>
#include <lamap_core/training/sampling_options.h>

#include <cstdint>
#include <optional>

namespace lamap
{
class OptionTable;

/// How the Gaussian processes of several scans become one estimate of a cell.
enum class GpFusion
{
  Bcm,   ///< Bayesian committee machine: precisions and weighted means add (thesis eq. 2.28, 2.29)
  Bayes  ///< log-odds of each scan's squashed prediction add (thesis eq. 3.1, section 5.1)
};

/// Where a ray of a scan says "free".
enum class GpFreeSpace
{
  Samples,  ///< points every freeResolution along the ray
  None      ///< nowhere
};

/// What a GP map is made with; fixed for its life.
struct GpStructure : public BlockOptions
{
  GpStructure() { blockDepth = 3; }

  GpFusion fusion = GpFusion::Bcm;
  double signalVariance = 1.0;        ///< σ_f² of eq. (2.24): of a cell nobody spoke of; in [1e-3, 1e3]
  double noiseVariance = 0.05;        ///< σ_n² of eq. (2.19), in [1e-6, 1e3]
  double squashGain = 1.0;            ///< γ of eq. (2.25), > 0
  std::optional<double> minVariance;  ///< σ²_min of eq. (2.25), > 0; empty: noiseVariance

  /// Of `Bcm`: a cell reads as if the precision that scans gave it were this at most, with the same mean; 0:
  /// no limit. Empty: as many sharp hits or free points, of 1/noiseVariance each, as kUsualMaxPoints.
  std::optional<double> maxEvidence;
  static constexpr double kUsualMaxPoints = 7.5;

  [[nodiscard]] double resolvedMaxEvidence() const
  {
    return maxEvidence.value_or(kUsualMaxPoints / noiseVariance);
  }
  [[nodiscard]] double resolvedMinVariance() const { return minVariance.value_or(noiseVariance); }
  /// The same with minVariance and maxEvidence filled in.
  [[nodiscard]] GpStructure resolved() const;
  /// γ·σ²_min: log-odds for each unit of mean / variance.
  [[nodiscard]] double squash() const { return squashGain * resolvedMinVariance(); }

  /// @throws std::invalid_argument naming the first illegal option, its value and the legal range.
  void validate() const;

  /// Describes every option, once.
  [[nodiscard]] static const OptionTable& optionTable();

  friend bool operator==(const GpStructure& a, const GpStructure& b);
};

/** How scans become evidence. Lengths are in metres; those left empty are given in cells: see resolved(). */
struct GpInference : public SamplingOptions
{
  /// A GP for each block that holds training points, and those around a block fused (nested BCM, thesis table
  /// 4.1); else one for each block, trained on everything within the support.
  bool nested = false;
  GpFreeSpace freeSpace = GpFreeSpace::Samples;
  std::optional<double> kernelSupport;  ///< a GP is silent this far from all its data; empty: two cells
  double lengthScale = 1.0;             ///< l of eq. (2.24) [m], > 0
  uint32_t maxPoints = 512;             ///< of one GP; more are split, and the parts fused; 1 to 4096
  StateThresholds thresholds;

  /// The same with what is left empty filled in.
  [[nodiscard]] GpInference resolved(double resolution_m) const;

  /// What decides the training points. Only of resolved options.
  [[nodiscard]] SamplingRules samplingRules() const { return rulesWith(whereFree(), *kernelSupport); }
  [[nodiscard]] RangeOptions rangeLimits() const { return limitsWith(whereFree()); }

  /// @throws std::invalid_argument naming the first illegal option, its value and the legal range.
  void validate(double resolution_m) const;

  /// Describes every option, once.
  [[nodiscard]] static const OptionTable& optionTable();

  friend bool operator==(const GpInference& a, const GpInference& b);

 private:
  [[nodiscard]] FreeSpace whereFree() const
  {
    return freeSpace == GpFreeSpace::Samples ? FreeSpace::Samples : FreeSpace::None;
  }
};

/// Named sets of both kinds of options.
enum class GpPreset
{
  Default,
  Thesis,  ///< GPOctoMap-NBCM-P of chapter 4; its parameters, which the thesis does not print, from LA3DM
  La3dm    ///< as the thesis's library LA3DM ships
};

struct GpOptions
{
  GpStructure structure;
  GpInference inference;
};

[[nodiscard]] GpOptions presetOptions(GpPreset preset);

}  // namespace lamap
