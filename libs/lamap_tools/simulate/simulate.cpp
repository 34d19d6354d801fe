#include <lamap_tools/simulate/simulate.h>

#include <lamap_core/options/nearest_name.h>
#include <lamap_mrpt/compat/mrpt_compat.h>
#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <lamap_sim/surface_truth.h>
#include <lamap_sim/truth.h>
#include <lamap_tools/config/map_setup.h>
#include <lamap_tools/files/file_names.h>
#include <lamap_tools/files/file_output.h>
#include <lamap_tools/files/output_paths.h>
#include <lamap_tools/files/text_fields.h>
#include <lamap_tools/files/usage_error.h>
#include <lamap_tools/inputs/pose_track.h>
#include <lamap_tools/report/counted.h>
#include <lamap_tools/simulate/simulated_log.h>
#include <lamap_tools/simulate/simulated_truth.h>
#include <mrpt/core/format.h>
#include <mrpt/rtti/CObject.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <set>
#include <stdexcept>

namespace lamap::tools
{
namespace
{
using sim::Motion;
using sim::Pose;
using sim::SensorKind;
using sim::SensorModel;
using sim::World;

constexpr double kDegree = 3.14159265358979323846 / 180;

void requireKnown(const std::string& what, const std::string& name, const std::vector<std::string>& known)
{
  if (std::find(known.begin(), known.end(), name) != known.end()) return;
  const auto meant = meantBy(name, known);
  throw UsageError(what + " '" + name + "' is not known; " +
                   (meant ? "did you mean " + *meant + "? There are: " : "there are: ") + joined(known));
}

/// What a world is seen with where nothing else is said.
struct Default
{
  const char* world;
  const char* sensor;
  int scans;
  double rangeMax_m;  ///< 0: the sensor's own
};
constexpr Default kDefaults[] = {
    {"structured", "sector-laser", 12, 0}, {"unstructured", "sector-laser", 12, 0},
    {"corridor", "pan-tilt-laser", 66, 0}, {"pier", "sonar", 12, 0},
    {"station", "sector-laser", 60, 0},    {"flatland", "planar-laser", 20, 6},
    {"poles", "sector-laser", 12, 0}};

const Default& defaultOf(const std::string& world)
{
  return *std::find_if(std::begin(kDefaults), std::end(kDefaults),
                       [&](const Default& entry) { return entry.world == world; });
}

SensorModel sensorFor(const SimulateOptions& options, const World& world)
{
  const Default& usual = defaultOf(options.world);
  const std::string name = options.sensor.empty() ? usual.sensor : options.sensor;
  requireKnown("--sensor", name, sim::sensorNames());
  SensorModel sensor = sim::makeSensor(name);
  if (world.flat && sensor.kind != SensorKind::Planar)
    throw UsageError("--sensor " + name + ": " + world.name +
                     " is two-dimensional, it takes a planar-laser only");
  if (name == usual.sensor && usual.rangeMax_m > 0) sensor.rangeMax_m = usual.rangeMax_m;
  if (options.rangeMax_m) sensor.rangeMax_m = *options.rangeMax_m;
  return sensor;
}

int scansFor(const SimulateOptions& options, const SensorModel& sensor)
{
  if (options.scans) return *options.scans;
  const Default& usual = defaultOf(options.world);
  return sensor.name == usual.sensor ? usual.scans : sensor.defaultScans;
}

Motion motionFor(const SimulateOptions& options, const SensorModel& sensor)
{
  if (options.trajectory == "stops") return Motion::Stops;
  if (options.trajectory == "driving") return Motion::Driving;
  const bool quick = sensor.kind == SensorKind::Planar || sensor.name == "lidar16";
  return quick ? Motion::Driving : Motion::Stops;
}

/// @throws UsageError, before any work, if the log would be hopelessly large
void requireLogOfSensibleSize(const SimulateOptions& options, const SensorModel& sensor, double scans)
{
  constexpr double kMostShots = 1e7;  // each has a pose that is kept
  constexpr double kMostRays = 1e10;  // some 100 GB
  constexpr double kMostRaysInMemory = 1e9;
  const double shots = scans * sensor.pingsPerScan;
  const double rays =
      sensor.kind == SensorKind::Sonar ? shots : scans * static_cast<double>(sensor.beams.size());
  const std::string asked = options.scans ? "--scans " + std::to_string(*options.scans)
                                          : counted(static_cast<size_t>(scans), "scan");
  const bool inMemory = endsWith(options.outPath, ".simplemap");
  const double mostRays = inMemory ? kMostRaysInMemory : kMostRays;
  if (shots <= kMostShots && rays <= mostRays) return;
  const double bytesPerRay = sensor.kind == SensorKind::Sonar    ? 850  // of a ping
                             : sensor.kind == SensorKind::Planar ? 6
                                                                 : 12;
  throw UsageError(mrpt::format(
      "%s: %.3g rays of a %s, some %.3g GB of log; a %s has at most %.0e %s and %.0e rays%s", asked.c_str(),
      rays, sensor.name.c_str(), rays * bytesPerRay * 1e-9, inMemory ? ".simplemap" : ".rawlog", kMostShots,
      sensor.kind == SensorKind::Sonar ? "pings" : "scans", mostRays,
      inMemory ? ", because it is held in memory" : ""));
}

/// "x,y,z" or "x,y,z,yaw".
Pose poseFromText(const std::string& text)
{
  std::vector<double> numbers;
  bool legal = true;
  for (const std::string_view field : fieldsBetween(text, ","))
  {
    const auto number = numberIn<double>(field);
    legal = legal && number && std::isfinite(*number);
    numbers.push_back(number.value_or(0));
  }
  if (!legal || numbers.size() < 3 || numbers.size() > 4)
    throw UsageError("--at " + text +
                     ": expected x,y,z or x,y,z,yaw in metres and degrees, e.g. 2,1.5,0.5,90");
  Pose pose;
  pose.position_map = {numbers[0], numbers[1], numbers[2]};
  if (numbers.size() == 4) pose.yaw_rad = numbers[3] * kDegree;
  return pose;
}

Pose poseOf(const mrpt::poses::CPose3D& given)
{
  Pose pose;
  pose.position_map = {given.x(), given.y(), given.z()};
  pose.yaw_rad = given.yaw();
  pose.pitch_rad = given.pitch();
  pose.roll_rad = given.roll();
  return pose;
}

/// One pose a shot from one pose a scan.
std::vector<Pose> repeatedForPings(const std::vector<Pose>& poses, const SensorModel& sensor)
{
  std::vector<Pose> shots;
  for (const Pose& pose : poses) shots.insert(shots.end(), static_cast<size_t>(sensor.pingsPerScan), pose);
  return shots;
}

std::vector<TimedPose> trackOf(const std::string& trajectory)
{
  if (!std::filesystem::exists(trajectory))
    throw UsageError("--trajectory " + trajectory +
                     ": is neither stops nor driving, and there is no such file of poses (TUM format)");
  return readPoseFile(trajectory);
}

std::vector<Pose> posesFromFile(const SimulateOptions& options, const SensorModel& sensor)
{
  std::vector<Pose> poses;
  for (const TimedPose& timed : trackOf(options.trajectory))
  {
    poses.push_back(poseOf(timed.pose_map));
    const bool level = std::abs(poses.back().pitch_rad) < 1e-6 && std::abs(poses.back().roll_rad) < 1e-6;
    if (sensor.kind == SensorKind::Planar && !level)
      throw std::runtime_error(options.trajectory + ": pose " + std::to_string(poses.size()) +
                               " is inclined; a " + sensor.name + " goes level");
  }
  if (options.scans)
  {
    const auto count = static_cast<size_t>(*options.scans);
    if (count > poses.size())
      throw UsageError("--scans " + std::to_string(count) + ": " + options.trajectory + " has only " +
                       counted(poses.size(), "pose"));
    poses.resize(count);
  }
  requireLogOfSensibleSize(options, sensor, static_cast<double>(poses.size()));
  return poses;
}

bool isMotionName(const std::string& trajectory)
{
  return trajectory.empty() || trajectory == "stops" || trajectory == "driving";
}

/// The true poses of the sensor, one a shot.
std::vector<Pose> shotsFor(const SimulateOptions& options, const World& world, const SensorModel& sensor)
{
  if (isMotionName(options.trajectory)) requireLogOfSensibleSize(options, sensor, scansFor(options, sensor));
  if (!options.standAt.empty())
  {
    if (!options.trajectory.empty()) throw UsageError("--at and --trajectory: name one of them");
    const auto scans = static_cast<size_t>(scansFor(options, sensor));
    return repeatedForPings(std::vector<Pose>(scans, poseFromText(options.standAt)), sensor);
  }
  if (!isMotionName(options.trajectory)) return repeatedForPings(posesFromFile(options, sensor), sensor);
  return sim::makeTrajectory(world, sensor, motionFor(options, sensor), scansFor(options, sensor));
}

/// @throws UsageError or, for a file's poses, std::runtime_error naming the pose
void requireOpenWay(const SimulateOptions& options, const sim::Scanner& scanner, const SensorModel& sensor,
                    const std::vector<Pose>& shots)
{
  for (size_t i = 0; i < shots.size(); i += static_cast<size_t>(sensor.pingsPerScan))
  {
    try
    {
      scanner.requireOpen(shots[i].position_map);
    }
    catch (const std::invalid_argument& error)
    {
      const std::string number = std::to_string(i / static_cast<size_t>(sensor.pingsPerScan) + 1);
      if (!options.standAt.empty()) throw UsageError("--at " + options.standAt + ": " + error.what());
      if (!isMotionName(options.trajectory))
        throw std::runtime_error(options.trajectory + ": pose " + number + ": " + error.what());
      throw std::runtime_error("seed " + std::to_string(options.seed) + ", scan " + number + ": " +
                               error.what() + "; take another seed");
    }
  }
}

int truthDepthInCells(const SimulateOptions& options)
{
  constexpr int kUsual = 1;
  if (!options.truthDepth_m) return kUsual;
  constexpr double kMost = 1000;
  const double cells = std::ceil(*options.truthDepth_m / options.resolution_m - 1e-6);
  if (!(cells >= 1 && cells <= kMost))
    throw UsageError(mrpt::format("--truth-depth %g: must be above 0 and at most %g m (1,000 cells)",
                                  *options.truthDepth_m, kMost * options.resolution_m));
  return static_cast<int>(cells);
}

/// Beyond these a unit is mistaken.
constexpr double kMostNoise_m = 100;
constexpr double kMostNoise_deg = 180;
constexpr double kMostOdometryNoise = 10;

void requireLegalNoise(const SimulateOptions& options)
{
  const sim::NoiseOptions& noise = options.noise;
  const auto require = [](const char* flag, double number, double most, const char* unit)
  {
    // By its negation: NaN is refused.
    if (!(number >= 0 && number <= most))
      throw UsageError(mrpt::format("%s: %g%s: must be from 0 to %g%s", flag, number, unit, most, unit));
  };
  require("--range-noise", noise.range_m, kMostNoise_m, " m");
  require("--angle-noise", noise.angle_rad / kDegree, kMostNoise_deg, " deg");
  require("--point-noise", noise.point_m, kMostNoise_m, " m");
  require("--missing", noise.missing, 1, "");
  require("--odometry-noise", options.odometryNoise, kMostOdometryNoise, "");
  require("--pose-noise", noise.position_m, kMostNoise_m, " m");
  require("--pose-noise", noise.turn_rad / kDegree, kMostNoise_deg, " deg");
}

void requireLegal(const SimulateOptions& options)
{
  requireKnown("world", options.world, sim::worldNames());
  if (!endsWith(options.outPath, ".rawlog") && !endsWith(options.outPath, ".simplemap"))
    throw UsageError("-o " + options.outPath + ": the name must end in .rawlog or .simplemap");
  for (const std::string& path : options.truthPaths)
    if (!endsWith(path, ".csv") && !endsWith(path, ".bt"))
      throw UsageError("--truth " + path + ": the name must end in .csv or .bt");
  requireKnown("--truth-of", options.truthOf, {"solids", "surfaces"});
  requireKnown("--missing-as", options.missingAs, missingAsNames());
  if (options.truthOf == "surfaces" && options.truthDepth_m)
    throw UsageError("--truth-depth: is for --truth-of solids; surfaces have no depth");
  if (!options.surfacePath.empty() && !endsWith(options.surfacePath, ".csv"))
    throw UsageError("--surface " + options.surfacePath + ": the name must end in .csv");
  if (options.scans && *options.scans < 1)
    throw UsageError("--scans " + std::to_string(*options.scans) + ": must be 1 or more");
  if (!(options.resolution_m > 0) || !std::isfinite(options.resolution_m))
    throw UsageError("--resolution " + shortest(options.resolution_m) + ": must be finite and above 0, in m");
  if (options.odometryNoise > 0 && endsWith(options.outPath, ".simplemap"))
    throw UsageError("--odometry-noise: a .simplemap has no odometry; give --pose-noise, or a .rawlog");
  (void)truthDepthInCells(options);
  requireLegalNoise(options);
}

/// The paths of what comes beside a log.
std::string besideLog(const std::string& outPath, const std::string& extension)
{
  return outPath.substr(0, outPath.rfind('.')) + extension;
}

void writePoses(const std::vector<Pose>& shots, const SensorModel& sensor, FileOutput& file)
{
  file.append("# true poses of the robot: time x y z qx qy qz qw\n");
  for (size_t i = 0; i < shots.size(); ++i)
  {
    const Pose pose = robotPose(sensor, shots[i]);
    const sim::Quaternion q = sim::quaternionOf(pose);
    const Eigen::Vector3d& p = pose.position_map;
    file.append(timeOfShot(sensor, i));
    for (const double number : {p.x(), p.y(), p.z(), q.x, q.y, q.z, q.w})
    {
      file.append(" ");
      file.append(number);
    }
    file.append("\n");
  }
}

/// Keys of a map that `lamap build` makes of the log.
struct MapSections
{
  std::string alias;
  std::string rangeKey;
  bool planar = false;  ///< whether it has creationOpts.planar
};

/// octoMap and every map of this library.
std::vector<MapSections> mapsForConfig()
{
  std::vector<MapSections> maps;
  std::set<std::string> seen;
  for (const std::string& name : registeredMapNames())
  {
    if (!isLearnedMap(name)) continue;
    const auto map = std::dynamic_pointer_cast<CLearnedMap>(createMap(readMapDefinition({name, "", {}})));
    if (!seen.insert(map->alias()).second) continue;
    MapSections sections{map->alias(), "maxRange", false};
    for (const OptionValue& option : map->optionValues())
      sections.planar = sections.planar || (option.section == "creationOpts" && option.key == "planar");
    maps.push_back(sections);
  }
  maps.push_back({"octoMap", "maxrange", false});
  return maps;
}

void writeConfig(const SimulateOptions& options, const World& world, const SensorModel& sensor,
                 FileOutput& file)
{
  const std::vector<MapSections> maps = mapsForConfig();
  const std::string resolution = shortest(options.resolution_m);
  const std::string range = shortest(sensor.rangeMax_m);
  file.append("# Maps of a simulated log: world " + world.name + ", seed " + std::to_string(options.seed) +
              ", " + sensor.name + ". Choose one with -m:\n#\n#   lamap build -i LOG -c THIS -m " +
              maps.front().alias + " -o MAP.lamap.gz\n\n[map]\n");
  for (const MapSections& map : maps) file.append(map.alias + "_count = 1\n");
  for (const MapSections& map : maps)
  {
    file.append("\n[map_" + map.alias + "_00_creationOpts]\nresolution = " + resolution + "\n");
    if (world.flat && map.planar) file.append("planar = true\nplanarHeight = 0\n");
    file.append("[map_" + map.alias + "_00_insertOpts]\n" + map.rangeKey + " = " + range + "\n");
  }
}

/// Everything that is to be written, from the check of its place to the end.
class Simulation
{
 public:
  explicit Simulation(const SimulateOptions& options)
      : options_(options),
        world_(sim::makeWorld(options.world, options.seed)),
        sensor_(sensorFor(options, world_)),
        scanner_(world_, sensor_, options.noise, options.seed),
        shots_(shotsFor(options, world_, sensor_))
  {
    requireOpenWay(options_, scanner_, sensor_, shots_);
    report_.sensor = sensor_.name;
    report_.rangeMax_m = sensor_.rangeMax_m;
    report_.scans = shots_.size() / static_cast<size_t>(sensor_.pingsPerScan);
  }

