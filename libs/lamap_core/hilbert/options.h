#pragma once

#include <lamap_core/features/feature_options.h>
#include <lamap_core/grid/cell_options.h>
#include <lamap_core/grid/state_thresholds.h>
#include <lamap_core/learning/solver_options.h>
#include <lamap_core/scan/ray_selection.h>
#include <lamap_core/training/hilbert_sampling.h>

#include <cstdint>
#include <optional>

namespace lamap
{
class OptionTable;

/// How one model learns scan by scan.
enum class HilbertTraining
{
  Incremental,  ///< the posterior of the scans so far is the next one's prior
  Batch,        ///< all training points are kept and trained on together, when the map is asked (thesis 3.2)
  Sgd           ///< a few more epochs of gradient descent per scan (Ramos and Ott 2015)
};

/// What a map of one model is made with; fixed for its life.
struct HilbertStructure : public CellOptions, public FeatureOptions
{
  HilbertTraining training = HilbertTraining::Incremental;  ///< `Incremental` needs compact features

  /// @throws std::invalid_argument naming the first illegal option, its value and the legal range.
  void validate() const;

  /// The same with gamma filled in.
  [[nodiscard]] HilbertStructure resolved() const;
  /// Describes every option, once.
  [[nodiscard]] static const OptionTable& optionTable();

  friend bool operator==(const HilbertStructure& a, const HilbertStructure& b);
};

/// How scans are learned; may change from scan to scan.
struct HilbertInference : public HilbertSampling,
                          public RangeOptions,
                          public DescentOptions,
                          public UncertainInputs
{
  std::optional<HilbertSolver> solver;  ///< empty: SgdL1 where training is `Sgd`, else Lbfgs
  std::optional<uint32_t> iterations;   ///< of Lbfgs; empty: 10 for `Incremental`, 25 for `Batch`
  StateThresholds thresholds;

  [[nodiscard]] HilbertSolver solverFor(HilbertTraining training) const;
  [[nodiscard]] uint32_t iterationsFor(HilbertTraining training) const;

  /// The same with what the training decides filled in.
  [[nodiscard]] HilbertInference resolved(const HilbertStructure& structure) const;
  /// @throws std::invalid_argument naming the first illegal option, its value and the legal range.
  void validate(const HilbertStructure& structure) const;
  /// Describes every option, once.
  [[nodiscard]] static const OptionTable& optionTable();
};

/// Named sets of both kinds of options.
enum class HilbertPreset
{
  Default,
  Thesis  ///< global Hilbert map (thesis 3.2): batch, 100 Nyström components, SGD with L1, points as they are
};

struct HilbertOptions
{
  HilbertStructure structure;
  HilbertInference inference;
};

[[nodiscard]] HilbertOptions presetOptions(HilbertPreset preset);

}  // namespace lamap
