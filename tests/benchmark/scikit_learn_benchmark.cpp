// Learns and asks the same scans with our Hilbert maps and with scikit-learn, in turn, one thread each, and
// prints how many times faster ours are and how well each knows the place.
//   scikit_learn_benchmark [--scans N] [--repetitions N] [--passes N] [--python PATH]
// Asked are all cells within 8 m in the box of a scan's training points. The scans are those of the thesis's
// structured simulation, in the folder that the environment variable LAMAP_DATA names, each scored by the map
// of all others; without it they are taken in the `structured` world of lamap_sim, scored by its truth. Exit
// code 77: skipped, scikit-learn is missing.
#include <lamap_core/hilbert/map.h>
#include <lamap_core/math/portable_math.h>
#include <lamap_core/metrics/metrics.h>
#include <lamap_core/overlapping/map.h>
#include <lamap_core/overlapping/model_trainer.h>
#include <lamap_core/scan/lattice_frame.h>
#include <lamap_core/scan/scan_frame.h>
#include <lamap_core/training/hilbert_training.h>
#include <lamap_core/training/sampler.h>
#include <lamap_sim/scanner.h>
#include <lamap_sim/truth.h>
#include <support/pcd_points.h>
#include <support/temporary_folder.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

namespace
{
using namespace lamap;
using test::TemporaryFolder;

constexpr double kResolution_m = 0.1;
constexpr double kRangeMax_m = 8.0;
constexpr int kSkipped = 77;

struct Settings
{
  size_t scans = 12;
  int repetitions = 5;  ///< the least time of each scan counts
  int passes = 0;       ///< of scikit-learn over the training points; 0: until its loss has settled
  std::string python = "/usr/bin/python3";
};

struct LabelledPoint
{
  Eigen::Vector3d place_map;
  bool occupied = false;
};

/// What is known of places that a map has to judge.
struct Judgement
{
  std::optional<size_t> without;  ///< the scan that the map is not to know
  std::vector<LabelledPoint> points;
};

/// What all are given.
struct Task
{
  std::string name;
  std::vector<Scan> scans;
  std::string judge;  ///< what the maps are scored by
  std::vector<Judgement> judgements;
  size_t cells = 0;  ///< asked, of all scans together
};

/// The cells of one scan, in the map.
using Cells = std::vector<CellIndex>;

struct Times
{
  double train_s = std::numeric_limits<double>::infinity();
  double query_s = std::numeric_limits<double>::infinity();
};

/// One line of the table.
struct Entry
{
  std::string name;
  std::vector<Times> times;  ///< of each scan, the least of all repetitions
  double auc = 0;

  void keepLeast(size_t scan, double train_s, double query_s)
  {
    times[scan].train_s = std::min(times[scan].train_s, train_s);
    times[scan].query_s = std::min(times[scan].query_s, query_s);
  }
  [[nodiscard]] Times mean_ms() const
  {
    Times sum{0, 0};
    for (const Times& scan : times)
    {
      sum.train_s += 1e3 * scan.train_s / static_cast<double>(times.size());
      sum.query_s += 1e3 * scan.query_s / static_cast<double>(times.size());
    }
    return sum;
  }
};

double secondsOf(const std::function<void()>& work)
{
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

OverlappingOptions overlappingOptions(OverlappingPreset preset)
{
  OverlappingOptions options = presetOptions(preset);
  options.structure.resolution = kResolution_m;
  options.inference.maxRange = kRangeMax_m;
  return options;
}

/// The thesis's preset, its field all cells within the range: what scikit-learn is asked, too.
OverlappingOptions thesisInBox()
{
  OverlappingOptions options = overlappingOptions(OverlappingPreset::Thesis);
  options.inference.fieldNear = kRangeMax_m;
  return options;
}

/// A scan's rays and training points in its model's frame: the map's axes at the sensor.
struct ModelTask
{
  ModelPose pose;
  std::vector<ModelScan> scans;
  HilbertTrainingSet set;

  ModelTask(const Scan& scan, const OverlappingOptions& options)
  {
    const ModelShape shape(options.structure);
    const SelectedRays selected = selectRays(scan, options.inference.rangeLimits());
    pose = modelFrameOf(selected.scan, shape).value();
    scans.push_back(scanInModel(selected, nullptr, pose, shape));
    const HilbertFrame frame = HilbertFrame::ofModel(kResolution_m, shape.spacing_m, false);
    Sampler sampler;
    set.append(sampler.sample(scans.front().rays, options.inference.rules(), frame.cells, {}, 1), frame);
  }
};

/// The cells that a scan's model is asked for.
Cells cellsOf(const ModelTask& task, const HilbertModel& model)
{
  const auto reach = static_cast<int32_t>(kRangeMax_m / kResolution_m) + 2;
  Cells cells;
  for (int32_t z = -reach; z <= reach; ++z)
    for (int32_t y = -reach; y <= reach; ++y)
      for (int32_t x = -reach; x <= reach; ++x)
      {
        const Eigen::Vector3d place =
            task.pose.toModel(Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5) * kResolution_m);
        if (place.norm() > kRangeMax_m || !model.inBox(place, false)) continue;
        cells.push_back({x + task.pose.anchor.x, y + task.pose.anchor.y, z + task.pose.anchor.z});
      }
  return cells;
}

template <typename Number>
void writeNumbers(const std::string& path, const std::vector<Number>& numbers)
{
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(numbers.data()),
             static_cast<std::streamsize>(numbers.size() * sizeof(Number)));
  if (!file.flush()) throw std::runtime_error("cannot write " + path);
}

