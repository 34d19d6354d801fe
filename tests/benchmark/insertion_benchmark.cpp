// Inserts the same scans into our maps and into MRPT's COctoMap, in turn, and prints how many times faster
// ours are. Only ratios of one run mean anything: machines are noisy.
//   insertion_benchmark --benchmark_repetitions=9
#include <benchmark/benchmark.h>
#include <lamap_mrpt/CBGKMap.h>
#include <mrpt/maps/COctoMap.h>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "benchmark_scans.h"

namespace
{
using lamap::test::PosedObservation;
using lamap::test::ScanSeries;
using MapMaker = std::function<std::unique_ptr<mrpt::maps::CMetricMap>(const ScanSeries&)>;

struct Candidate
{
  std::string name;
  MapMaker make;
};

std::unique_ptr<mrpt::maps::CMetricMap> makeOctoMap(const ScanSeries& series)
{
  auto map = std::make_unique<mrpt::maps::COctoMap>(0.10);
  map->insertionOptions.maxrange = series.rangeMax_m;
  return map;
}

std::unique_ptr<mrpt::maps::CMetricMap> makeBgkMap(const ScanSeries& series, unsigned threads, bool planar)
{
  lamap::CBGKMap::TCreationOptions options;
  options.planar = planar;
  auto map = std::make_unique<lamap::CBGKMap>(options);
  map->insertionOptions.maxRange = series.rangeMax_m;
  map->setThreadCount(threads);
  return map;
}

constexpr const char* kPeer = "COctoMap";

std::vector<Candidate> candidatesFor(const ScanSeries& series)
{
  std::vector<Candidate> candidates = {
      {kPeer, makeOctoMap},
      {"CBGKMap, 1 thread", [](const ScanSeries& s) { return makeBgkMap(s, 1, false); }},
      {"CBGKMap, 2 threads", [](const ScanSeries& s) { return makeBgkMap(s, 2, false); }}};
  if (series.planar)
    candidates.push_back(
        {"CBGKMap, planar, 1 thread", [](const ScanSeries& s) { return makeBgkMap(s, 1, true); }});
  return candidates;
}

void insertAll(benchmark::State& state, const ScanSeries& series, const MapMaker& make)
{
  for (auto _ : state)
  {
    const auto map = make(series);
    for (const PosedObservation& scan : series.scans)
      map->insertObservation(*scan.observation, scan.robotPose);
    benchmark::DoNotOptimize(map->isEmpty());
  }
  state.counters["ms/scan"] = benchmark::Counter(
      static_cast<double>(series.scans.size()) * static_cast<double>(state.iterations()) * 1e-3,
      benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

/// Collects the time of every repetition beside the usual output.
class RatioReporter : public benchmark::ConsoleReporter
{
 public:
  void ReportRuns(const std::vector<Run>& runs) override
  {
    ConsoleReporter::ReportRuns(runs);
    for (const Run& run : runs)
    {
      if (run.run_type == Run::RT_Iteration)
        times_[run.run_name.function_name].push_back(run.GetAdjustedRealTime());
    }
  }

  void printRatios(const std::vector<ScanSeries>& allSeries) const
  {
    std::printf("\nTimes as fast as %s (medians of this run):\n", kPeer);
    for (const ScanSeries& series : allSeries)
    {
      std::printf("  %s\n", series.name.c_str());
      const double peer = median(series.name + " / " + kPeer);
      for (const Candidate& candidate : candidatesFor(series))
      {
        const double own = median(series.name + " / " + candidate.name);
        if (own > 0) std::printf("    %-26s %6.1f\n", candidate.name.c_str(), peer / own);
      }
    }
  }

 private:
  [[nodiscard]] double median(const std::string& name) const
  {
    const auto found = times_.find(name);
    if (found == times_.end()) return 0.0;
    std::vector<double> times = found->second;
    std::nth_element(times.begin(), times.begin() + static_cast<long>(times.size() / 2), times.end());
    return times[times.size() / 2];
  }

  std::map<std::string, std::vector<double>> times_;
};

}  // namespace

int main(int argc, char** argv)
{
  const std::vector<ScanSeries> allSeries = {lamap::test::sectorLaserSeries(), lamap::test::panTiltSeries(),
                                             lamap::test::planarLaserSeries()};
  for (const ScanSeries& series : allSeries)
  {
    for (const Candidate& candidate : candidatesFor(series))
    {
      const MapMaker make = candidate.make;
      benchmark::RegisterBenchmark((series.name + " / " + candidate.name).c_str(),
                                   [&series, make](benchmark::State& state)
                                   { insertAll(state, series, make); })
          ->Unit(benchmark::kMillisecond)
          ->UseRealTime();
    }
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  RatioReporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  reporter.printRatios(allSeries);
}