  SimulateReport run(const ProgressSink& progress)
  {
    openFiles();
    report_.stopped = !writeLog(progress) || !writeTruth(progress) || !writeSurface();
    if (report_.stopped)
    {
      report_.files.clear();
      return report_;
    }
    writePoses(shots_, sensor_, file(besideLog(options_.outPath, ".tum")));
    writeConfig(options_, world_, sensor_, file(besideLog(options_.outPath, ".ini")));
    commit();
    return report_;
  }

 private:
  FileOutput& file(const std::string& path)
  {
    const auto at = std::find(report_.files.begin(), report_.files.end(), path);
    return *files_[static_cast<size_t>(at - report_.files.begin())];
  }

  /// Before any work: whether all places can be written.
  void openFiles()
  {
    report_.files = {options_.outPath, besideLog(options_.outPath, ".tum"),
                     besideLog(options_.outPath, ".ini")};
    report_.files.insert(report_.files.end(), options_.truthPaths.begin(), options_.truthPaths.end());
    if (!options_.surfacePath.empty()) report_.files.push_back(options_.surfacePath);
    requireOwnPlaces(report_.files,
                     {isMotionName(options_.trajectory) ? std::string() : options_.trajectory});
    for (const std::string& path : report_.files) files_.push_back(std::make_unique<FileOutput>(path));
  }

