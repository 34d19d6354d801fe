#include <lamap_core/scan/beam_cone.h>
#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <lamap_mrpt/observations/observation_rays.h>
#include <lamap_tools/commands/build_notes.h>
#include <lamap_tools/files/text_fields.h>
#include <lamap_tools/inputs/scan_look.h>
#include <lamap_tools/report/counted.h>
#include <lamap_tools/scores/held_out_cells.h>
#include <mrpt/core/format.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/maps/COctoMap.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

namespace lamap::tools
{
using mrpt::maps::CMetricMap;

namespace
{
/// Edge of a cell [m]; nothing for a map without cells.
std::optional<double> resolutionOf(const CMetricMap& map)
{
  if (const auto* learned = dynamic_cast<const CLearnedMap*>(&map)) return learned->resolution();
  if (const auto* octo = dynamic_cast<const mrpt::maps::COctoMap*>(&map)) return octo->getResolution();
  if (const auto* grid = dynamic_cast<const mrpt::maps::COccupancyGridMap2D*>(&map))
    return grid->getResolution();
  return std::nullopt;
}

std::vector<Eigen::Vector3d> returnsOf(const Scan& scan)
{
  std::vector<Eigen::Vector3d> points_map;
  for (const RayFan& fan : scan.fans)
    for (const Ray& ray : fan.rays)
      if (ray.meaning == RayEnd::Return && ray.end.allFinite()) points_map.push_back(scan.inMap(ray.end));
  return points_map;
}

/// Whether a twentieth of at least 100 returns lie at a range, as far as its rounding tells.
bool areManyAt(double range_m, const Scan& scan)
{
  constexpr double kRounding = 1e-5;
  constexpr size_t kFewestReturns = 100;
  constexpr size_t kTwentieth = 20;
  size_t returns = 0;
  size_t alike = 0;
  for (const RayFan& fan : scan.fans)
    for (const Ray& ray : fan.rays)
    {
      if (ray.meaning != RayEnd::Return || !ray.end.allFinite()) continue;
      ++returns;
      if (std::abs((ray.end - fan.centre).norm() - range_m) <= kRounding * range_m) ++alike;
    }
  return returns >= kFewestReturns && alike * kTwentieth >= returns;
}

/// Between the lowest and the highest twentieth of some points.
double heightOf(const std::vector<Eigen::Vector3d>& points)
{
  std::vector<double> z;
  for (const Eigen::Vector3d& point : points) z.push_back(point.z());
  std::sort(z.begin(), z.end());
  const size_t outliers = z.size() / 20;
  return z[z.size() - 1 - outliers] - z[outliers];
}

/// Whether more than half of a good number of points are in fewer than ten cells.
bool areCrowded(const std::vector<Eigen::Vector3d>& points, double resolution_m)
{
  constexpr size_t kFewestPoints = 100;
  constexpr size_t kCells = 9;
  if (points.size() < kFewestPoints) return false;
  std::map<std::array<double, 3>, size_t> countOf;
  for (const Eigen::Vector3d& point : points)
  {
    const Eigen::Vector3d cell = (point / resolution_m).array().floor();
    ++countOf[{cell.x(), cell.y(), cell.z()}];
  }
  std::vector<size_t> counts;
  for (const auto& entry : countOf) counts.push_back(entry.second);
  std::sort(counts.begin(), counts.end(), std::greater<>());
  size_t inFullest = 0;
  for (size_t i = 0; i < std::min(kCells, counts.size()); ++i) inFullest += counts[i];
  return 2 * inFullest > points.size();
}

/// What became of the rays that were inserted; nothing for a map that does not count them.
RayCounts rayCountsOf(const CMetricMap& map)
{
  const auto* learned = dynamic_cast<const CLearnedMap*>(&map);
  return learned != nullptr ? learned->rayCounts() : RayCounts();
}

/// A length of one digit that is not longer.
double roundedDown(double length_m)
{
  const double digit = std::pow(10, std::floor(std::log10(length_m)));
  return std::floor(length_m / digit * (1 + 1e-9)) * digit;
}
}  // namespace

std::string odometryNote(const std::string& path)
{
  return path +
         ": its poses are the log's odometry, which drifts unless it was corrected: what is seen again may "
         "appear twice in the map. Better "
         "poses: build from the .simplemap that icp-slam or rbpf-slam makes of this log, or give a "
         "trajectory with --poses, e.g. MOLA's (TUM format) or icp-slam's log_estimated_path.txt";
}

std::string phantomShellNote(const std::string& path, const std::string& sensor, double range_m)
{
  return path + ": " + sensor +
         mrpt::format(
             ": many returns of a scan lie at the same longest range, %.2f m, and neither "
             "the log nor the map has a limit below it. If the sensor writes so what it does not "
             "see, they make a phantom shell; below it, insertOpts.maxRange leaves only "
             "free space there: -s insertOpts.maxRange=%.3g",
             range_m, 0.99 * range_m);
}

std::optional<std::string> emptyScansNote(const std::string& path, const std::string& sensor,
                                          const EmptyScans& scans, bool isAlone)
{
  if (scans.empty + scans.nearlyEmpty == 0) return std::nullopt;
  std::vector<std::string> kinds;
  const std::string all = " of " + counted(scans.scans, "scan");
  if (scans.empty > 0) kinds.push_back(std::to_string(scans.empty) + all + " without a single return");
  if (scans.nearlyEmpty > 0)
    kinds.push_back(std::to_string(scans.nearlyEmpty) + all +
                    " with hardly one (for at most every tenth ray)");
  return path + ": " + sensor + ": free space comes from " + joined(kinds, " and ") +
         ". If the sensor was blinded or dead, leave them out: "
         "-s insertOpts.considerInvalidRangesAsFreeSpace=false" +
         (isAlone ? "" : ", or --sensors without it");
}

std::optional<std::string> apertureNote(const std::string& path, const std::string& sensor,
                                        double aperture_rad)
{
  if (aperture_rad == 0 || halfApertureOf(aperture_rad) > 0) return std::nullopt;
  return path + ": " + sensor +
         mrpt::format(
             ": the opening angle of its beams is stated as %.4g degrees; it must be at least 0 and less "
             "than "
             "180 degrees. The beams are taken for lines",
             aperture_rad * 180 / M_PI);
}

BuildNotes::Log& BuildNotes::logOf(const ScanSource& source)
{
  if (logs_.empty() || logs_.back().source != &source) logs_.push_back({&source});
  return logs_.back();
}

void BuildNotes::look(const ScanItem& item, const ScanSource& source)
{
  lookedAt_ = nullptr;
  if (std::holds_alternative<LeftOutScan>(item)) return;
  Log& log = logOf(source);
  std::string name;
  if (const auto* observed = std::get_if<ObservedScan>(&item))
  {
    name = sensorNameOf(*observed->observation);
    const auto& pose = observed->robotPose_map;
    const Eigen::Vector3d position_map(pose.x(), pose.y(), pose.z());
    if (!log.firstPosition_map) log.firstPosition_map = position_map;
    log.farthestFromFirst_m =
        std::max(log.farthestFromFirst_m, (position_map - *log.firstPosition_map).norm());
  }
  else
    name = std::get<PointScan>(item).kind;
  Sensor& sensor = log.sensors[name];
  if (isWorthALook(sensor.scans++)) lookClosely(item, sensor);
  lookedAt_ = &sensor;
  before_ = rayCountsOf(map_);
}

void BuildNotes::inserted()
{
  if (lookedAt_ == nullptr) return;
  const RayCounts now = rayCountsOf(map_);
  const size_t missing = now.noReturn - before_.noReturn;
  const size_t freeOnly = now.freeOnly - before_.freeOnly;
  lookedAt_->emptyScans.add(now.hits - before_.hits + freeOnly - missing, missing);
}

void BuildNotes::lookClosely(const ScanItem& item, Sensor& sensor) const
{
  if (const auto* observed = std::get_if<ObservedScan>(&item))
  {
    const double aperture_rad = statedApertureOf(*observed->observation);
    if (apertureNote("", "", aperture_rad)) sensor.illegalAperture_rad = aperture_rad;
  }
  const auto scan = scanOf(item);
  if (!scan) return;
  const ScanLook seen = lookAt(*scan);
  if (!seen.ranges) return;
  ++sensor.lookedAt;
  sensor.longest_m = std::max(sensor.longest_m, seen.ranges->longest_m);
  sensor.shells.add(seen);
  if (const double maxRange_m = maxRangeOf(map_); maxRange_m > 0 && areManyAt(maxRange_m, *scan))
    ++sensor.shellsAtLimit;
  const std::vector<Eigen::Vector3d> points_map = returnsOf(*scan);
  sensor.height_m = std::max(sensor.height_m, heightOf(points_map));
  if (const auto resolution_m = resolutionOf(map_); resolution_m && areCrowded(points_map, *resolution_m))
    ++sensor.crowded;
}

std::vector<std::string> BuildNotes::notes() const
{
  const auto emptyNote = [](const std::string& name, const Sensor& sensor, const Log& log)
  { return emptyScansNote(log.source->path(), name, sensor.emptyScans, log.sensors.size() == 1); };
  const auto beamNote = [](const std::string& name, const Sensor& sensor, const Log& log)
  { return apertureNote(log.source->path(), name, sensor.illegalAperture_rad); };
  const auto bind = [this](auto method)
  {
    return firstOf([this, method](const std::string& name, const Sensor& sensor, const Log& log)
                   { return (this->*method)(name, sensor, log); });
  };
  std::vector<std::string> notes;
  for (const auto& note : {odometryNotes(), bind(&BuildNotes::planarNote), bind(&BuildNotes::coarseNote),
                           bind(&BuildNotes::shellNote), firstOf(emptyNote), firstOf(beamNote)})
    if (note) notes.push_back(*note);
  return notes;
}

std::optional<std::string> BuildNotes::odometryNotes() const
{
  // A robot that hardly moved has not drifted.
  const double least_m = resolutionOf(map_).value_or(0);
  std::vector<std::string> paths;
  for (const Log& log : logs_)
    if (log.source->posesAreOdometry() && log.farthestFromFirst_m > least_m)
      paths.push_back(log.source->path());
  if (paths.empty()) return std::nullopt;
  const std::vector<std::string> others(paths.begin() + 1, paths.end());
  return odometryNote(paths.front()) + (others.empty() ? "" : ". The same holds for " + firstFewOf(others));
}

std::optional<std::string> BuildNotes::firstOf(const NoteOnSensor& noteOn) const
{
  std::optional<std::string> first;
  std::vector<std::string> others;
  for (const Log& log : logs_)
    for (const auto& [name, sensor] : log.sensors)
    {
      const auto note = noteOn(name, sensor, log);
      if (!note) continue;
      if (first)
        others.push_back(name + " in " + log.source->path());
      else
        first = note;
    }
  if (!others.empty()) *first += ". The same holds for " + firstFewOf(others);
  return first;
}

std::optional<std::string> BuildNotes::planarNote(const std::string& name, const Sensor& sensor,
                                                  const Log& log) const
{
  const auto* learned = dynamic_cast<const CLearnedMap*>(&map_);
  if (learned == nullptr || !learned->planarLayer()) return std::nullopt;
  constexpr double kFlat_m = 0.5;
  if (sensor.height_m <= std::max(kFlat_m, 2 * learned->resolution())) return std::nullopt;
  return log.source->path() + ": " + name +
         mrpt::format(
             ": its scans are %.1f m high, but the map is planar: all heights go into its "
             "one layer, so that ground and ceiling become obstacles. Build in 3D "
             "(-s creationOpts.planar=false) and project what is of interest: lamap "
             "export MAP -o map.yaml --z-min 0.3 --z-max 1.8",
             sensor.height_m);
}

std::optional<std::string> BuildNotes::coarseNote(const std::string& name, const Sensor& sensor,
                                                  const Log& log) const
{
  const auto resolution_m = resolutionOf(map_);
  if (!resolution_m || sensor.lookedAt == 0 || sensor.longest_m <= 0) return std::nullopt;
  constexpr double kCellsToFarthest = 10;
  const bool isShort = *resolution_m > sensor.longest_m / kCellsToFarthest;
  if (!isShort && 2 * sensor.crowded <= sensor.lookedAt) return std::nullopt;
  const double finer_m = roundedDown(std::min(sensor.longest_m / 50, *resolution_m / 4));
  return log.source->path() + ": " + name +
         mrpt::format(": cells of %.4g m are larger than what they hold: ", *resolution_m) +
         (isShort ? mrpt::format("the farthest return is %.4g m away", sensor.longest_m)
                  : std::string("more than half of a scan lies in fewer than ten cells")) +
         mrpt::format("; try -s creationOpts.resolution=%.4g", finer_m);
}

std::optional<std::string> BuildNotes::shellNote(const std::string& name, const Sensor& sensor,
                                                 const Log& log) const
{
  const double maxRange_m = maxRangeOf(map_);
  if (sensor.shellsAtLimit > 0 && 4 * sensor.shellsAtLimit >= sensor.lookedAt)
    return log.source->path() + ": " + name +
           mrpt::format(
               ": many returns of a scan lie at insertOpts.maxRange itself, %.4g m. If the sensor writes so "
               "what it "
               "does not see, they make a phantom shell; a smaller one leaves only free space there: -s "
               "insertOpts.maxRange=%.3g",
               maxRange_m, 0.99 * maxRange_m);
  const auto shell_m = sensor.shells.nearest_m();
  // The returns of a shell at maxRange itself are rounded to either side of it: half of them are hits.
  constexpr double kSame = 0.999;
  if (!shell_m || (maxRange_m > 0 && maxRange_m < kSame * *shell_m)) return std::nullopt;
  return phantomShellNote(log.source->path(), name, *shell_m);
}

}  // namespace lamap::tools
