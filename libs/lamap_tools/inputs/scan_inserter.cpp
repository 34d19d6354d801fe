#include <lamap_mrpt/compat/mrpt_compat.h>
#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <lamap_mrpt/observations/isometry.h>
#include <lamap_mrpt/observations/observation_rays.h>
#include <lamap_tools/inputs/scan_inserter.h>
#include <mrpt/maps/COctoMap.h>
#include <mrpt/maps/CPointsMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRange.h>
#include <mrpt/obs/CObservationVelodyneScan.h>

#include <new>
#include <numeric>
#include <stdexcept>

namespace lamap::tools
{
using mrpt::poses::CPose3D;

namespace
{
bool isPointCloud(const mrpt::obs::CObservation& observation)
{
  return IS_CLASS(observation, mrpt::obs::CObservationPointCloud) ||
         IS_CLASS(observation, mrpt::obs::CObservationVelodyneScan);
}

/// Whether MRPT's octrees refuse an observation, though they could learn from its points.
bool isSingleBeam(const mrpt::obs::CObservation& observation)
{
  const auto* scan2D = dynamic_cast<const mrpt::obs::CObservation2DRangeScan*>(&observation);
  return (scan2D != nullptr && scan2D->getScanSize() == 1) ||
         IS_CLASS(observation, mrpt::obs::CObservationRange);
}

/// What a scan is called in reports.
std::string kindOf(const ScanItem& item)
{
  if (const auto* observed = std::get_if<ObservedScan>(&item)) return shortClassName(*observed->observation);
  if (const auto* points = std::get_if<PointScan>(&item)) return points->kind;
  return std::get<LeftOutScan>(item).kind;
}

/// "NAME: ", or nothing where a scan has no name of its own.
std::string nameOf(const ScanItem& item)
{
  const auto* points = std::get_if<PointScan>(&item);
  return points == nullptr || points->name.empty() ? "" : points->name + ": ";
}

/// "COUNT KIND: REASON (the first: WHICH)" for each kind and reason.
std::vector<std::string> linesOn(const InsertionTally& tally)
{
  std::vector<std::string> lines;
  for (const auto& [what, scans] : tally.leftOut)
  {
    lines.push_back(std::to_string(scans.count) + " " + what.first + ": " + what.second);
    if (const std::string first = textOf(scans.first); !first.empty())
      lines.back() += (scans.count > 1 ? " (the first: " : " (") + first + ")";
  }
  return lines;
}
}  // namespace

size_t InsertionTally::usedCount() const
{
  size_t sum = 0;
  for (const auto& entry : used) sum += entry.second;
  return sum;
}

void ScanInserter::insert(const ScanItem& item)
{
  const std::string kind = kindOf(item);
  std::string reason;
  try
  {
    const std::string against = std::visit([](const auto& scan) { return reasonAgainstPose(scan); }, item);
    if (!against.empty()) throw std::runtime_error(against);
    reason = std::visit([this](const auto& scan) { return tryInserting(scan); }, item);
  }
  catch (const std::exception& error)
  {
    const bool isMemory = dynamic_cast<const std::bad_alloc*>(&error) != nullptr;
    reason = nameOf(item) + (isMemory ? "not enough memory" : compat::messageOf(error));
    if (strict_) throw std::runtime_error(kind + " " + textOf(placeOf(item)) + ": " + reason);
    ++tally_.failed;
  }
  if (reason.empty())
    ++tally_.used[kind];
  else
    tally_.leaveOut(kind, reason, placeOf(item));
}

std::string ScanInserter::tryInserting(const ObservedScan& scan)
{
  if (!map_.genericMapParams.enableObservationInsertion)
    return "the map has enableObservationInsertion = false";
  if (auto* learned = dynamic_cast<CLearnedMap*>(&map_))
  {
    if (!supportsObservation(*scan.observation)) return "the map takes no observation of this class";
    const bool taken =
        learned->learnObservation(*scan.observation, scan.robotPose_map, scan.uncertainPose_map.get());
    return taken ? "" : "it holds no ray that can be used";
  }
  const bool isOctree = dynamic_cast<const mrpt::maps::COctoMap*>(&map_) != nullptr;
  if (isPointCloud(*scan.observation) || (isOctree && isSingleBeam(*scan.observation)))
    return insertPoints(*raysOf(*scan.observation, scan.robotPose_map)) ? "" : "the map took nothing of it";
  scan.observation->load();
  return map_.insertObservation(*scan.observation, scan.robotPose_map) ? "" : "the map took nothing of it";
}

std::string ScanInserter::tryInserting(const PointScan& scan)
{
  if (!map_.genericMapParams.enableObservationInsertion)
    return "the map has enableObservationInsertion = false";
  if (auto* learned = dynamic_cast<CLearnedMap*>(&map_))
    return learned->insertScan(scan.scan) ? "" : "it holds no point that can be used";
  return insertPoints(scan.scan) ? "" : "the map took nothing of it";
}

bool ScanInserter::insertPoints(const Scan& scan)
{
  // A point map needs no origin of the rays: its points go in as they are.
  const bool isPointsMap = dynamic_cast<const mrpt::maps::CPointsMap*>(&map_) != nullptr;
  bool taken = false;
  for (const RayFan& fan : scan.fans)
  {
    Eigen::Isometry3d origin(scan.sensorPose_map);
    origin.translation() = scan.inMap(fan.centre);
    auto cloud = mrpt::maps::CSimplePointsMap::Create();
    cloud->reserve(fan.rays.size());
    for (const Ray& ray : fan.rays)
    {
      if (ray.meaning != RayEnd::Return || !ray.end.allFinite()) continue;
      if (!isPointsMap && ray.end == fan.centre) continue;  // no return: the map would put an obstacle there
      const Eigen::Vector3d point = isPointsMap ? scan.inMap(ray.end) : Eigen::Vector3d(ray.end - fan.centre);
      cloud->insertPoint({point.x(), point.y(), point.z()});
    }
    if (cloud->empty()) continue;
    mrpt::obs::CObservationPointCloud observation;
    observation.pointcloud = cloud;
    taken |= map_.insertObservation(observation, isPointsMap ? CPose3D() : poseOf(origin));
  }
  return taken;
}

void InsertionTally::leaveOut(const std::string& kind, const std::string& reason, const ScanPlace& place)
{
  LeftOutScans& scans = leftOut[{kind, reason}];
  if (scans.count++ == 0) scans.first = place;
}

void printLeftOut(const InsertionTally& tally, std::ostream& out, const std::string& who)
{
  for (const std::string& line : linesOn(tally)) out << "  " << who << "left out: " << line << "\n";
}

std::string reasonsOf(const InsertionTally& tally, const std::string& separator)
{
  std::string reasons;
  for (const std::string& line : linesOn(tally)) reasons += separator + line;
  return reasons;
}

Json leftOutJson(const InsertionTally& tally)
{
  Json list = Json::array();
  for (const auto& [what, scans] : tally.leftOut)
  {
    const ScanPlace& first = scans.first;
    list.push_back({{"kind", what.first}, {"reason", what.second}, {"count", scans.count}});
    list.back()["first"] = {{"input", first.input}, {"number", first.number}};
    list.back()["first"]["time"] = first.time ? Json(mrpt::Clock::toDouble(*first.time)) : Json(nullptr);
  }
  return list;
}

}  // namespace lamap::tools