  bool writeLog(const ProgressSink& progress)
  {
    const LogOptions logOptions{sensor_, options_.noise, options_.odometryNoise, options_.seed,
                                missingAs(options_.missingAs)};
    FileOutput& out = file(options_.outPath);
    const auto log =
        endsWith(options_.outPath, ".rawlog") ? makeRawlog(out, logOptions) : makeSimplemap(out, logOptions);
    const auto pings = static_cast<size_t>(sensor_.pingsPerScan);
    Progress state;
    state.expected = report_.scans;
    state.input = options_.outPath;
    for (size_t shot = 0; shot < shots_.size(); ++shot)
    {
      if (options_.shouldStop()) return false;
      take(shot, *log);
      if ((shot + 1) % pings != 0) continue;
      ++state.done;
      if (progress) progress(state);
    }
    log->finish();
    return true;
  }

  void take(size_t shot, SimulatedLog& log)
  {
    const Pose& pose = shots_[shot];
    // One error of the pose for all pings of a sweep.
    const Pose reported = scanner_.reportedPose(pose, shot / static_cast<size_t>(sensor_.pingsPerScan));
    if (sensor_.kind == SensorKind::Sonar)
    {
      const sim::HeadTurn head = sim::headTurn(sensor_, static_cast<int>(shot));
      const auto echoes = scanner_.ping(pose, head, shot);
      const auto lost = static_cast<size_t>(
          std::count_if(echoes.begin(), echoes.end(), [](const sim::Echo& echo) { return echo.lost; }));
      report_.returns += echoes.size() - lost;
      report_.lost += lost;
      report_.noReturns += echoes.size() == lost ? 1 : 0;
      log.addPing(reported, head, echoes);
      return;
    }
    const auto readings = scanner_.scan(pose, shot);
    for (const sim::BeamReading& reading : readings)
    {
      ++(reading.range_m ? report_.returns : report_.noReturns);
      report_.lost += reading.lost_m ? 1 : 0;
    }
    log.addScan(reported, readings);
  }

