// Maps worlds whose truth is known with our maps and with MRPT's COctoMap and prints how well each knows it.
// Cells that a map has not observed count as P(occupied) = 0.5. Fails if ours is not the better one.
#include <lamap_mrpt/CBGKMap.h>
#include <mrpt/maps/COctoMap.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <vector>

#include "benchmark_scans.h"

namespace
{
using lamap::test::ScanSeries;
using lamap::test::TrueCell;

struct Score
{
  double areaUnderRoc = 0;
  double logLoss = 0;
  double precision = 0;  ///< of P(occupied) > 0.7
  double recall = 0;
};

struct Prediction
{
  double prob;
  bool occupied;
};

/// Probability that a random occupied cell ranks above a random free one, ties counted half.
double areaUnderRoc(std::vector<Prediction> predictions)
{
  std::sort(predictions.begin(), predictions.end(),
            [](const Prediction& a, const Prediction& b) { return a.prob < b.prob; });
  double wins = 0;
  double freeBelow = 0;
  double occupiedCount = 0;
  for (size_t begin = 0; begin < predictions.size();)
  {
    size_t end = begin;
    double occupied = 0;
    while (end < predictions.size() && predictions[end].prob == predictions[begin].prob)
      occupied += predictions[end++].occupied ? 1 : 0;
    const double free = static_cast<double>(end - begin) - occupied;
    wins += occupied * (freeBelow + free / 2);
    freeBelow += free;
    occupiedCount += occupied;
    begin = end;
  }
  return wins / (occupiedCount * freeBelow);
}

Score scoreOf(const std::vector<TrueCell>& truth, const std::function<double(const Eigen::Vector3d&)>& probAt)
{
  constexpr double kOccupied = 0.7;
  constexpr double kCertain = 1e-4;
  std::vector<Prediction> predictions;
  predictions.reserve(truth.size());
  double loss = 0;
  double hits = 0;
  double alarms = 0;
  double occupied = 0;
  for (const TrueCell& cell : truth)
  {
    const double prob = probAt(cell.centre_map);
    predictions.push_back({prob, cell.occupied});
    const double clamped = std::clamp(prob, kCertain, 1 - kCertain);
    loss -= std::log(cell.occupied ? clamped : 1 - clamped);
    occupied += cell.occupied ? 1 : 0;
    alarms += prob > kOccupied ? 1 : 0;
    hits += prob > kOccupied && cell.occupied ? 1 : 0;
  }
  return {areaUnderRoc(std::move(predictions)), loss / static_cast<double>(truth.size()),
          alarms > 0 ? hits / alarms : 1.0, hits / occupied};
}

Score scoreOctoMap(const ScanSeries& series)
{
  mrpt::maps::COctoMap map(0.10);
  map.insertionOptions.maxrange = series.rangeMax_m;
  for (const auto& scan : series.scans) map.insertObservation(*scan.observation, scan.robotPose);
  return scoreOf(series.truth,
                 [&](const Eigen::Vector3d& p)
                 {
                   double prob = 0.5;
                   const bool observed = map.getPointOccupancy(
                       static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()), prob);
                   return observed ? prob : 0.5;
                 });
}

Score scoreBgkMap(const ScanSeries& series)
{
  lamap::CBGKMap map(0.10);
  map.insertionOptions.maxRange = series.rangeMax_m;
  for (const auto& scan : series.scans) map.insertObservation(*scan.observation, scan.robotPose);
  return scoreOf(series.truth,
                 [&](const Eigen::Vector3d& p)
                 {
                   const auto estimate = map.estimateAt({p.x(), p.y(), p.z()});
                   return estimate ? estimate->prob : 0.5;
                 });
}

void print(const char* name, const Score& score)
{
  std::printf("  %-10s AUC %.3f   log loss %.3f   precision %.3f   recall %.3f\n", name, score.areaUnderRoc,
              score.logLoss, score.precision, score.recall);
}

}  // namespace

int main()
{
  bool better = true;
  for (const ScanSeries& series : {lamap::test::sectorLaserSeries(), lamap::test::panTiltSeries()})
  {
    std::printf("%s\n", series.name.c_str());
    const Score peer = scoreOctoMap(series);
    const Score own = scoreBgkMap(series);
    print("COctoMap", peer);
    print("CBGKMap", own);
    better = better && own.areaUnderRoc > peer.areaUnderRoc && own.logLoss < peer.logLoss;
  }
  return better ? 0 : 1;
}