/// Puts a scan's training points and cells where the script finds them. @return the cells
Cells handOver(const Scan& scan, size_t number, const TemporaryFolder& folder)
{
  const OverlappingOptions options = thesisInBox();
  const ModelTask task(scan, options);
  const auto model =
      HilbertModelTrainer().train(task.scans, options.structure, options.inference, Workers(1));
  const Cells cells = cellsOf(task, *model);
  std::vector<double> points;
  for (const Eigen::Vector3d& point : task.set.points)
    points.insert(points.end(), point.data(), point.data() + 3);
  std::vector<double> places;
  for (const CellIndex& cell : cells)
  {
    const Eigen::Vector3d fromAnchor(cell.x - task.pose.anchor.x + 0.5, cell.y - task.pose.anchor.y + 0.5,
                                     cell.z - task.pose.anchor.z + 0.5);
    const Eigen::Vector3d place = task.pose.toModel(fromAnchor * kResolution_m);
    places.insert(places.end(), place.data(), place.data() + 3);
  }
  const std::string end = "_" + std::to_string(number) + ".f64";
  writeNumbers(folder / ("points" + end), points);
  writeNumbers(folder / ("labels" + end),
               std::vector<double>(task.set.labels.begin(), task.set.labels.end()));
  writeNumbers(folder / ("cells" + end), places);
  return cells;
}

std::vector<Scan> simulatedScans(const sim::World& world, size_t count)
{
  const sim::SensorModel sensor = sim::makeSensor("sector-laser");
  const sim::Scanner scanner(world, sensor, {}, 21);
  const auto poses = sim::makeTrajectory(world, sensor, sim::Motion::Stops, 12);
  std::vector<Scan> scans;
  for (size_t i = 0; i < std::min(count, poses.size()); ++i)
  {
    RayFan& fan = scans.emplace_back().fans.emplace_back();
    fan.centre = poses[i].position_map;
    const Eigen::Matrix3d rotation = sim::rotationOf(poses[i]);
    for (const sim::BeamReading& reading : scanner.scan(poses[i], i))
      fan.addReturn(fan.centre + rotation * reading.point_sensor);  // too far: no return
  }
  return scans;
}

Task simulatedTask(size_t scans)
{
  Task task;
  const sim::World world = sim::makeWorld("structured", 21);
  task.name = "lamap_sim's structured world";
  task.scans = simulatedScans(world, scans);
  task.judge = "the truth of all cells";
  task.judgements.resize(1);
  for (const sim::TrueCell& cell : sim::truthOf(world, {}))
    task.judgements[0].points.push_back({cellCentre(cell.index, kResolution_m), cell.occupied});
  return task;
}