  bool writeTruth(const ProgressSink& progress)
  {
    if (options_.truthPaths.empty()) return true;
    truth_ =
        options_.truthOf == "surfaces"
            ? sim::surfaceTruthOf(world_, sensor_, shots_, options_.resolution_m, options_.shouldStop)
            : sim::truthOf(world_, {options_.resolution_m, truthDepthInCells(options_)}, options_.shouldStop);
    if (options_.shouldStop()) return false;
    for (const sim::TrueCell& cell : truth_) ++(cell.occupied ? report_.occupiedCells : report_.freeCells);
    Progress state;
    state.expected = truth_.size();
    for (const std::string& path : options_.truthPaths)
    {
      if (!endsWith(path, ".csv")) continue;
      state.input = path;
      const auto goOn = [&](size_t written)
      {
        state.done = written;
        if (progress) progress(state);
        return !options_.shouldStop();
      };
      if (!writeTruthCsv(truth_, options_.resolution_m, file(path), goOn)) return false;
    }
    return true;
  }

  bool writeSurface()
  {
    if (options_.surfacePath.empty()) return true;
    const auto points = sim::surfacePointsOf(world_, options_.resolution_m, options_.shouldStop);
    if (options_.shouldStop()) return false;
    report_.surfacePoints = points.size();
    writePointsCsv(points, file(options_.surfacePath));
    return true;
  }

