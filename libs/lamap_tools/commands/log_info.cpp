#include <lamap_mrpt/compat/mrpt_compat.h>
#include <lamap_mrpt/observations/observation_rays.h>
#include <lamap_tools/commands/build_notes.h>
#include <lamap_tools/commands/log_info.h>
#include <lamap_tools/files/file_names.h>
#include <lamap_tools/report/counted.h>
#include <lamap_tools/report/fact_line.h>
#include <mrpt/core/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <map>
#include <numeric>
#include <ostream>
#include <stdexcept>
#include <utility>

namespace lamap::tools
{
using Time = mrpt::Clock::time_point;

namespace
{
/// The look at several scans as if they were one.
void add(const ScanLook& look, ScanLook& sum)
{
  for (size_t i = 0; i < look.rays.size(); ++i) sum.rays[i] += look.rays[i];
  sum.notFinite += look.notFinite;
  const auto extend = [](std::optional<LengthSpan>& span, const std::optional<LengthSpan>& other)
  {
    if (span && other)
      span->include(*other);
    else if (other)
      span = other;
  };
  extend(sum.ranges, look.ranges);
  extend(sum.statedRanges, look.statedRanges);
  sum.beamWidth_rad = std::max(sum.beamWidth_rad, look.beamWidth_rad);
  sum.beamHeight_rad = std::max(sum.beamHeight_rad, look.beamHeight_rad);
}

/// Puts a log's facts together, item by item.
class LogReader
{
 public:
  void read(const ScanItem& item)
  {
    std::visit([this](const auto& scan) { read(scan); }, item);
  }

  void finish(LogInfo& info)
  {
    info.time = time_;
    info.build = tally_;
    for (auto& entry : sensors_) info.sensors.push_back(std::move(entry.second));
    if (!poses_.empty()) info.robotPath = pathThroughPoses();
  }

 private:
  struct StampedPosition
  {
    Time time;
    Eigen::Vector3d position_map;
  };

  void read(const ObservedScan& scan)
  {
    const std::string againstPose = reasonAgainstPose(scan);
    const std::string reason =
        readObservation(*scan.observation, againstPose.empty() ? scan.robotPose_map : mrpt::poses::CPose3D());
    count(shortClassName(*scan.observation), againstPose.empty() ? reason : againstPose, scan.place);
    if (!againstPose.empty()) return;
    const auto& pose = scan.robotPose_map;
    poses_.push_back({scan.observation->timestamp, {pose.x(), pose.y(), pose.z()}});
  }

  void read(const PointScan& scan)
  {
    SensorInfo& sensor = sensorOf(scan.kind, scan.kind);
    ++sensor.scans;
    if (scan.time)
    {
      include(*scan.time, sensor.time);
      include(*scan.time, time_);
    }
    else
      ++sensor.withoutTime;
    const bool isUsable = readRays(scan.scan, sensor);
    const std::string againstPose = reasonAgainstPose(scan);
    const std::string reason = isUsable ? "" : "it holds no point that can be used";
    count(scan.kind, againstPose.empty() ? reason : againstPose, scan.place);
    if (!againstPose.empty()) return;
    const Eigen::Vector3d origin = scan.scan.inMap(scan.scan.fans.at(0).centre);
    poses_.push_back({scan.time.value_or(INVALID_TIMESTAMP), origin});
  }

  void read(const LeftOutScan& scan)
  {
    tally_.leaveOut(scan.kind, scan.reason, scan.place);
    // Its readings are worth a look wherever they were made.
    if (scan.observation) (void)readObservation(*scan.observation, {});
  }

  SensorInfo& sensorOf(const std::string& name, const std::string& className)
  {
    SensorInfo& sensor = sensors_[{name, className}];
    sensor.name = name;
    sensor.className = className;
    return sensor;
  }

  /// @return why a map cannot use it; empty if it can
  std::string readObservation(const mrpt::obs::CObservation& observation,
                              const mrpt::poses::CPose3D& robotPose)
  {
    const std::string className = shortClassName(observation);
    SensorInfo& sensor = sensorOf(sensorNameOf(observation), className);
    ++sensor.scans;
    if (observation.timestamp == INVALID_TIMESTAMP)
      ++sensor.withoutTime;
    else
    {
      include(observation.timestamp, sensor.time);
      include(observation.timestamp, time_);
    }
    const double aperture_rad = statedApertureOf(observation);
    if (apertureNote("", "", aperture_rad)) sensor.illegalAperture_rad = aperture_rad;
    return reasonAgainst(observation, robotPose, sensor);
  }

