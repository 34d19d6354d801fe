#pragma once

#include <lamap_core/grid/octant_rule.h>
#include <lamap_core/grid/state_thresholds.h>
#include <lamap_core/hilbert/options.h>

#include <cstdint>
#include <optional>

namespace lamap
{
/// What an overlapping Hilbert map is made with; fixed for its life.
struct OverlappingStructure
{
  double resolution = 0.10;  ///< edge of a finest cell [m], finite, > 0
  int blockDepth = 4;        ///< a block is 2^(blockDepth−1) cells wide; 2 to 6
  Pruning pruning = Pruning::Lossless;
  bool planar = false;        ///< one layer of cells, distances in the plane: for 2D sensors
  double planarHeight = 0.0;  ///< [m], in the layer of a planar map
  HilbertFeatures features = HilbertFeatures::Compact;
  std::optional<double> gamma;   ///< γ [m⁻²] of the kernel; empty: 14 (`Compact`), 3 (`Nystroem`)
  double latticeSpacing = 0.25;  ///< `Compact`: h [m]
  double cutoff =
      CompactKernel::kDefaultCutoff;  ///< `Compact`: what is taken off the kernel so that it ends, in (0, 1)
  uint32_t components = 100;          ///< `Nystroem`: m; with as many points or fewer, all of them
  uint32_t seed = 1;                  ///< of inducing points and of the order in SGD
  double priorPrecision = 0.1;        ///< λ of L-BFGS, > 0
  double outOfFieldLimit = 0.6;  ///< [log-odds] ≥ 0 that cells no scan had in its field are held to; 0:
                                 ///< models say nothing outside of their field
  bool keepModels = true;        ///< for queries at points and for moving models; else cells are all there is

  /// γ, filled in.
  [[nodiscard]] double resolvedGamma() const;
  /// @throws std::invalid_argument naming the first illegal option, its value and the legal range.
  void validate() const;
  friend bool operator==(const OverlappingStructure& a, const OverlappingStructure& b);
};

/// How scans become models and these become evidence. Lengths in metres.
struct OverlappingInference : public HilbertSampling
{
  double minRange = 0.0;                         ///< returns nearer than this are left out, with their rays
  double maxRange = 0.0;                         ///< 0: what the observation states; free space ends there
  bool considerInvalidRangesAsFreeSpace = true;  ///< rays without return are free up to the maximum range
  uint32_t rayDecimation = 1;                    ///< only every so many-th ray of an observation is used
  HilbertSolver solver = HilbertSolver::Lbfgs;
  int iterations = 25;         ///< of L-BFGS, at most
  double alpha = 1e-5;         ///< α of SGD (thesis eq. 2.34), > 0
  int epochs = 5;              ///< of SGD, ≥ 1
  uint32_t scansPerModel = 1;  ///< scans that one model is trained on together (submaps, thesis 5.1)
  double boxQuantile = 0.0;    ///< share of the training points left out of a model's box at each of its ends
                               ///< (outliers, thesis 5.1), in [0, 0.5)
  double fieldNear = 0.3;      ///< cells so near to the sensor are in its field
  double fieldDepth = 0.3;     ///< the field reaches so far behind the end of a ray
  double fieldAngle = 2.5;     ///< [degrees] edge of the bins of directions that share a depth
  double fieldWeight = 0.6;    ///< of log-odds in the field, for their sum is too sure of itself; > 0
  StateThresholds thresholds;

  [[nodiscard]] RangeLimits rangeLimits() const;

  /// @throws std::invalid_argument naming the first illegal option, its value and the legal range.
  void validate() const;
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