Task recordedTask(const std::string& dataFolder, size_t scans)
{
  Task task;
  task.name = "sim_structured";
  task.scans =
      test::readStructuredScans(dataFolder, "sim_structured", static_cast<int>(std::min<size_t>(scans, 12)));
  task.judge = "hits and free cells of each scan, predicted by the map of all other scans";
  for (size_t i = 0; i < task.scans.size(); ++i)
  {
    const ModelTask model(task.scans[i], overlappingOptions(OverlappingPreset::Default));
    const Eigen::Isometry3d pose = model.pose.isometry(kResolution_m);
    Judgement judgement{i, {}};
    for (size_t k = 0; k < model.set.size(); ++k)
      judgement.points.push_back({pose * model.set.points[k], model.set.labels[k] > 0.5f});
    task.judgements.push_back(std::move(judgement));
  }
  return task;
}

/// Log-odds at a place, 0 where a map says nothing.
using LogoddsAt = std::function<double(const Eigen::Vector3d& place_map)>;

/// @param learn makes the map of all scans but one
double aucOf(const Task& task, const std::function<LogoddsAt(std::optional<size_t> without)>& learn)
{
  std::vector<PredictedCells> predictions;
  for (const Judgement& judgement : task.judgements)
  {
    const LogoddsAt logoddsAt = learn(judgement.without);
    for (const LabelledPoint& point : judgement.points)
      predictions.push_back(
          {logistic(logoddsAt(point.place_map)), point.occupied ? 1u : 0u, point.occupied ? 0u : 1u});
  }
  return areaUnderRoc(RankedPredictions(std::move(predictions))).value_or(0.5);
}

/// scikit-learn, as a script that is given the files of a folder.
class ScikitLearn
{
 public:
  ScikitLearn(std::string python, const TemporaryFolder& folder, int passes, size_t scans)
      : python_(std::move(python)),
        folder_(folder),
        arguments_("'" LAMAP_SCIKIT_LEARN_SCRIPT "' '" + folder.path() + "' " + std::to_string(passes)),
        entry_{"scikit-learn, m = 100", std::vector<Times>(scans)},
        passes_(scans)
  {
  }

  [[nodiscard]] bool isInstalled() const { return run("-c 'import sklearn' 2> /dev/null"); }

  void learnAll()
  {
    if (!run(arguments_)) throw std::runtime_error("the script of scikit-learn failed: see above");
    std::ifstream file(folder_ / "times.txt");
    for (size_t i = 0; i < entry_.times.size(); ++i)
    {
      double train_s = 0;
      double query_s = 0;
      if (!(file >> train_s >> query_s >> passes_[i])) throw std::runtime_error("its times are incomplete");
      entry_.keepLeast(i, train_s, query_s);
    }
  }

  /// Fused by eq. 3.1, which here is not timed. @param cells of each scan
  Entry scored(const Task& task, const std::vector<Cells>& cells)
  {
    LogoddsOfCells all;
    for (size_t i = 0; i < cells.size(); ++i) addAnswers(i, cells[i], all);
    entry_.auc =
        aucOf(task,
              [&](std::optional<size_t> without) -> LogoddsAt
              {
                LogoddsOfCells own;
                if (without) addAnswers(*without, cells[*without], own);
                return [&all, own](const Eigen::Vector3d& place)
                {
                  const auto key = keyOf(*cellAt(place, kResolution_m));
                  const auto sum = all.find(key);
                  const auto less = own.find(key);
                  return (sum == all.end() ? 0.0 : sum->second) - (less == own.end() ? 0.0 : less->second);
                };
              });
    return entry_;
  }
  /// Over the training points of a scan, on average.
  [[nodiscard]] double meanPasses() const
  {
    double sum = 0;
    for (const double passes : passes_) sum += passes / static_cast<double>(passes_.size());
    return sum;
  }

 private:
  using LogoddsOfCells = std::unordered_map<int64_t, double>;
  static int64_t keyOf(const CellIndex& cell)
  {
    constexpr int64_t kRow = 1 << 20;
    return (cell.z * kRow + cell.y) * kRow + cell.x;
  }
  void addAnswers(size_t scan, const Cells& cells, LogoddsOfCells& sums) const
  {
    std::ifstream file(folder_ / ("logodds_" + std::to_string(scan) + ".f64"), std::ios::binary);
    double logodds = 0;
    for (const CellIndex& cell : cells)
    {
      if (!file.read(reinterpret_cast<char*>(&logodds), sizeof(logodds)))
        throw std::runtime_error("its answers are incomplete");
      sums[keyOf(cell)] += logodds;
    }
  }
  [[nodiscard]] bool run(const std::string& arguments) const
  {
    return std::system(("'" + python_ + "' " + arguments).c_str()) == 0;
  }

