#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <lamap_tools/commands/build_notes.h>
#include <lamap_tools/inputs/scan_look.h>
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

std::string phantomShellNote(const std::string& sensor, double range_m)
{
  return sensor + mrpt::format(
                      ": many returns of a scan lie at the same longest range, %.2f m, and neither "
                      "the log nor the map limits it. If the sensor writes so what it does not "
                      "see, they make a phantom shell; below it, insertOpts.maxRange leaves only "
                      "free space there: -s insertOpts.maxRange=%.3g",
                      range_m, 0.99 * range_m);
}

void BuildNotes::look(const ScanItem& item)
{
  std::string name;
  Eigen::Vector3d position_map;
  if (const auto* observed = std::get_if<ObservedScan>(&item))
  {
    name = sensorNameOf(*observed->observation);
    const auto& pose = observed->robotPose_map;
    position_map = {pose.x(), pose.y(), pose.z()};
    if (!firstPosition_map_) firstPosition_map_ = position_map;
    farthestFromFirst_m_ = std::max(farthestFromFirst_m_, (position_map - *firstPosition_map_).norm());
  }
  else if (const auto* points = std::get_if<PointScan>(&item))
    name = points->kind;
  else
    return;
  constexpr size_t kFirst = 10;
  constexpr size_t kEvery = 20;
  Sensor& sensor = sensors_[name];
  const size_t number = sensor.scans++;
  if (number < kFirst || number % kEvery == 0) lookClosely(item, sensor);
}

void BuildNotes::lookClosely(const ScanItem& item, Sensor& sensor) const
{
  const auto scan = scanOf(item);
  if (!scan) return;
  const ScanLook seen = lookAt(*scan);
  if (!seen.ranges) return;
  ++sensor.lookedAt;
  sensor.longest_m = std::max(sensor.longest_m, seen.ranges->longest_m);
  const double maxRange_m = maxRangeOf(map_);
  const bool isCut = maxRange_m > 0 && maxRange_m < seen.ranges->longest_m;
  if (seen.hasPhantomShell() && !isCut)
  {
    ++sensor.phantomShells;
    sensor.shell_m = seen.ranges->longest_m;
  }
  const std::vector<Eigen::Vector3d> points_map = returnsOf(*scan);
  sensor.height_m = std::max(sensor.height_m, heightOf(points_map));
  if (const auto resolution_m = resolutionOf(map_); resolution_m && areCrowded(points_map, *resolution_m))
    ++sensor.crowded;
}

std::vector<std::string> BuildNotes::notes(const std::vector<std::unique_ptr<ScanSource>>& sources) const
{
  std::vector<std::string> notes;
  const auto odometry = std::find_if(sources.begin(), sources.end(),
                                     [](const auto& source) { return source->posesAreOdometry(); });
  // A robot that hardly moved has not drifted.
  const double least_m = resolutionOf(map_).value_or(0);
  if (odometry != sources.end() && farthestFromFirst_m_ > least_m)
    notes.push_back(odometryNote((*odometry)->path()));
  for (const auto& note : {planarNote(), coarseNote(), shellNote()})
    if (note) notes.push_back(*note);
  return notes;
}

std::optional<std::string> BuildNotes::planarNote() const
{
  const auto* learned = dynamic_cast<const CLearnedMap*>(&map_);
  if (learned == nullptr || !learned->planarLayer()) return std::nullopt;
  constexpr double kFlat_m = 0.5;
  for (const auto& [name, sensor] : sensors_)
    if (sensor.height_m > std::max(kFlat_m, 2 * learned->resolution()))
      return name + mrpt::format(
                        ": its scans are %.1f m high, but the map is planar: all heights go into its "
                        "one layer, so that ground and ceiling become obstacles. Build in 3D "
                        "(-s creationOpts.planar=false) and project what is of interest: lamap "
                        "export MAP -o map.yaml --z-min 0.3 --z-max 1.8",
                        sensor.height_m);
  return std::nullopt;
}

std::optional<std::string> BuildNotes::coarseNote() const
{
  const auto resolution_m = resolutionOf(map_);
  if (!resolution_m) return std::nullopt;
  constexpr double kCellsToFarthest = 10;
  for (const auto& [name, sensor] : sensors_)
  {
    if (sensor.lookedAt == 0 || sensor.longest_m <= 0) continue;
    const bool isShort = *resolution_m > sensor.longest_m / kCellsToFarthest;
    if (!isShort && 2 * sensor.crowded <= sensor.lookedAt) continue;
    const double finer_m = roundedDown(std::min(sensor.longest_m / 50, *resolution_m / 4));
    return mrpt::format("cells of %.4g m are larger than what they hold: of %s, ", *resolution_m,
                        name.c_str()) +
           (isShort ? mrpt::format("the farthest return is %.4g m away", sensor.longest_m)
                    : std::string("more than half of a scan lies in fewer than ten cells")) +
           mrpt::format("; try -s creationOpts.resolution=%.4g", finer_m);
  }
  return std::nullopt;
}

std::optional<std::string> BuildNotes::shellNote() const
{
  for (const auto& [name, sensor] : sensors_)
    if (4 * sensor.phantomShells >= sensor.lookedAt && sensor.phantomShells > 0)
      return phantomShellNote(name, sensor.shell_m);
  return std::nullopt;
}

}  // namespace lamap::tools
