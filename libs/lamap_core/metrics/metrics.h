#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace lamap
{
/// Cells that were predicted with the same probability, and how many of them are in truth occupied and free.
struct PredictedCells
{
  double prob = 0.5;  ///< P(occupied), in [0, 1]
  uint64_t occupied = 0;
  uint64_t free = 0;
};

/** Predictions and their truth, sorted by probability: the input of all scores below.
 *
 * Invariants: probabilities increase strictly (cells of equal probability are one entry, so ties are exact
 * whatever the input order), and every entry has cells. Immutable: may be shared between threads. Counts are
 * exact up to 2^53 cells.
 */
class RankedPredictions
{
 public:
  /// @param predictions in any order; probabilities may repeat.
  /// @throws std::invalid_argument for a probability that is NaN or outside [0, 1].
  explicit RankedPredictions(std::vector<PredictedCells> predictions);

  [[nodiscard]] const std::vector<PredictedCells>& ascending() const { return ascending_; }
  [[nodiscard]] uint64_t occupied() const { return occupied_; }
  [[nodiscard]] uint64_t free() const { return free_; }
  [[nodiscard]] uint64_t cells() const { return occupied_ + free_; }
  /// Whether there are both occupied and free cells; otherwise nothing can be ranked.
  [[nodiscard]] bool hasBothClasses() const { return occupied_ > 0 && free_ > 0; }

 private:
  std::vector<PredictedCells> ascending_;
  uint64_t occupied_ = 0;
  uint64_t free_ = 0;
};

/** Area under the ROC curve: the probability that a random occupied cell was predicted with a higher
 * probability than a random free one, with ties counted half (Mann-Whitney with average ranks).
 * @return in [0, 1]; empty unless there are both classes. */
[[nodiscard]] std::optional<double> areaUnderRoc(const RankedPredictions& predictions);

/** Average precision Σ (Rₙ − Rₙ₋₁) Pₙ over all distinct probabilities as thresholds, from the highest down;
 * no interpolation.
 * @return in [0, 1]; empty unless there are both classes. */
[[nodiscard]] std::optional<double> averagePrecision(const RankedPredictions& predictions);

/// Which cells a threshold calls occupied.
enum class ThresholdRule
{
  Above,   ///< prob > threshold (strict)
  AtLeast  ///< prob ≥ threshold (non-strict)
};

/** A probability this close to a threshold counts as equal to it: maps that store log-odds as floats give
 * 0.69999999 for 0.7. */
constexpr double kThresholdTolerance = 1e-6;

struct PrecisionRecall
{
  /// Share of the cells called occupied that are occupied; empty if none was called occupied.
  std::optional<double> precision;
  /// Share of the occupied cells that were called occupied; empty if there are none.
  std::optional<double> recall;
};
[[nodiscard]] PrecisionRecall precisionRecall(const RankedPredictions& predictions, double threshold,
                                              ThresholdRule rule);

/// The log loss clips probabilities to this distance from 0 and 1: a certain error costs 13.8 nats, not
/// infinity.
constexpr double kLogLossClip = 1e-6;

/** Mean of −ln(predicted probability of the true label) [nats], probabilities clipped to [clip, 1 − clip].
 * @param clip in (0, 0.5). @return ≥ 0; empty without cells.
 * @throws std::invalid_argument for a clip outside this range. */
[[nodiscard]] std::optional<double> logLoss(const RankedPredictions& predictions, double clip = kLogLossClip);

/// Mean of (prob − truth)², truth 1 or 0. @return in [0, 1]; empty without cells.
[[nodiscard]] std::optional<double> brierScore(const RankedPredictions& predictions);

constexpr size_t kCalibrationBins = 10;

/// Cells with a probability in [low, high); the last bin includes 1.
struct CalibrationBin
{
  double low = 0;
  double high = 0;
  uint64_t cells = 0;
  double meanProb = 0;       ///< 0 without cells
  double occupiedShare = 0;  ///< 0 without cells
};

/// Bins of equal width from 0 to 1, including empty ones. @throws std::invalid_argument if bins is 0.
[[nodiscard]] std::vector<CalibrationBin> calibrationBins(const RankedPredictions& predictions,
                                                          size_t bins = kCalibrationBins);

/** Mean over all cells of |meanProb − occupiedShare| of the cell's bin.
 * @return in [0, 1]; empty without cells. */
[[nodiscard]] std::optional<double> expectedCalibrationError(const RankedPredictions& predictions,
                                                             size_t bins = kCalibrationBins);

/// The rates that result if every cell with prob ≥ threshold is called occupied.
struct RocPoint
{
  double threshold = 0;
  double falsePositiveRate = 0;
  double truePositiveRate = 0;
};

/** The ROC curve from (0, 0), whose threshold is infinite, to (1, 1). Points inside straight segments are
 * omitted.
 * @return empty unless there are both classes. */
[[nodiscard]] std::vector<RocPoint> rocCurve(const RankedPredictions& predictions);

}  // namespace lamap