  void commit()
  {
    std::vector<FileOutput*> all;
    for (const std::string& path : report_.files)
    {
      if (endsWith(path, ".bt")) writeTruthOctree(truth_, options_.resolution_m, path, file(path));
      all.push_back(&file(path));
    }
    FileOutput::commitAll(all);
  }

  SimulateOptions options_;
  World world_;
  SensorModel sensor_;
  sim::Scanner scanner_;
  std::vector<Pose> shots_;
  SimulateReport report_;
  std::vector<std::unique_ptr<FileOutput>> files_;  ///< of report_.files
  std::vector<sim::TrueCell> truth_;
};
}  // namespace

namespace
{
/// The library's message with the flag in the place of what it calls the option.
std::string asFlagsSay(const std::string& message)
{
  constexpr std::pair<std::string_view, const char*> kFlags[] = {
      {"maximum range [m]", "--max-range"}, {"missing", "--missing"},
      {"longest burst", "--missing-burst"}, {"point noise", "--point-noise"},
      {"resolution", "--resolution"},       {"scans", "--scans"}};
  for (const auto& [name, flag] : kFlags)
    if (message.rfind(name, 0) == 0) return flag + message.substr(name.size());
  return message;
}
}  // namespace

SimulateReport simulate(const SimulateOptions& options, const ProgressSink& progress)
{
  requireLegal(options);
  try
  {
    return Simulation(options).run(progress);
  }
  catch (const std::invalid_argument& error)
  {
    throw UsageError(asFlagsSay(error.what()));
  }
}

void printReport(const SimulateReport& report, const SimulateOptions& options, std::ostream& out)
{
  out << options.world << ", seed " << options.seed << ": " << counted(report.scans, "scan") << " of a "
      << report.sensor << " up to " << shortest(report.rangeMax_m) << " m, "
      << counted(report.returns, "return") << ", " << report.noReturns << " without";
  if (report.lost > 0) out << "; " << report.lost << " got lost";
  out << "\n";
  if (!options.truthPaths.empty())
    out << "truth of " << options.truthOf << ": " << report.freeCells << " free and "
        << counted(report.occupiedCells, "occupied cell") << " of " << shortest(options.resolution_m)
        << " m\n";
  if (!options.surfacePath.empty()) out << "surface: " << counted(report.surfacePoints, "point") << "\n";
  for (const std::string& path : report.files) out << "  " << path << "\n";
}

}  // namespace lamap::tools
