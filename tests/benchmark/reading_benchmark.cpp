// Reads from maps of the same scans: our maps, OctoMap itself and MRPT's COctoMap, in turn, and prints how
// many times as fast as these peers each of ours is. Only ratios of one run mean anything: machines are
// noisy.
//   reading_benchmark --benchmark_repetitions=9
#include <benchmark/benchmark.h>
#include <lamap_mrpt/maps/CBGKMap.h>
#include <lamap_mrpt/maps/CGPMap.h>
#include <lamap_mrpt/maps/CHilbertMap.h>
#include <lamap_mrpt/maps/COverlappingHilbertMap.h>
#include <lamap_mrpt/observations/observation_rays.h>
#include <mrpt/maps/COctoMap.h>
#include <octomap/octomap.h>

#include <cstdio>
#include <ctime>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "benchmark_scans.h"
#include "median_reporter.h"

namespace
{
using lamap::test::PosedObservation;
using lamap::test::ScanSeries;

constexpr double kResolution_m = 0.10;
constexpr size_t kQueries = 1000000;
constexpr size_t kRays = 10000;
constexpr size_t kBoxes = 20;

using Points = std::vector<Eigen::Vector3d>;

struct Box
{
  Eigen::Vector3d low;
  Eigen::Vector3d high;
};

struct Ray
{
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;
};

/// What all maps of a series are asked.
struct Questions
{
  Points random;           ///< anywhere in the box of what is known
  Points coherent;         ///< all over boxes, row by row, half a cell apart
  Points lines;            ///< along lines of 5 m in the box of what is known, half a cell apart
  std::vector<Box> boxes;  ///< of 5 × 5 × 2 m around where the sensor was
  std::vector<Ray> rays;   ///< from where the sensor was, to all sides
};

struct Candidate
{
  std::string name;
  std::string task;
  std::string peer;  ///< whose time is divided by this one's; "": this is a peer
  std::function<void()> work;
  std::function<void()> before{};  ///< each time, and not timed
};

/// Processor time of this thread [s]: on a busy machine it tells more than the time that passed.
double threadSeconds()
{
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Times only the work: with a clock of its own, since pausing that of the library takes longer than some
/// work.
void run(benchmark::State& state, const Candidate& candidate)
{
  candidate.work();  // makes what it asks
  for (auto _ : state)
  {
    if (candidate.before) candidate.before();
    const double start = threadSeconds();
    candidate.work();
    state.SetIterationTime(threadSeconds() - start);
  }
}

/// Maps of a series, each made when it is first asked.
class Maps
{
 public:
  explicit Maps(ScanSeries scans) : series(std::move(scans))
  {
    for (const PosedObservation& scan : series.scans)
    {
      const lamap::Scan rays = lamap::raysOf(*scan.observation, scan.robotPose).value();
      for (const lamap::RayFan& fan : rays.fans)
      {
        const Eigen::Vector3f centre = rays.inMap(fan.centre).cast<float>();
        octomap::Pointcloud points;
        for (const lamap::Ray& ray : fan.rays)
        {
          const Eigen::Vector3f end = rays.inMap(ray.end).cast<float>();
          if (ray.meaning == lamap::RayEnd::Return) points.push_back(end.x(), end.y(), end.z());
        }
        octomap.insertPointCloud(points, {centre.x(), centre.y(), centre.z()}, series.rangeMax_m);
        sensors.push_back(rays.inMap(fan.centre));
      }
    }
  }

  [[nodiscard]] const mrpt::maps::COctoMap& mrptOctomap()
  {
    if (!mrptOctomap_)
    {
      mrptOctomap_ = std::make_unique<mrpt::maps::COctoMap>(kResolution_m);
      mrptOctomap_->insertionOptions.maxrange = static_cast<float>(series.rangeMax_m);
      insertAll(*mrptOctomap_);
    }
    return *mrptOctomap_;
  }
  template <typename Map>
  [[nodiscard]] Map& map()
  {
    auto& kept = std::get<std::unique_ptr<Map>>(learned_);
    if (!kept)
    {
      kept = std::make_unique<Map>(kResolution_m);
      kept->setThreadCount(1);
      kept->insertionOptions.maxRange = series.rangeMax_m;
      insertAll(*kept);
    }
    return *kept;
  }

  const ScanSeries series;
  Points sensors;
  octomap::OcTree octomap{kResolution_m};

 private:
  void insertAll(mrpt::maps::CMetricMap& map) const
  {
    for (const PosedObservation& scan : series.scans)
      map.insertObservation(*scan.observation, scan.robotPose);
  }

  std::unique_ptr<mrpt::maps::COctoMap> mrptOctomap_;
  std::tuple<std::unique_ptr<lamap::CBGKMap>, std::unique_ptr<lamap::CGPMap>,
             std::unique_ptr<lamap::COverlappingHilbertMap>, std::unique_ptr<lamap::CHilbertMap>>
      learned_;
};

Questions questionsFor(const Maps& maps)
{
  std::mt19937 generator(3);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(generator()) / static_cast<double>(std::mt19937::max());
  };
  Eigen::Vector3d low;
  Eigen::Vector3d high;
  maps.octomap.getMetricMin(low.x(), low.y(), low.z());
  maps.octomap.getMetricMax(high.x(), high.y(), high.z());
  const auto inside = [&]
  {
    return Eigen::Vector3d(uniform(low.x(), high.x()), uniform(low.y(), high.y()),
                           uniform(low.z(), high.z()));
  };
  const auto direction = [&]
  {
    Eigen::Vector3d d;
    do d = {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
    while (d.squaredNorm() > 1 || d.squaredNorm() < 0.01);
    return Eigen::Vector3d(d.normalized());
  };
  Questions questions;
  for (size_t i = 0; i < kQueries; ++i) questions.random.push_back(inside());
  while (questions.lines.size() < kQueries)
  {
    const Eigen::Vector3d from = inside();
    const Eigen::Vector3d step = 0.5 * kResolution_m * direction();
    for (int i = 0; i < 100; ++i) questions.lines.push_back(from + i * step);
  }
  for (size_t i = 0; i < kBoxes; ++i)
  {
    const Eigen::Vector3d low_map = maps.sensors[i % maps.sensors.size()] - Eigen::Vector3d(2.5, 2.5, 1);
    questions.boxes.push_back({low_map, low_map + Eigen::Vector3d(5, 5, 2)});
  }
  constexpr double kStep_m = 0.5 * kResolution_m;
  for (const Box& box : questions.boxes)
    for (double z = box.low.z(); z < box.high.z(); z += kStep_m)
      for (double y = box.low.y(); y < box.high.y(); y += kStep_m)
        for (double x = box.low.x(); x < box.high.x() && questions.coherent.size() < kQueries; x += kStep_m)
          questions.coherent.emplace_back(x, y, z);
  for (size_t i = 0; i < kRays; ++i)
    questions.rays.push_back({maps.sensors[i % maps.sensors.size()], direction()});
  return questions;
}

octomap::point3d octomapPoint(const Eigen::Vector3d& point)
{
  const Eigen::Vector3f p = point.cast<float>();
  return {p.x(), p.y(), p.z()};
}

std::vector<octomap::point3d> octomapPoints(const Points& points)
{
  std::vector<octomap::point3d> all;
  for (const Eigen::Vector3d& point : points) all.push_back(octomapPoint(point));
  return all;
}

void searchAll(const octomap::OcTree& tree, const std::vector<octomap::point3d>& points)
{
  size_t occupied = 0;
  for (const octomap::point3d& point : points)
  {
    const octomap::OcTreeNode* node = tree.search(point);
    occupied += node != nullptr && node->getLogOdds() > 0;
  }
  benchmark::DoNotOptimize(occupied);
}

void askAll(const lamap::CLearnedMap& map, const Points& points)
{
  size_t occupied = 0;
  for (const Eigen::Vector3d& point : points)
  {
    const auto estimate = map.estimateAt({point.x(), point.y(), point.z()});
    occupied += estimate && estimate->state == lamap::CellState::Occupied;
  }
  benchmark::DoNotOptimize(occupied);
}

template <typename Map>
void accessAll(const Map& map, const Points& points)
{
  typename Map::Core::Accessor accessor(map.core(), map.stateThresholds());
  size_t occupied = 0;
  for (const Eigen::Vector3d& point : points)
    occupied += accessor.stateAt(point) == lamap::CellState::Occupied;
  benchmark::DoNotOptimize(occupied);
}

template <typename Map>
void castAll(const Map& map, const std::vector<Ray>& rays, bool ignoreUnknown)
{
  mrpt::math::TPoint3D end;
  size_t hits = 0;
  for (const Ray& ray : rays)
    hits += map.castRay({ray.origin.x(), ray.origin.y(), ray.origin.z()},
                        {ray.direction.x(), ray.direction.y(), ray.direction.z()}, end, ignoreUnknown, 20.0);
  benchmark::DoNotOptimize(hits);
}

void iterateAll(const octomap::OcTree& tree, const std::vector<Box>& boxes)
{
  double sum = 0;
  for (const Box& box : boxes)
    for (auto leaf = tree.begin_leafs_bbx(octomapPoint(box.low), octomapPoint(box.high));
         leaf != tree.end_leafs_bbx(); ++leaf)
      sum += static_cast<double>(leaf->getLogOdds());
  benchmark::DoNotOptimize(sum);
}

template <typename Map>
void visitAll(const Map& map, const std::vector<Box>& boxes)
{
  typename Map::Core::Accessor accessor(map.core(), map.stateThresholds());
  double sum = 0;
  for (const Box& box : boxes)
    accessor.visitBox(*lamap::cellAt(box.low, map.resolution()), *lamap::cellAt(box.high, map.resolution()),
                      [&](const lamap::KnownCell& cell) { sum += cell.prob; });
  benchmark::DoNotOptimize(sum);
}

constexpr const char* kOctomap = "OctoMap";
constexpr const char* kMrpt = "COctoMap";

/// All work on maps that stay.
std::vector<Candidate> candidatesFor(const std::shared_ptr<Maps>& maps)
{
  const auto asked = std::make_shared<const Questions>(questionsFor(*maps));
  std::vector<Candidate> candidates;
  const auto add = [&](const std::string& task, const std::string& name, const std::string& peer,
                       std::function<void()> work) {
    candidates.push_back({name, task, peer, std::move(work)});
  };
  const auto addPeer = [&](const std::string& task, std::function<void()> work)
  { add(task, kOctomap, "", std::move(work)); };
  const auto addOurs = [&](const std::string& task, const std::string& peer, const auto& work)
  {
    // A map is made when it is first asked.
    add(task, "CBGKMap", peer, [=] { work(maps->map<lamap::CBGKMap>()); });
    add(task, "CGPMap", peer, [=] { work(maps->map<lamap::CGPMap>()); });
    add(task, "COverlappingHilbertMap", peer, [=] { work(maps->map<lamap::COverlappingHilbertMap>()); });
  };
  const std::vector<std::pair<std::string, const Points*>> queries = {{"random queries", &asked->random},
                                                                      {"coherent queries", &asked->coherent},
                                                                      {"queries along lines", &asked->lines}};
  for (const auto& [task, points] : queries)
  {
    addPeer(task, [maps, p = octomapPoints(*points)] { searchAll(maps->octomap, p); });
    add(task, "CBGKMap::estimateAt", kOctomap,
        [maps, asked, points = points] { askAll(maps->map<lamap::CBGKMap>(), *points); });
    addOurs(task, kOctomap, [asked, points = points](const auto& map) { accessAll(map, *points); });
  }
  addPeer("boxes", [maps, asked] { iterateAll(maps->octomap, asked->boxes); });
  addOurs("boxes", kOctomap, [asked](const auto& map) { visitAll(map, asked->boxes); });
  for (const bool ignoreUnknown : {false, true})
  {
    const std::string task = ignoreUnknown ? "rays through unknown cells" : "rays to the first unknown cell";
    add(task, kMrpt, "", [=] { castAll(maps->mrptOctomap(), asked->rays, ignoreUnknown); });
    addOurs(task, kMrpt, [=](const auto& map) { castAll(map, asked->rays, ignoreUnknown); });
  }
  add("a particle's copy", kMrpt, "",
      [maps] { benchmark::DoNotOptimize(mrpt::maps::COctoMap(maps->mrptOctomap()).isEmpty()); });
  addOurs("a particle's copy", kMrpt,
          [](const auto& map) { benchmark::DoNotOptimize(std::decay_t<decltype(map)>(map).isEmpty()); });
  return candidates;
}

/// The likelihood of a scan at its pose, of a map that stays and after an insertion.
std::vector<Candidate> likelihoodCandidates(const std::shared_ptr<Maps>& maps)
{
  std::vector<Candidate> candidates;
  const PosedObservation& scan = maps->series.scans[maps->series.scans.size() / 2];
  const auto likelihoodIn = [maps, &scan](const mrpt::maps::CMetricMap& map)
  { benchmark::DoNotOptimize(map.computeObservationLikelihood(*scan.observation, scan.robotPose)); };
  candidates.push_back({kMrpt, "likelihood", "", [=] { likelihoodIn(maps->mrptOctomap()); }});
  const auto addBoth = [&](const std::string& name, const auto& mapOf)
  {
    candidates.push_back({name, "likelihood", kMrpt, [=] { likelihoodIn(mapOf()); }});
    candidates.push_back({name + ", after an insertion", "likelihood", kMrpt, [=] { likelihoodIn(mapOf()); },
                          [=] { mapOf().insertObservation(*scan.observation, scan.robotPose); }});
  };
  addBoth(
      "CBGKMap", [maps]() -> auto& { return maps->map<lamap::CBGKMap>(); });
  addBoth(
      "CGPMap", [maps]() -> auto& { return maps->map<lamap::CGPMap>(); });
  return candidates;
}
}  // namespace

int main(int argc, char** argv)
{
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  const std::vector<ScanSeries> allSeries = {lamap::test::sectorLaserSeries(), lamap::test::panTiltSeries(),
                                             lamap::test::planarLaserSeries()};
  std::vector<std::pair<std::string, std::vector<Candidate>>> candidates;
  for (const ScanSeries& series : allSeries)
  {
    const auto maps = std::make_shared<Maps>(series);
    candidates.emplace_back(series.name, series.planar ? likelihoodCandidates(maps) : candidatesFor(maps));
    for (const Candidate& candidate : candidates.back().second)
      benchmark::RegisterBenchmark((series.name + " / " + candidate.task + " / " + candidate.name).c_str(),
                                   [candidate](benchmark::State& state) { run(state, candidate); })
          ->Unit(benchmark::kMicrosecond)
          ->UseManualTime();
  }
  lamap::test::MedianReporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  std::printf("\nTimes as fast as the peer (medians of this run):\n");
  for (const auto& [series, all] : candidates)
  {
    std::printf("  %s\n", series.c_str());
    for (const Candidate& candidate : all)
    {
      const auto time = [&](const std::string& name)
      { return reporter.median(series + " / " + candidate.task + " / " + name); };
      if (!candidate.peer.empty() && time(candidate.name) > 0)
        std::printf("    %-32s %-40s %6.1f x %s\n", candidate.task.c_str(), candidate.name.c_str(),
                    time(candidate.peer) / time(candidate.name), candidate.peer.c_str());
    }
  }
}