  std::string python_;
  const TemporaryFolder& folder_;
  std::string arguments_;
  Entry entry_;
  std::vector<double> passes_;
};

/// An overlapping map: training by itself is timed apart, and the rest of an insertion is asking and fusing.
class Overlapping
{
 public:
  Overlapping(std::string name, const OverlappingOptions& options, size_t scans)
      : options_(options), entry_{std::move(name), std::vector<Times>(scans)}
  {
  }

  void learnAll(const Task& task)
  {
    const ModelShape shape(options_.structure);
    OverlappingHilbertMap map(options_.structure);
    HilbertModelTrainer trainer;
    for (size_t i = 0; i < task.scans.size(); ++i)
    {
      const ModelPose pose = ModelTask(task.scans[i], options_).pose;
      const double train_s = secondsOf(
          [&]
          {
            const SelectedRays rays = selectRays(task.scans[i], options_.inference.rangeLimits());
            const ModelScan scan = scanInModel(rays, nullptr, pose, shape);
            (void)trainer.train({scan}, options_.structure, options_.inference, Workers(1));
          });
      const double all_s = secondsOf([&] { map.insert(task.scans[i], options_.inference, nullptr, 1); });
      least_.resize(task.scans.size(), std::numeric_limits<double>::infinity());
      least_[i] = std::min(least_[i], all_s);
      entry_.times[i].train_s = std::min(entry_.times[i].train_s, train_s);
      entry_.times[i].query_s = std::max(0.0, least_[i] - entry_.times[i].train_s);
    }
  }

  Entry scored(const Task& task)
  {
    entry_.auc = aucOf(task,
                       [&](std::optional<size_t> without) -> LogoddsAt
                       {
                         OverlappingHilbertMap map(options_.structure);
                         for (size_t i = 0; i < task.scans.size(); ++i)
                           if (i != without) map.insert(task.scans[i], options_.inference);
                         return [map](const Eigen::Vector3d& place)
                         {
                           const auto cell = map.at(place, {});
                           return cell ? cell->evidence[0] : 0.0;
                         };
                       });
    return entry_;
  }

  /// In how many cells a map of each scan by itself has evidence.
  [[nodiscard]] size_t cellsOf(const Task& task) const
  {
    size_t cells = 0;
    for (const Scan& scan : task.scans)
    {
      OverlappingHilbertMap map(options_.structure);
      map.insert(scan, options_.inference);
      map.visitCells({}, [&](const CellIndex&, const CellEstimate&) { ++cells; });
    }
    return cells;
  }

 private:
  OverlappingOptions options_;
  Entry entry_;
  std::vector<double> least_;  ///< of a whole insertion
};

/// A map of one model: each scan is learned, then the box of its cells is asked.
class OneModel
{
 public:
  OneModel(std::string name, size_t scans) : entry_{std::move(name), std::vector<Times>(scans)}
  {
    structure_.resolution = kResolution_m;
    inference_.maxRange = kRangeMax_m;
  }

  void learnAll(const Task& task, const std::vector<Cells>& cells)
  {
    HilbertMap map(structure_);
    std::vector<ReachedLogodds> logodds;
    for (size_t i = 0; i < task.scans.size(); ++i)
    {
      CellIndex low = cells[i].front();
      CellIndex high = low;
      for (const CellIndex& cell : cells[i])
      {
        low = {std::min(low.x, cell.x), std::min(low.y, cell.y), std::min(low.z, cell.z)};
        high = {std::max(high.x, cell.x), std::max(high.y, cell.y), std::max(high.z, cell.z)};
      }
      const double train_s = secondsOf([&] { map.insert(task.scans[i], inference_, nullptr, 1); });
      const double query_s = secondsOf(
          [&] {
            map.logoddsOf(low, {high.x - low.x + 1, high.y - low.y + 1, high.z - low.z + 1}, logodds);
          });
      entry_.keepLeast(i, train_s, query_s);
    }
  }

