// Builds our maps and MRPT's COctoMap of worlds whose truth is known, and prints the scores of each. Cells
// that a map has not observed count as P(occupied) = 0.5. Fails if ours is not better.
#include <lamap_core/metrics/metrics.h>
#include <lamap_mrpt/maps/CBGKMap.h>
#include <mrpt/maps/COctoMap.h>

#include <cstdio>
#include <functional>
#include <utility>
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
  double precision = 0;  ///< of P(occupied) >= 0.7
  double recall = 0;
};

Score scoreOf(const std::vector<TrueCell>& truth, const std::function<double(const Eigen::Vector3d&)>& probAt)
{
  std::vector<lamap::PredictedCells> cells;
  cells.reserve(truth.size());
  for (const TrueCell& cell : truth)
    cells.push_back({probAt(cell.centre_map), cell.occupied ? 1u : 0u, cell.occupied ? 0u : 1u});
  const lamap::RankedPredictions predictions(std::move(cells));
  const auto [precision, recall] = lamap::precisionRecall(predictions, 0.7, lamap::ThresholdRule::AtLeast);
  return {lamap::areaUnderRoc(predictions).value(), lamap::logLoss(predictions).value(),
          precision.value_or(1.0), recall.value()};
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
