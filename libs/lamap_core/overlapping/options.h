#pragma once

#include <lamap_core/features/feature_options.h>
#include <lamap_core/grid/cell_options.h>
#include <lamap_core/grid/state_thresholds.h>
#include <lamap_core/learning/solver_options.h>
#include <lamap_core/scan/ray_selection.h>
#include <lamap_core/training/hilbert_sampling.h>

#include <cstdint>

namespace lamap
{
class OptionTable;

/// What an overlapping Hilbert map is made with; fixed for its life.
struct OverlappingStructure : public BlockOptions, public FeatureOptions
{
  double outOfFieldLimit = 0.6;  ///< limit [log-odds] ≥ 0 in cells outside the field of every scan; 0:
                                 ///< models say nothing outside their field
  /// Limit [log-odds] of what all models that had a cell in their field say together; 0: none. Their errors
  /// are correlated: that many agree does not make them sure.
  double fieldLimit = 6.0;
  bool keepModels = true;  ///< for queries at points and for moving models; else cells are all there is

  /// The same with gamma filled in.
  [[nodiscard]] OverlappingStructure resolved() const;
  /// @throws std::invalid_argument naming the first illegal option, its value and the legal range.
  void validate() const;
  /// Describes every option, once.
  [[nodiscard]] static const OptionTable& optionTable();
  friend bool operator==(const OverlappingStructure& a, const OverlappingStructure& b);
};

/// How scans become models and these become evidence. Lengths in metres.
struct OverlappingInference : public HilbertSampling,
                              public RangeOptions,
                              public DescentOptions,
                              public UncertainInputs
{
  HilbertSolver solver = HilbertSolver::Lbfgs;
  int iterations = 25;         ///< of L-BFGS, at most
  uint32_t scansPerModel = 1;  ///< scans that one model is trained on together (submaps, thesis 5.1)
  double boxQuantile = 0.0;    ///< share of the training points left out of a model's box at each of its ends
                               ///< (outliers, thesis 5.1), in [0, 0.5)
  double fieldNear = 0.3;      ///< cells within this distance of the sensor are in its field
  double fieldDepth = 0.3;     ///< the field extends this far behind the end of a ray
  double fieldAngle = 0;       ///< [degrees] width of the bins of directions that share a depth; 0: by the
                               ///< distance between neighbouring beams
  double fieldWeight = 0.6;    ///< of log-odds in the field, because their sum is overconfident; > 0
  StateThresholds thresholds;

  /// @throws std::invalid_argument naming the first illegal option, its value and the legal range.
  void validate() const;
  /// As of all Hilbert maps, but for surfaces at a glancing angle: models see places free by their own rule,
  /// and with both the log loss is higher.
  [[nodiscard]] SamplingRules rules() const;
  /// Describes every option, once.
  [[nodiscard]] static const OptionTable& optionTable();
  friend bool operator==(const OverlappingInference& a, const OverlappingInference& b);
};

/// Named sets of both kinds of options.
enum class OverlappingPreset
{
  Default,
  Thesis  ///< as chapter 3 of the thesis did: Nyström m = 100, γ = 3, SGD with L1, eq. 3.1
};

struct OverlappingOptions
{
  OverlappingStructure structure;
  OverlappingInference inference;
};

[[nodiscard]] OverlappingOptions presetOptions(OverlappingPreset preset);

}  // namespace lamap
