#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace lamap
{
/// Cells that were given one probability, and how many of them are occupied and free in truth.
struct PredictedCells
{
  double prob = 0.5;  ///< P(occupied), in [0, 1]
  uint64_t occupied = 0;
  uint64_t free = 0;
};

/** Predictions and their truth in the order of probability: what every score below is made from.
 *
 * Invariants: probabilities rise strictly (cells of equal probability stand together, so ties are exact
 * whatever the order in which they were given), and no entry is without cells. Immutable: may be shared
 * between threads. Counts are exact up to 2^53 cells.
 */
class RankedPredictions
{
 public:
  /// @param predictions in any order, a probability as often as one likes.
  /// @throws std::invalid_argument for a probability that is NaN or outside of [0, 1].
  explicit RankedPredictions(std::vector<PredictedCells> predictions);

  [[nodiscard]] const std::vector<PredictedCells>& ascending() const { return ascending_; }
  [[nodiscard]] uint64_t occupied() const { return occupied_; }
  [[nodiscard]] uint64_t free() const { return free_; }
  [[nodiscard]] uint64_t cells() const { return occupied_ + free_; }
  /// Whether there are occupied and free cells: without either, nothing can be ranked.
  [[nodiscard]] bool hasBothClasses() const { return occupied_ > 0 && free_ > 0; }

 private:
  std::vector<PredictedCells> ascending_;
  uint64_t occupied_ = 0;
  uint64_t free_ = 0;
};

/** Area under the ROC curve: the probability that an occupied cell, drawn at random, was given a higher
 * probability than a free one, ties counted half (Mann-Whitney with average ranks).
 * @return in [0, 1]; nothing unless there are both classes. */
[[nodiscard]] std::optional<double> areaUnderRoc(const RankedPredictions& predictions);

/** Average precision Σ (Rₙ − Rₙ₋₁) Pₙ over all distinct probabilities as thresholds, from the highest down;
 * no interpolation.
 * @return in [0, 1]; nothing unless there are both classes. */
[[nodiscard]] std::optional<double> averagePrecision(const RankedPredictions& predictions);

/// Which cells a threshold calls occupied.
enum class ThresholdRule
{
  Above,   ///< prob > threshold (strict)
  AtLeast  ///< prob ≥ threshold (non-strict)
};

/** A probability as near to a threshold as this counts as equal to it: maps that hold log-odds as floats give
 * 0.69999999 for 0.7. */
constexpr double kThresholdTolerance = 1e-6;

struct PrecisionRecall
{
  /// Share of the cells called occupied that are; nothing if none was called so.
  std::optional<double> precision;
  /// Share of the occupied cells that were called so; nothing if none is.
  std::optional<double> recall;
};
[[nodiscard]] PrecisionRecall precisionRecall(const RankedPredictions& predictions, double threshold,
                                              ThresholdRule rule);

/// How near to 0 and 1 the log loss takes probabilities: a certain error costs 13.8 nats, not infinity.
constexpr double kLogLossClip = 1e-6;

/** Mean of −ln(probability given to what is true) [nats], probabilities clipped to [clip, 1 − clip].
 * @param clip in (0, 0.5). @return ≥ 0; nothing without cells.
 * @throws std::invalid_argument for another clip. */
[[nodiscard]] std::optional<double> logLoss(const RankedPredictions& predictions, double clip = kLogLossClip);

/// Mean of (prob − truth)², truth 1 or 0. @return in [0, 1]; nothing without cells.
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

/// Bins of equal width from 0 to 1, empty ones too. @throws std::invalid_argument for no bins.
[[nodiscard]] std::vector<CalibrationBin> calibrationBins(const RankedPredictions& predictions,
                                                          size_t bins = kCalibrationBins);

/** Mean over all cells of |meanProb − occupiedShare| of the cell's bin.
 * @return in [0, 1]; nothing without cells. */
[[nodiscard]] std::optional<double> expectedCalibrationError(const RankedPredictions& predictions,
                                                             size_t bins = kCalibrationBins);

/// What calling every cell with prob ≥ threshold occupied comes to.
struct RocPoint
{
  double threshold = 0;
  double falsePositiveRate = 0;
  double truePositiveRate = 0;
};

/** The ROC curve from (0, 0), whose threshold is infinite, to (1, 1). Points inside of a straight piece are
 * left out.
 * @return empty unless there are both classes. */
[[nodiscard]] std::vector<RocPoint> rocCurve(const RankedPredictions& predictions);

}  // namespace lamap