  Entry scored(const Task& task)
  {
    entry_.auc = aucOf(task,
                       [&](std::optional<size_t> without) -> LogoddsAt
                       {
                         HilbertMap map(structure_);
                         for (size_t i = 0; i < task.scans.size(); ++i)
                           if (i != without) map.insert(task.scans[i], inference_);
                         return [map](const Eigen::Vector3d& place)
                         { return map.logoddsOf(*cellAt(place, kResolution_m)).value_or(0.0); };
                       });
    return entry_;
  }

 private:
  HilbertStructure structure_;
  HilbertInference inference_;
  Entry entry_;
};

void printTable(const Task& task, const std::vector<Entry>& entries)
{
  std::printf("\n%s: %zu scans, %zu cells per scan; ms per scan, one thread, shortest time of each scan;\n",
              task.name.c_str(), task.scans.size(), task.cells / task.scans.size());
  std::printf("area under the ROC curve by %s\n\n", task.judge.c_str());
  std::printf("%-52s %8s %8s %8s %14s %7s\n%78s %14s\n", "", "train", "query", "both", "speed-up", "AUC", "",
              "train    both");
  const Times peer = entries.front().mean_ms();
  for (const Entry& entry : entries)
  {
    const Times own = entry.mean_ms();
    std::printf("%-52s %8.2f %8.2f %8.2f %6.1f %7.1f %7.4f\n", entry.name.c_str(), own.train_s, own.query_s,
                own.train_s + own.query_s, peer.train_s / own.train_s,
                (peer.train_s + peer.query_s) / (own.train_s + own.query_s), entry.auc);
  }
}

int compare(Task task, const Settings& settings)
{
  const TemporaryFolder folder;
  const size_t scans = task.scans.size();
  ScikitLearn peer(settings.python, folder, settings.passes, scans);
  if (!peer.isInstalled())
  {
    std::printf("skipped: %s has no scikit-learn (Debian's package python3-sklearn)\n",
                settings.python.c_str());
    return kSkipped;
  }
  std::vector<Cells> cells;
  for (size_t i = 0; i < scans; ++i) cells.push_back(handOver(task.scans[i], i, folder));
  for (const Cells& ofScan : cells) task.cells += ofScan.size();

  Overlapping thesis("COverlappingHilbertMap, preset thesis, same cells", thesisInBox(), scans);
  Overlapping thesisInField("COverlappingHilbertMap, preset thesis, its own field",
                            overlappingOptions(OverlappingPreset::Thesis), scans);
  Overlapping overlapping("COverlappingHilbertMap, defaults", overlappingOptions(OverlappingPreset::Default),
                          scans);
  OneModel incremental("CHilbertMap, defaults", scans);
  for (int i = 0; i < settings.repetitions; ++i)
  {
    peer.learnAll();
    thesis.learnAll(task);
    thesisInField.learnAll(task);
    overlapping.learnAll(task);
    incremental.learnAll(task, cells);
  }
  printTable(task, {peer.scored(task, cells), thesis.scored(task), thesisInField.scored(task),
                    overlapping.scored(task), incremental.scored(task)});
  std::printf("\nscikit-learn passed over the training points %.1f times, the thesis's preset %d times\n",
              peer.meanPasses(), thesisInBox().inference.epochs);

  // Evidence that rounds to nothing, and cells at the edge of the range, may be told apart by a hair.
  const auto asked = static_cast<double>(task.cells);
  const auto answered = static_cast<double>(thesis.cellsOf(task));
  if (std::abs(answered - asked) <= 1e-3 * asked) return 0;
  std::printf("our map has evidence in %.0f cells where scikit-learn was asked for %.0f\n", answered, asked);
  return 1;
}

}  // namespace

int main(int argc, char** argv)
{
  CLI::App app("Compares Hilbert maps with scikit-learn");
  Settings settings;
  app.add_option("--scans", settings.scans, "how many")->check(CLI::Range(1, 12))->capture_default_str();
  app.add_option("--repetitions", settings.repetitions, "the least time counts")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--passes", settings.passes,
                 "of scikit-learn over the training points; 0: until its loss has settled")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--python", settings.python, "that has scikit-learn")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try
  {
    const auto data = test::dataFolder();
    return compare(data ? recordedTask(*data, settings.scans) : simulatedTask(settings.scans), settings);
  }
  catch (const std::exception& error)
  {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