  /// @return why a map cannot use it; empty if it can
  static std::string reasonAgainst(const mrpt::obs::CObservation& observation,
                                   const mrpt::poses::CPose3D& robotPose, SensorInfo& sensor)
  {
    sensor.hasRays = supportsObservation(observation);
    if (!sensor.hasRays) return "no map of this library takes this class";
    try
    {
      return readRays(*raysOf(observation, robotPose), sensor) ? "" : "it holds no ray that can be used";
    }
    catch (const std::exception& error)
    {
      if (sensor.unreadable++ == 0) sensor.whyUnreadable = compat::messageOf(error);
      return compat::messageOf(error);
    }
  }

  /// @return whether any of its rays says something
  static bool readRays(const Scan& scan, SensorInfo& sensor)
  {
    const ScanLook look = lookAt(scan);
    add(look, sensor.look);
    if (look.hasPhantomShell()) ++sensor.phantomShells;
    if (isWorthALook(sensor.scans - 1)) sensor.shells.add(look);
    const uint64_t returns = look.count(RayEnd::Return) + look.count(RayEnd::Cut);
    sensor.emptyScans.add(returns, look.count(RayEnd::NoReturn));
    return returns + look.count(RayEnd::NoReturn) > 0;
  }

  void count(const std::string& kind, const std::string& reason, const ScanPlace& place)
  {
    if (reason.empty())
      ++tally_.used[kind];
    else
      tally_.leaveOut(kind, reason, place);
  }

  static void include(Time time, std::optional<TimeSpan>& span)
  {
    if (span)
      span->include(time);
    else
      span = TimeSpan{time, time};
  }

  PathInfo pathThroughPoses()
  {
    // Observations need not be in the order of their times; where one has none, the log's order stands.
    if (std::all_of(poses_.begin(), poses_.end(),
                    [](const StampedPosition& pose) { return pose.time != INVALID_TIMESTAMP; }))
      std::stable_sort(poses_.begin(), poses_.end(),
                       [](const StampedPosition& a, const StampedPosition& b) { return a.time < b.time; });
    PathInfo path;
    const Eigen::Vector3d start = poses_.front().position_map;
    Eigen::Vector3d before = start;
    for (const auto& [time, position] : poses_)
    {
      path.length_m += (position - before).norm();
      path.farthestFromStart_m = std::max(path.farthestFromStart_m, (position - start).norm());
      path.box_m.extend(position);
      before = position;
    }
    return path;
  }

