#pragma once

#include <lamap_core/features/compact_kernel.h>
#include <lamap_core/grid/state_thresholds.h>
#include <lamap_core/learning/trainers.h>
#include <lamap_core/scan/ray_selection.h>
#include <lamap_core/training/hilbert_training.h>

#include <cstdint>
#include <optional>

namespace lamap
{
/// How a point becomes a vector of features.
enum class HilbertFeatures
{
  Compact,  ///< CompactKernel, centred on the sites of a lattice that held a training point
  Nystroem  ///< NystroemFeatures (thesis 2.4.2)
};

/// How one model learns scan by scan.
enum class HilbertTraining
{
  Incremental,  ///< the posterior of the scans so far is the next one's prior
  Batch,        ///< all training points are kept and trained on together, when the map is asked (thesis 3.2)
  Sgd           ///< a few more epochs of gradient descent a scan (Ramos and Ott 2015)
};

/// What minimizes the loss.
enum class HilbertSolver
{
  Lbfgs,
  SgdL1,
  SgdL2
};

/// What a map of one model is made with; fixed for its life.
struct HilbertStructure
{
  double resolution = 0.10;   ///< edge of a finest cell [m], finite, > 0
  bool planar = false;        ///< one layer of cells, distances in the plane: for 2D sensors
  double planarHeight = 0.0;  ///< [m], in the layer of a planar map
  HilbertTraining training = HilbertTraining::Incremental;
  HilbertFeatures features = HilbertFeatures::Compact;  ///< `Incremental` has compact ones only
  std::optional<double> gamma;  ///< γ [m⁻²]; empty: 14 for compact, 3 for Nyström
  double cutoff =
      CompactKernel::kDefaultCutoff;  ///< of the compact kernel; also says how far Nyström reaches
  double latticeSpacing = 0.25;       ///< h [m]
  uint32_t components = 100;          ///< m of `Nystroem`
  uint32_t seed = 1;                  ///< of inducing points and of the order in SGD
  double priorPrecision = 0.1;        ///< λ of each weight before it saw any data, > 0

  [[nodiscard]] CompactKernel kernel() const;
  [[nodiscard]] std::optional<int32_t> planarLayer() const;

  /// @throws std::invalid_argument naming the first illegal option, its value and the legal range.
  void validate() const;

  friend bool operator==(const HilbertStructure& a, const HilbertStructure& b);
};

/// How scans are learned; may change from scan to scan.
struct HilbertInference : public HilbertSampling
{
  double minRange = 0.0;                         ///< [m] nearer returns are left out, with their rays
  double maxRange = 0.0;                         ///< [m] 0: what the observation states
  bool considerInvalidRangesAsFreeSpace = true;  ///< rays without return are free up to the maximum range
  uint32_t rayDecimation = 1;                    ///< only every so many-th ray of an observation is used
  std::optional<HilbertSolver> solver;           ///< empty: SgdL1 where training is `Sgd`, else Lbfgs
  std::optional<uint32_t> iterations;            ///< of Lbfgs; empty: 10 for `Incremental`, 25 for `Batch`
  double alpha = 1e-5;                           ///< α of SGD (thesis eq. 2.34), > 0
  int epochs = 5;                                ///< of SGD a scan, or in all for `Batch`, ≥ 1
  StateThresholds thresholds;

  [[nodiscard]] HilbertSolver solverFor(HilbertTraining training) const;
  [[nodiscard]] uint32_t iterationsFor(HilbertTraining training) const;
  [[nodiscard]] RangeLimits rangeLimits() const;

  /// @throws std::invalid_argument naming the first illegal option, its value and the legal range.
  void validate(const HilbertStructure& structure) const;
};

}  // namespace lamap
