#include <lamap_core/metrics/metrics.h>
#include <lamap_core/options/legal_range.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace lamap
{
namespace
{
double asNumber(uint64_t count)
{
  return static_cast<double>(count);
}

template <class Term>
std::optional<double> meanOverCells(const RankedPredictions& predictions, const Term& term)
{
  if (predictions.cells() == 0) return std::nullopt;
  double sum = 0;
  for (const PredictedCells& tied : predictions.ascending()) sum += term(tied);
  return sum / asNumber(predictions.cells());
}
}  // namespace

RankedPredictions::RankedPredictions(std::vector<PredictedCells> predictions)
    : ascending_(std::move(predictions))
{
  for (const PredictedCells& given : ascending_)
    requireLegal(given.prob >= 0 && given.prob <= 1, "prob", given.prob, "a probability from 0 to 1");
  std::sort(ascending_.begin(), ascending_.end(),
            [](const PredictedCells& a, const PredictedCells& b) { return a.prob < b.prob; });
  size_t kept = 0;
  for (const PredictedCells& given : ascending_)
  {
    if (given.occupied + given.free == 0) continue;
    occupied_ += given.occupied;
    free_ += given.free;
    if (kept > 0 && ascending_[kept - 1].prob == given.prob)
    {
      ascending_[kept - 1].occupied += given.occupied;
      ascending_[kept - 1].free += given.free;
    }
    else
      ascending_[kept++] = given;
  }
  ascending_.resize(kept);
}

std::optional<double> areaUnderRoc(const RankedPredictions& predictions)
{
  if (!predictions.hasBothClasses()) return std::nullopt;
  double wins = 0;
  double freeBelow = 0;
  for (const PredictedCells& tied : predictions.ascending())
  {
    wins += asNumber(tied.occupied) * (freeBelow + asNumber(tied.free) / 2);
    freeBelow += asNumber(tied.free);
  }
  return wins / (asNumber(predictions.occupied()) * asNumber(predictions.free()));
}

std::optional<double> averagePrecision(const RankedPredictions& predictions)
{
  if (!predictions.hasBothClasses()) return std::nullopt;
  double sum = 0;
  uint64_t hits = 0;
  uint64_t called = 0;
  const auto& ascending = predictions.ascending();
  for (auto tied = ascending.rbegin(); tied != ascending.rend(); ++tied)
  {
    hits += tied->occupied;
    called += tied->occupied + tied->free;
    sum += asNumber(tied->occupied) * asNumber(hits) / asNumber(called);
  }
  return sum / asNumber(predictions.occupied());
}

PrecisionRecall precisionRecall(const RankedPredictions& predictions, double threshold, ThresholdRule rule)
{
  uint64_t hits = 0;
  uint64_t called = 0;
  for (const PredictedCells& tied : predictions.ascending())
  {
    const bool calledOccupied = rule == ThresholdRule::Above ? tied.prob > threshold + kThresholdTolerance
                                                             : tied.prob >= threshold - kThresholdTolerance;
    if (!calledOccupied) continue;
    hits += tied.occupied;
    called += tied.occupied + tied.free;
  }
  PrecisionRecall result;
  if (called > 0) result.precision = asNumber(hits) / asNumber(called);
  if (predictions.occupied() > 0) result.recall = asNumber(hits) / asNumber(predictions.occupied());
  return result;
}

std::optional<double> logLoss(const RankedPredictions& predictions, double clip)
{
  requireLegal(clip > 0 && clip < 0.5, "clip", clip, "> 0 and < 0.5");
  return meanOverCells(predictions,
                       [clip](const PredictedCells& tied)
                       {
                         const double prob = std::clamp(tied.prob, clip, 1 - clip);
                         return -asNumber(tied.occupied) * std::log(prob) -
                                asNumber(tied.free) * std::log1p(-prob);
                       });
}

std::optional<double> brierScore(const RankedPredictions& predictions)
{
  return meanOverCells(predictions,
                       [](const PredictedCells& tied)
                       {
                         const double ofFree = tied.prob * tied.prob;
                         const double ofOccupied = (1 - tied.prob) * (1 - tied.prob);
                         return asNumber(tied.occupied) * ofOccupied + asNumber(tied.free) * ofFree;
                       });
}

std::vector<CalibrationBin> calibrationBins(const RankedPredictions& predictions, size_t bins)
{
  requireLegal(bins > 0, "bins", asNumber(bins), "> 0");
  std::vector<CalibrationBin> result(bins);
  for (size_t i = 0; i < bins; ++i)
  {
    result[i].low = asNumber(i) / asNumber(bins);
    result[i].high = asNumber(i + 1) / asNumber(bins);
  }
  for (const PredictedCells& tied : predictions.ascending())
  {
    CalibrationBin& bin = result[std::min(bins - 1, static_cast<size_t>(tied.prob * asNumber(bins)))];
    const uint64_t cells = tied.occupied + tied.free;
    bin.cells += cells;
    bin.meanProb += tied.prob * asNumber(cells);
    bin.occupiedShare += asNumber(tied.occupied);
  }
  for (CalibrationBin& bin : result)
  {
    if (bin.cells == 0) continue;
    bin.meanProb /= asNumber(bin.cells);
    bin.occupiedShare /= asNumber(bin.cells);
  }
  return result;
}

std::optional<double> expectedCalibrationError(const RankedPredictions& predictions, size_t bins)
{
  const auto filled = calibrationBins(predictions, bins);
  if (predictions.cells() == 0) return std::nullopt;
  double sum = 0;
  for (const CalibrationBin& bin : filled)
    sum += asNumber(bin.cells) * std::abs(bin.meanProb - bin.occupiedShare);
  return sum / asNumber(predictions.cells());
}

std::vector<RocPoint> rocCurve(const RankedPredictions& predictions)
{
  if (!predictions.hasBothClasses()) return {};
  const double occupied = asNumber(predictions.occupied());
  const double free = asNumber(predictions.free());
  std::vector<RocPoint> curve{{std::numeric_limits<double>::infinity(), 0, 0}};
  uint64_t hits = 0;
  uint64_t alarms = 0;
  PredictedCells step;  // summed over the straight segment that ends at the curve's last point
  const auto& ascending = predictions.ascending();
  for (auto tied = ascending.rbegin(); tied != ascending.rend(); ++tied)
  {
    hits += tied->occupied;
    alarms += tied->free;
    const RocPoint point{tied->prob, asNumber(alarms) / free, asNumber(hits) / occupied};
    const bool continuesStraight = curve.size() > 1 && asNumber(step.occupied) * asNumber(tied->free) ==
                                                           asNumber(step.free) * asNumber(tied->occupied);
    if (continuesStraight)
    {
      curve.back() = point;
      step.occupied += tied->occupied;
      step.free += tied->free;
    }
    else
    {
      curve.push_back(point);
      step = *tied;
    }
  }
  return curve;
}

}  // namespace lamap