  std::map<std::pair<std::string, std::string>, SensorInfo> sensors_;
  std::optional<TimeSpan> time_;
  std::vector<StampedPosition> poses_;
  InsertionTally tally_;
};

uint64_t bytesOf(const std::string& path)
{
  namespace fs = std::filesystem;
  if (!fs::is_directory(path)) return fs::file_size(path);
  uint64_t bytes = 0;
  for (const auto& entry : fs::directory_iterator(path))
    if (!entry.is_directory() && endsWith(entry.path().string(), ".pcd")) bytes += entry.file_size();
  return bytes;
}

/// Names for people and for scripts, in the order of RayEnd.
struct EndName
{
  const char* text;
  const char* key;
};
constexpr std::array<EndName, 5> kEndNames{{{"returns", "return"},
                                            {"no return within the range", "noReturn"},
                                            {"cut", "cut"},
                                            {"dropped (nothing is known)", "dropped"},
                                            {"too near, or on the sensor", "tooNear"}}};

std::string dateText(Time time)
{
  const double seconds = mrpt::Clock::toDouble(time);
  const auto whole = static_cast<std::time_t>(std::floor(seconds));
  std::tm date{};
  gmtime_r(&whole, &date);
  std::array<char, 32> text{};
  if (std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M:%S", &date) == 0) return "";
  return std::string(text.data()) + " UTC, " + mrpt::format("%.6f", seconds);
}

double secondsBetween(Time first, Time last)
{
  return std::chrono::duration<double>(last - first).count();
}

std::string shareText(uint64_t part, uint64_t whole)
{
  return std::to_string(part) +
         mrpt::format(" (%.1f %%)", 100 * static_cast<double>(part) / static_cast<double>(whole));
}

double inDegrees(double angle_rad)
{
  return angle_rad * 180 / M_PI;
}

/// Intervals between scans per second; nothing for a single scan.
std::optional<double> rateOf(const SensorInfo& sensor)
{
  const size_t stamped = sensor.scans - sensor.withoutTime;
  if (stamped < 2 || sensor.time->seconds() <= 0) return std::nullopt;
  return static_cast<double>(stamped - 1) / sensor.time->seconds();
}

void printSensor(const SensorInfo& sensor, const LogInfo& info, std::ostream& out)
{
  printFact(out, "sensor " + sensor.name, sensor.className);
  std::string scans = std::to_string(sensor.scans);
  if (sensor.time)
    scans += mrpt::format(", %.3f s to %.3f s", secondsBetween(*info.firstTime, sensor.time->first),
                          secondsBetween(*info.firstTime, sensor.time->last));
  if (const auto rate = rateOf(sensor)) scans += mrpt::format(", %.2f per second", *rate);
  if (sensor.withoutTime > 0) scans += ", " + std::to_string(sensor.withoutTime) + " without a time stamp";
  printFact(out, "  scans", scans);
  if (!sensor.hasRays) printFact(out, "  rays", "none that a map of this library takes");
  if (sensor.unreadable > 0)
    printFact(out, "  not readable", std::to_string(sensor.unreadable) + ": " + sensor.whyUnreadable);
  const uint64_t rays = sensor.look.rayCount();
  if (rays == 0) return;
  printFact(out, "  rays", std::to_string(rays));
  for (size_t i = 0; i < kEndNames.size(); ++i)
    if (sensor.look.rays[i] > 0)
      printFact(out, std::string("    ") + kEndNames[i].text, shareText(sensor.look.rays[i], rays));
  if (sensor.look.notFinite > 0) printFact(out, "    not finite", shareText(sensor.look.notFinite, rays));
  if (sensor.emptyScans.empty > 0)
    printFact(out, "  scans without a return", shareText(sensor.emptyScans.empty, sensor.scans));
  if (sensor.emptyScans.nearlyEmpty > 0)
    printFact(out, "  scans with hardly a return", shareText(sensor.emptyScans.nearlyEmpty, sensor.scans));
  if (sensor.look.beamWidth_rad > 0 || sensor.look.beamHeight_rad > 0)
    printFact(out, "  opening angle of a beam",
              mrpt::format("%.2f x %.2f", inDegrees(sensor.look.beamWidth_rad),
                           inDegrees(sensor.look.beamHeight_rad)),
              "degrees");
  if (const auto& ranges = sensor.look.ranges)
    printFact(out, "  ranges of the returns",
              mrpt::format("%.2f .. %.2f", ranges->shortest_m, ranges->longest_m), "m");
  if (const auto& stated = sensor.look.statedRanges)
    printFact(out, "  range that the log states",
              mrpt::format("%.2f .. ", stated->shortest_m) +
                  (stated->longest_m > 0 ? mrpt::format("%.2f", stated->longest_m) : "unlimited"),
              "m");
}

void printPath(const PathInfo& path, std::ostream& out)
{
  printFact(
      out, "  path",
      mrpt::format("%.2f m long, at most %.2f m from its start", path.length_m, path.farthestFromStart_m));
  const Eigen::Vector3d& low = path.box_m.min();
  const Eigen::Vector3d& high = path.box_m.max();
  printFact(out, "  within",
            mrpt::format("x %.2f .. %.2f, y %.2f .. %.2f, z %.2f .. %.2f", low.x(), high.x(), low.y(),
                         high.y(), low.z(), high.z()),
            "m");
}

Json spanJson(const std::optional<LengthSpan>& span)
{
  if (!span) return nullptr;
  return {{"min", span->shortest_m}, {"max", span->longest_m}};
}

Json sensorJson(const SensorInfo& sensor, const LogInfo& info)
{
  Json json{{"name", sensor.name}, {"class", sensor.className}, {"scans", sensor.scans}};
  const auto sinceFirst = [&](Time time) { return secondsBetween(*info.firstTime, time); };
  json["first"] = sensor.time ? Json(sinceFirst(sensor.time->first)) : Json(nullptr);
  json["last"] = sensor.time ? Json(sinceFirst(sensor.time->last)) : Json(nullptr);
  json["perSecond"] = jsonOf(rateOf(sensor));
  json["withoutTime"] = sensor.withoutTime;
  json["hasRays"] = sensor.hasRays;
  json["unreadable"] = sensor.unreadable;
  json["rays"] = {{"total", sensor.look.rayCount()}};
  for (size_t i = 0; i < kEndNames.size(); ++i) json["rays"][kEndNames[i].key] = sensor.look.rays[i];
  json["rays"]["notFinite"] = sensor.look.notFinite;
  json["ranges"] = spanJson(sensor.look.ranges);
  json["statedRanges"] = spanJson(sensor.look.statedRanges);
  json["beam"] = {{"width_deg", inDegrees(sensor.look.beamWidth_rad)},
                  {"height_deg", inDegrees(sensor.look.beamHeight_rad)}};
  json["phantomShells"] = sensor.phantomShells;
  json["emptyScans"] = sensor.emptyScans.empty;
  json["nearlyEmptyScans"] = sensor.emptyScans.nearlyEmpty;
  return json;
}

Json pathJson(const PathInfo& path)
{
  const auto corner = [](const Eigen::Vector3d& p) { return Json{p.x(), p.y(), p.z()}; };
  return {{"length", path.length_m},
          {"farthestFromStart", path.farthestFromStart_m},
          {"min", corner(path.box_m.min())},
          {"max", corner(path.box_m.max())}};
}

std::vector<std::string> notesOn(const LogInfo& info)
{
  std::vector<std::string> notes;
  if (info.posesAreOdometry && info.robotPath && info.robotPath->length_m > 0)
    notes.push_back(odometryNote(info.path));
  for (const SensorInfo& sensor : info.sensors)
    if (const auto shell_m = sensor.shells.nearest_m())
      notes.push_back(phantomShellNote(info.path, sensor.name, *shell_m));
  for (const SensorInfo& sensor : info.sensors)
    if (const auto note = emptyScansNote(info.path, sensor.name, sensor.emptyScans, info.sensors.size() == 1))
      notes.push_back(*note);
  for (const SensorInfo& sensor : info.sensors)
    if (const auto note = apertureNote(info.path, sensor.name, sensor.illegalAperture_rad))
      notes.push_back(*note);
  return notes;
}

size_t observationsIn(const LogInfo& info)
{
  return std::accumulate(info.sensors.begin(), info.sensors.end(), size_t{0},
                         [](size_t sum, const SensorInfo& sensor) { return sum + sensor.scans; });
}
}  // namespace

void TimeSpan::include(Time time)
{
  first = std::min(first, time);
  last = std::max(last, time);
}

double TimeSpan::seconds() const
{
  return secondsBetween(first, last);
}

LogInfo readLogInfo(InputOptions options, const ProgressSink& progress)
{
  options.evenWithoutPoses = true;
  const auto sources = openInputs(options);
  LogReader reader;
  LogInfo info;
  info.stopped = !visitScans(sources, options.shouldStop, progress,
                             [&](const ScanItem& item, const ScanSource& /*source*/) { reader.read(item); });
  reader.finish(info);
  info.firstTime = sources.at(0)->contents().firstTime;
  info.path = options.paths.at(0);
  info.fileBytes = bytesOf(info.path);
  info.input = reportsOf(sources).at(0);
  info.poses = sources.at(0)->notes();
  info.readings = sources.at(0)->readingNotes();
  if (const auto& chooser = sources.at(0)->chooser()) info.choice = chooser->summary();
  info.posesAreOdometry = sources.at(0)->posesAreOdometry();
  info.notes = notesOn(info);
  return info;
}

void printLogInfo(const LogInfo& info, std::ostream& out)
{
  printFact(out, "file", info.path);
  printFact(out, "file size", std::to_string(info.fileBytes), "bytes");
  if (info.time)
  {
    printFact(out, "first time stamp", dateText(*info.firstTime), "s since 1970");
    printFact(out, "duration", mrpt::format("%.3f", info.time->seconds()), "s");
  }
  if (!info.choice.empty()) printFact(out, "choice", info.choice);
  for (const SensorInfo& sensor : info.sensors) printSensor(sensor, info, out);
  for (const std::string& text : info.readings) printFact(out, "readings", text);
  for (const std::string& text : info.poses) printFact(out, "poses", text);
  if (info.robotPath) printPath(*info.robotPath, out);
  printFact(out, "a build would use",
            std::to_string(info.build.usedCount()) + " of " + counted(observationsIn(info), "observation"));
  for (const auto& [kind, count] : info.build.used) out << "  used: " << count << " " << kind << "\n";
  printLeftOut(info.build, out);
  for (const std::string& note : info.notes) out << note << "\n";
}

Json logInfoJson(const LogInfo& info)
{
  Json json{{"file", info.path}, {"fileBytes", info.fileBytes}};
  json["firstTime"] = info.firstTime ? Json(mrpt::Clock::toDouble(*info.firstTime)) : Json(nullptr);
  json["duration"] = info.time ? Json(info.time->seconds()) : Json(nullptr);
  json["choice"] = info.choice;
  json["sensors"] = Json::array();
  for (const SensorInfo& sensor : info.sensors) json["sensors"].push_back(sensorJson(sensor, info));
  json["readings"] = info.readings;
  json["poses"] = {{"notes", info.poses}, {"odometry", info.posesAreOdometry}};
  json["poses"]["path"] = info.robotPath ? pathJson(*info.robotPath) : Json(nullptr);
  json["build"] = {{"scans", info.build.usedCount()}, {"used", info.build.used}};
  json["build"]["left_out"] = leftOutJson(info.build);
  json["notes"] = info.notes;
  json["damages"] = info.input.damages;
  return json;
}

}  // namespace lamap::tools
