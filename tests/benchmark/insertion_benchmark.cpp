// Inserts the same scans into our maps, MRPT's COctoMap and OctoMap itself, in turn, and prints how many
// times as fast as COctoMap each is. Only ratios of one run mean anything: machines are noisy.
//   insertion_benchmark --benchmark_repetitions=9
#include <benchmark/benchmark.h>
#include <lamap_mrpt/maps/CBGKMap.h>
#include <lamap_mrpt/maps/CGPMap.h>
#include <lamap_mrpt/maps/CHilbertMap.h>
#include <lamap_mrpt/maps/COverlappingHilbertMap.h>
#include <lamap_mrpt/observations/observation_rays.h>
#include <mrpt/maps/COctoMap.h>
#include <octomap/octomap.h>

#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "benchmark_scans.h"
#include "median_reporter.h"

namespace
{
using lamap::test::PosedObservation;
using lamap::test::ScanSeries;

constexpr double kResolution_m = 0.10;

/// Inserts all scans into a new map.
using MapBuilder = std::function<void()>;

struct Candidate
{
  std::string name;
  MapBuilder build;
};

void insertAll(mrpt::maps::CMetricMap& map, const ScanSeries& series)
{
  for (const PosedObservation& scan : series.scans) map.insertObservation(*scan.observation, scan.robotPose);
  benchmark::DoNotOptimize(map.isEmpty());
}

void buildMrptOctoMap(const ScanSeries& series)
{
  mrpt::maps::COctoMap map(kResolution_m);
  map.insertionOptions.maxrange = series.rangeMax_m;
  insertAll(map, series);
}

/// How a map differs from the default.
struct Mode
{
  unsigned threads = 1;
  bool planar = false;
  std::string preset{};  ///< its name; "": none
  bool line = false;     ///< freeSpace = line
};

template <typename Map>
void buildMap(const ScanSeries& series, const Mode& mode)
{
  auto definition = Map::MapDefinition();
  auto& options = dynamic_cast<typename Map::TMapDefinition&>(*definition);
  if (!mode.preset.empty())
  {
    options.creationOpts.optionTable().require("preset").parse(options.creationOpts, mode.preset);
    options.usePreset();
  }
  if constexpr (std::is_same_v<Map, lamap::CBGKMap>)
    if (mode.line) options.insertionOpts.freeSpace = lamap::FreeSpace::Line;
  options.creationOpts.resolution = kResolution_m;
  options.creationOpts.planar = mode.planar;
  Map map(options.creationOpts);
  map.insertionOptions = options.insertionOpts;
  map.insertionOptions.maxRange = series.rangeMax_m;
  map.setThreadCount(mode.threads);
  insertAll(map, series);
}

/// A scan as OctoMap takes it: nothing is left to convert.
struct OctomapScan
{
  octomap::Pointcloud points_map;
  octomap::point3d origin_map;
};

octomap::point3d octomapPoint(const Eigen::Vector3d& point)
{
  const Eigen::Vector3f p = point.cast<float>();
  return {p.x(), p.y(), p.z()};
}

std::vector<OctomapScan> octomapScans(const ScanSeries& series)
{
  std::vector<OctomapScan> scans;
  for (const PosedObservation& scan : series.scans)
  {
    const lamap::Scan rays = lamap::raysOf(*scan.observation, scan.robotPose).value();
    for (const lamap::RayFan& fan : rays.fans)
    {
      scans.push_back({{}, octomapPoint(rays.inMap(fan.centre))});
      for (const lamap::Ray& ray : fan.rays)
        if (ray.meaning == lamap::RayEnd::Return)
          scans.back().points_map.push_back(octomapPoint(rays.inMap(ray.end)));
    }
  }
  return scans;
}

void buildOctomap(const std::vector<OctomapScan>& scans, double rangeMax_m)
{
  octomap::OcTree tree(kResolution_m);
  for (const OctomapScan& scan : scans) tree.insertPointCloud(scan.points_map, scan.origin_map, rangeMax_m);
  benchmark::DoNotOptimize(tree.size());
}

constexpr const char* kPeer = "COctoMap";

std::vector<Candidate> candidatesFor(const ScanSeries& series)
{
  std::vector<Candidate> candidates = {
      {kPeer, [&series] { buildMrptOctoMap(series); }},
      {"OctoMap", [scans = octomapScans(series), &series] { buildOctomap(scans, series.rangeMax_m); }},
      {"CBGKMap, 1 thread", [&series] { buildMap<lamap::CBGKMap>(series, {}); }},
      {"CBGKMap, 2 threads", [&series] { buildMap<lamap::CBGKMap>(series, {2}); }}};
  if (series.planar)
    candidates.push_back({"CBGKMap, planar, 1 thread", [&series] {
                            buildMap<lamap::CBGKMap>(series, {1, true});
                          }});
  // One thread each.
  candidates.insert(
      candidates.end(),
      {{"CBGKMap, freeSpace line",
        [&series] {
          buildMap<lamap::CBGKMap>(series, {1, false, "", true});
        }},
       {"CBGKMap, preset la3dm",
        [&series] {
          buildMap<lamap::CBGKMap>(series, {1, false, "la3dm"});
        }},
       {"CBGKMap, preset thesis",
        [&series] {
          buildMap<lamap::CBGKMap>(series, {1, false, "thesis"});
        }},
       {"CHilbertMap", [&series] { buildMap<lamap::CHilbertMap>(series, {}); }},
       {"COverlappingHilbertMap", [&series] { buildMap<lamap::COverlappingHilbertMap>(series, {}); }},
       {"CGPMap", [&series] { buildMap<lamap::CGPMap>(series, {}); }}});
  return candidates;
}

void run(benchmark::State& state, size_t scans, const MapBuilder& build)
{
  for (auto _ : state) build();
  state.counters["ms/scan"] =
      benchmark::Counter(static_cast<double>(scans) * static_cast<double>(state.iterations()) * 1e-3,
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void printRatios(const lamap::test::MedianReporter& reporter, const std::vector<ScanSeries>& allSeries)
{
  std::printf("\nTimes as fast as %s (medians of this run):\n", kPeer);
  for (const ScanSeries& series : allSeries)
  {
    std::printf("  %s\n", series.name.c_str());
    const double peer = reporter.median(series.name + " / " + kPeer);
    for (const Candidate& candidate : candidatesFor(series))
    {
      const double own = reporter.median(series.name + " / " + candidate.name);
      if (own > 0) std::printf("    %-26s %6.1f\n", candidate.name.c_str(), peer / own);
    }
  }
}

}  // namespace

int main(int argc, char** argv)
{
  const std::vector<ScanSeries> allSeries = {lamap::test::sectorLaserSeries(), lamap::test::panTiltSeries(),
                                             lamap::test::planarLaserSeries()};
  for (const ScanSeries& series : allSeries)
  {
    for (const Candidate& candidate : candidatesFor(series))
    {
      benchmark::RegisterBenchmark((series.name + " / " + candidate.name).c_str(),
                                   [&series, build = candidate.build](benchmark::State& state)
                                   { run(state, series.scans.size(), build); })
          ->Unit(benchmark::kMillisecond)
          ->UseRealTime();
    }
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  lamap::test::MedianReporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  printRatios(reporter, allSeries);
}
