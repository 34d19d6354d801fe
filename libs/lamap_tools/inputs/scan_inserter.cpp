#include <lamap_mrpt/compat/mrpt_compat.h>
#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <lamap_mrpt/observations/observation_rays.h>
#include <lamap_tools/inputs/scan_inserter.h>
#include <mrpt/maps/CPointsMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationVelodyneScan.h>

#include <new>
#include <numeric>

namespace lamap::tools
{
using mrpt::poses::CPose3D;

namespace
{
template <class Counts>
size_t sumOf(const Counts& counts)
{
  size_t sum = 0;
  for (const auto& entry : counts) sum += entry.second;
  return sum;
}

std::string kindOf(const mrpt::obs::CObservation& observation)
{
  const std::string name = observation.GetRuntimeClass()->className;
  const size_t colon = name.rfind(':');
  return colon == std::string::npos ? name : name.substr(colon + 1);
}

bool isPointCloud(const mrpt::obs::CObservation& observation)
{
  return IS_CLASS(observation, mrpt::obs::CObservationPointCloud) ||
         IS_CLASS(observation, mrpt::obs::CObservationVelodyneScan);
}

/// A cloud's points, from any observation that raysOf() reads from one place.
PointScan pointsOf(const mrpt::obs::CObservation& observation, const CPose3D& robotPose)
{
  PointScan points;
  CPose3D sensorInRobot;
  observation.getSensorPose(sensorInRobot);
  points.sensorPose_map = robotPose + sensorInRobot;
  if (const auto scan = raysOf(observation, robotPose))
    for (const RayFan& fan : scan->fans)
      points.points_map.insert(points.points_map.end(), fan.returns_map.begin(), fan.returns_map.end());
  return points;
}
}  // namespace

Scan scanOf(const PointScan& points)
{
  RayFan fan;
  fan.origin_map = {points.sensorPose_map.x(), points.sensorPose_map.y(), points.sensorPose_map.z()};
  fan.returns_map = points.points_map;
  return Scan{{std::move(fan)}};
}

size_t InsertionTally::usedCount() const
{
  return sumOf(used);
}
size_t InsertionTally::leftOutCount() const
{
  return sumOf(leftOut);
}

void ScanInserter::insert(const ScanItem& item)
{
  std::visit([this](const auto& scan) { insert(scan); }, item);
}

void ScanInserter::insert(const ObservedScan& scan)
{
  count(kindOf(*scan.observation), tryInserting(scan));
}

void ScanInserter::insert(const PointScan& scan)
{
  count(scan.kind, tryInserting(scan));
}

void ScanInserter::insert(const LeftOutScan& scan)
{
  count(scan.kind, scan.reason);
}

std::string ScanInserter::tryInserting(const ObservedScan& scan)
{
  if (!map_.genericMapParams.enableObservationInsertion)
    return "the map has enableObservationInsertion = false";
  try
  {
    if (auto* learned = dynamic_cast<CLearnedMap*>(&map_))
    {
      if (!supportsObservation(*scan.observation)) return "the map takes no observation of this class";
      const bool taken = scan.uncertainPose_map
                             ? learned->insertObservationAt(*scan.observation, *scan.uncertainPose_map)
                             : learned->insertObservation(*scan.observation, scan.robotPose_map);
      return taken ? "" : "it holds no ray that can be used";
    }
    if (isPointCloud(*scan.observation))
      return insertPoints(pointsOf(*scan.observation, scan.robotPose_map)) ? ""
                                                                           : "the map took nothing of it";
    scan.observation->load();
    return map_.insertObservation(*scan.observation, scan.robotPose_map) ? "" : "the map took nothing of it";
  }
  catch (const std::bad_alloc&)
  {
    throw;
  }
  catch (const std::exception& error)
  {
    return compat::messageOf(error);
  }
}

std::string ScanInserter::tryInserting(const PointScan& scan)
{
  if (!map_.genericMapParams.enableObservationInsertion)
    return "the map has enableObservationInsertion = false";
  if (auto* learned = dynamic_cast<CLearnedMap*>(&map_))
    return learned->insertScan(scanOf(scan)) ? "" : "it holds no point that can be used";
  return insertPoints(scan) ? "" : "the map took nothing of it";
}

bool ScanInserter::insertPoints(const PointScan& scan)
{
  // A point map needs no origin of the rays: its points go in as they are.
  const bool isPointsMap = dynamic_cast<const mrpt::maps::CPointsMap*>(&map_) != nullptr;
  const CPose3D origin = isPointsMap ? CPose3D() : scan.sensorPose_map;
  auto cloud = mrpt::maps::CSimplePointsMap::Create();
  cloud->reserve(scan.points_map.size());
  for (const Eigen::Vector3d& point : scan.points_map)
  {
    if (!point.allFinite()) continue;
    mrpt::math::TPoint3D local;
    origin.inverseComposePoint(point.x(), point.y(), point.z(), local.x, local.y, local.z);
    cloud->insertPoint(local);
  }
  if (cloud->empty()) return false;
  mrpt::obs::CObservationPointCloud observation;
  observation.pointcloud = cloud;
  return map_.insertObservation(observation, origin);
}

void ScanInserter::count(const std::string& kind, const std::string& reason)
{
  if (reason.empty())
    ++tally_.used[kind];
  else
    ++tally_.leftOut[{kind, reason}];
}

std::string reasonsOf(const InsertionTally& tally)
{
  std::string reasons;
  for (const auto& [what, count] : tally.leftOut)
    reasons += "\n  " + std::to_string(count) + " " + what.first + ": " + what.second;
  return reasons;
}

}  // namespace lamap::tools
