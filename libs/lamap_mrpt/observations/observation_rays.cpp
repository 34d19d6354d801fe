#include <lamap_core/scan/beam_cone.h>
#include <lamap_mrpt/compat/mrpt_compat.h>
#include <lamap_mrpt/observations/isometry.h>
#include <lamap_mrpt/observations/observation_rays.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRange.h>
#include <mrpt/obs/CObservationRotatingScan.h>
#include <mrpt/obs/CObservationVelodyneScan.h>
#include <mrpt/obs/VelodyneCalibration.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>

namespace lamap
{
namespace
{
using mrpt::obs::CObservation;
using mrpt::obs::CObservation2DRangeScan;
using mrpt::obs::CObservation3DRangeScan;
using mrpt::obs::CObservationPointCloud;
using mrpt::obs::CObservationRange;
using mrpt::obs::CObservationRotatingScan;
using mrpt::obs::CObservationVelodyneScan;
using mrpt::obs::VelodyneCalibration;
using mrpt::poses::CPose3D;

/// A scan without rays yet, of one optical centre.
Scan scanFrom(const CPose3D& robotPose, const CPose3D& sensorPose, double statedRangeMin_m,
              double statedRangeMax_m)
{
  Scan scan;
  scan.sensorPose_map = isometryOf(robotPose) * isometryOf(sensorPose);
  RayFan& fan = scan.fans.emplace_back();
  fan.statedRangeMin_m = statedRangeMin_m;
  fan.statedRangeMax_m = statedRangeMax_m;
  return scan;
}

/// What a range stands for, as drivers write it (REP 117). Ranges that are not stated are 0.
/// @param zero what a range of 0 is the code for
RayEnd meaningOf(double range_m, RayEnd zero, const RayFan& fan)
{
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (range_m == -kInfinity) return RayEnd::TooNear;
  if (range_m == 0) return zero;
  if (!(range_m > 0)) return RayEnd::Dropped;  // also NaN
  if (range_m == kInfinity || (fan.statedRangeMax_m > 0 && range_m >= fan.statedRangeMax_m))
    return RayEnd::NoReturn;
  return range_m < fan.statedRangeMin_m ? RayEnd::TooNear : RayEnd::Return;
}

/// Adds a ray that ended at a range, or whatever it means.
void addRange(double range_m, RayEnd meaning, const Eigen::Vector3d& direction, RayFan& fan)
{
  if (meaning == RayEnd::Return)
    fan.addReturn(fan.centre + range_m * direction);
  else
    fan.add(meaning, direction);
}

Scan raysOf2DRangeScan(const CObservation2DRangeScan& scan2D, const CPose3D& robotPose)
{
  const double rangeMax_m = scan2D.maxRange > 0 ? scan2D.maxRange : 0;
  Scan scan = scanFrom(robotPose, scan2D.sensorPose, 0, rangeMax_m);
  RayFan& fan = scan.fans.front();
  fan.beam.halfWidth_rad = fan.beam.halfHeight_rad = halfApertureOf(statedApertureOf(scan2D));
  const std::size_t count = scan2D.getScanSize();
  fan.rays.reserve(count);

  const Eigen::Matrix3d sensorFromRobot = isometryOf(scan2D.sensorPose).linear().transpose();
  const double sign = scan2D.rightToLeft ? 1 : -1;
  for (std::size_t i = 0; i < count; ++i)
  {
    const double fraction = count > 1 ? static_cast<double>(i) / static_cast<double>(count - 1) : 0.5;
    const double azimuth = sign * scan2D.aperture * (fraction - 0.5);
    Eigen::Vector3d direction(std::cos(azimuth), std::sin(azimuth), 0);
    if (scan2D.deltaPitch != 0 && count > 1)
    {
      const CPose3D& start = scan2D.sensorPose;
      const CPose3D now(start.x(), start.y(), start.z(), start.yaw(),
                        start.pitch() + fraction * scan2D.deltaPitch, start.roll());
      direction = sensorFromRobot * (isometryOf(now).linear() * direction);
    }

    const double range_m = scan2D.getScanRange(i);
    const bool isValid = scan2D.getScanRangeValidity(i);
    RayEnd meaning = meaningOf(range_m, isValid ? RayEnd::Dropped : RayEnd::NoReturn, fan);
    if (!isValid && meaning == RayEnd::Return) meaning = RayEnd::Dropped;
    addRange(range_m, meaning, direction, fan);
  }
  return scan;
}

/// For each pixel, row by row, the point at depth 1 m in the frame of the depth camera (x forward, z up).
struct PixelDirections
{
  mrpt::img::TCamera camera;
  std::vector<Eigen::Vector3d> atUnitDepth;
};

/** Directions of a depth camera's pixels, by MRPT's camera model. The last camera's are kept: they are the
 * same for every image of a log, and undistorting costs more than all the rest. */
std::shared_ptr<const PixelDirections> pixelDirections(mrpt::img::TCamera camera, int rows, int columns)
{
  static std::mutex mutex;
  static std::shared_ptr<const PixelDirections> last;

  // The size that MRPT itself takes for granted: calibrations of externally stored images may state another.
  camera.nrows = static_cast<uint32_t>(rows);
  camera.ncols = static_cast<uint32_t>(columns);
  const std::lock_guard<std::mutex> lock(mutex);
  if (last && last->camera == camera) return last;

  // A scan of its own: MRPT keeps one table for each sensor pose, and needs a range image of the right size.
  CObservation3DRangeScan bare;
  bare.cameraParams = camera;
  bare.range_is_depth = true;
  bare.rangeImage_setSize(rows, columns);
  const auto& table = bare.get_unproj_lut();

  auto directions = std::make_shared<PixelDirections>();
  directions->camera = camera;
  directions->atUnitDepth.reserve(table.Kxs.size());
  for (std::size_t i = 0; i < table.Kxs.size(); ++i)
    directions->atUnitDepth.emplace_back(table.Kxs[i], table.Kys[i], table.Kzs[i]);
  last = directions;
  return directions;
}

bool isCalibrated(const mrpt::img::TCamera& camera)
{
  return std::isfinite(camera.fx()) && std::isfinite(camera.fy()) && camera.fx() > 0 && camera.fy() > 0;
}

/// Whether any pixel of an image has a reading that is a place.
bool holdsReadings(const CObservation3DRangeScan& scan3D)
{
  const float unit_m = scan3D.rangeUnits;
  return scan3D.rangeImage.size() > 0 && std::isfinite(unit_m) && unit_m > 0 &&
         !scan3D.rangeImage.asEigen().isZero();
}

void addRangeImage(const CObservation3DRangeScan& scan3D, RayFan& fan)
{
  const auto& image = scan3D.rangeImage;
  const auto directions = pixelDirections(scan3D.cameraParams, image.rows(), image.cols());
  fan.rays.reserve(directions->atUnitDepth.size());
  auto direction = directions->atUnitDepth.begin();
  for (int row = 0; row < image.rows(); ++row)
    for (int column = 0; column < image.cols(); ++column, ++direction)
    {
      if (image(row, column) == 0)
      {
        fan.add(RayEnd::Dropped, *direction);
        continue;
      }
      const double measured_m = image(row, column) * static_cast<double>(scan3D.rangeUnits);
      fan.addReturn(*direction * (scan3D.range_is_depth ? measured_m : measured_m / direction->norm()));
    }
}

template <typename Coordinates>
void requireSameCount(const Coordinates& x, const Coordinates& y, const Coordinates& z)
{
  if (x.size() != y.size() || x.size() != z.size())
    throw std::runtime_error("its points have " + std::to_string(x.size()) + " x, " +
                             std::to_string(y.size()) + " y and " + std::to_string(z.size()) +
                             " z coordinates");
}

Scan raysOf3DRangeScan(const CObservation3DRangeScan& scan3D, const CPose3D& robotPose)
{
  Scan scan = scanFrom(robotPose, scan3D.sensorPose, 0, scan3D.maxRange > 0 ? scan3D.maxRange : 0);
  RayFan& fan = scan.fans.front();
  const bool hasImage = scan3D.hasRangeImage && scan3D.rangeImage.rows() > 0 && scan3D.rangeImage.cols() > 0;
  const bool hasPoints = scan3D.hasPoints3D && !scan3D.points3D_x.empty();

  // The image first: points may have been made with other options, even in another frame. But frames exist
  // whose image is there and says nothing.
  const bool usesImage = hasImage && isCalibrated(scan3D.cameraParams);
  if (usesImage && (!hasPoints || holdsReadings(scan3D)))
    addRangeImage(scan3D, fan);
  else if (hasPoints)
  {
    requireSameCount(scan3D.points3D_x, scan3D.points3D_y, scan3D.points3D_z);
    fan.rays.reserve(scan3D.points3D_x.size());
    for (std::size_t i = 0; i < scan3D.points3D_x.size(); ++i)
    {
      const Eigen::Vector3d point(scan3D.points3D_x[i], scan3D.points3D_y[i], scan3D.points3D_z[i]);
      if (point == Eigen::Vector3d::Zero())
        fan.add(RayEnd::Dropped, point);
      else
        fan.addReturn(point);
    }
  }
  else if (hasImage)
    throw std::runtime_error("its range image has no calibration: the focal lengths in cameraParams are " +
                             std::to_string(scan3D.cameraParams.fx()) + " and " +
                             std::to_string(scan3D.cameraParams.fy()) + " pixels, and must be positive");
  return scan;
}

Scan raysOfPointCloud(const CObservationPointCloud& cloud, const CPose3D& robotPose)
{
  Scan scan = scanFrom(robotPose, cloud.sensorPose, 0, 0);
  RayFan& fan = scan.fans.front();
  if (cloud.pointcloud)
  {
    const std::size_t count = cloud.pointcloud->size();
    fan.rays.reserve(count);
    for (std::size_t i = 0; i < count; ++i)
    {
      float x = 0;
      float y = 0;
      float z = 0;
      cloud.pointcloud->getPointFast(i, x, y, z);
      fan.addReturn({x, y, z});
    }
  }
  return scan;
}

Scan raysOfVelodyneScan(const CObservationVelodyneScan& velodyne, const CPose3D& robotPose)
{
  Scan scan = scanFrom(robotPose, velodyne.sensorPose, velodyne.minRange, velodyne.maxRange);
  RayFan& fan = scan.fans.front();

  CObservationVelodyneScan generated;
  const auto* points = &velodyne.point_cloud;
  if (points->size() == 0 && !velodyne.scan_packets.empty())
  {
    // generatePointCloud() fills the observation itself: a copy keeps the caller's as it is.
    generated = velodyne;
    CObservationVelodyneScan::TGeneratePointCloudParameters parameters;
    parameters.minDistance = 0;  // minRange of the observation holds; MRPT's default would cut at 1 m
    generated.generatePointCloud(parameters);
    points = &generated.point_cloud;
  }
  requireSameCount(points->x, points->y, points->z);
  fan.rays.reserve(points->size());
  for (std::size_t i = 0; i < points->size(); ++i) fan.addReturn({points->x[i], points->y[i], points->z[i]});
  return scan;
}

/** Elevations of a rotating scanner's rows; null where the model is unknown.
 * CObservationRotatingScan does not hold them: it names the model. */
const VelodyneCalibration* calibrationOf(const CObservationRotatingScan& rotating)
{
  // Once each: MRPT's own cache is not safe for threads.
  static const VelodyneCalibration vlp16 = VelodyneCalibration::LoadDefaultCalibration("VLP16");
  static const VelodyneCalibration hdl32 = VelodyneCalibration::LoadDefaultCalibration("HDL32");
  const VelodyneCalibration* calibration = nullptr;
  if (rotating.lidarModel == "VLP-16") calibration = &vlp16;
  if (rotating.lidarModel == "HDL-32E") calibration = &hdl32;
  if (calibration && calibration->laser_corrections.size() != rotating.rowCount) return nullptr;
  return calibration;
}

/** CObservationRotatingScan::fromVelodyne() declares a column for every single return of a firing, fills only
 * the first columnCount/rowCount, and counts azimuths clockwise, against the class's documentation. */
bool isFilledByFromVelodyne(const CObservationRotatingScan& rotating)
{
  constexpr int kReturnsPerPacket =
      CObservationVelodyneScan::SCANS_PER_BLOCK * CObservationVelodyneScan::BLOCKS_PER_PACKET;
  const auto& image = rotating.rangeImage;
  if (image.cols() == 0 || image.cols() % kReturnsPerPacket != 0) return false;
  for (int row = 0; row < image.rows(); ++row)
    for (int column = static_cast<int>(image.cols() / image.rows()); column < image.cols(); ++column)
      if (image(row, column) != 0) return false;
  return true;
}

/// @param calibration of the rows' elevations; null: a single row, in the plane of the sensor
void addColumns(const CObservationRotatingScan& rotating, const VelodyneCalibration* calibration, RayFan& fan)
{
  const auto& image = rotating.rangeImage;
  const bool compact = calibration && isFilledByFromVelodyne(rotating);
  const int columns = static_cast<int>(compact ? image.cols() / image.rows() : image.cols());
  const double clockwise = compact ? -1 : 1;
  const double steps = compact ? columns : std::max(columns - 1, 1);
  for (int column = 0; column < columns; ++column)
  {
    if (compact && image.asEigen().col(column).isZero()) continue;  // a firing that MRPT did not read
    const double azimuth = clockwise * (rotating.startAzimuth + rotating.azimuthSpan * column / steps);
    Eigen::Vector3d direction(std::cos(azimuth), std::sin(azimuth), 0);
    for (int row = 0; row < image.rows(); ++row)
    {
      if (calibration)
      {
        const auto& laser = calibration->laser_corrections[static_cast<std::size_t>(row)];
        direction << laser.cosVertCorrection * std::cos(azimuth), laser.cosVertCorrection * std::sin(azimuth),
            laser.sinVertCorrection;
      }
      const double range_m = image(row, column) * rotating.rangeResolution;
      addRange(range_m, meaningOf(range_m, RayEnd::NoReturn, fan), direction, fan);
    }
  }
}

bool hasKnownRows(const CObservationRotatingScan& rotating)
{
  return rotating.rowCount == 1 || calibrationOf(rotating) || compat::hasOrganizedPoints(rotating);
}

Scan raysOfRotatingScan(const CObservationRotatingScan& rotating, const CPose3D& robotPose)
{
  Scan scan = scanFrom(robotPose, rotating.sensorPose, rotating.minRange, rotating.maxRange);
  RayFan& fan = scan.fans.front();
  const auto& image = rotating.rangeImage;
  if (image.rows() != rotating.rowCount)
    throw std::runtime_error("its range image has " + std::to_string(image.rows()) + " rows, rowCount is " +
                             std::to_string(rotating.rowCount));

  fan.rays.reserve(static_cast<std::size_t>(image.size()));
  const VelodyneCalibration* calibration = calibrationOf(rotating);
  if (calibration || rotating.rowCount == 1)
    addColumns(rotating, calibration, fan);
  else
    compat::forEachOrganizedPoint(rotating, [&](const Eigen::Vector3d& point) { fan.addReturn(point); });
  return scan;
}

Scan raysOfRange(const CObservationRange& ranges, const CPose3D& robotPose)
{
  const double rangeMin_m = ranges.minSensorDistance > 0 ? ranges.minSensorDistance : 0;
  const double rangeMax_m = ranges.maxSensorDistance > 0 ? ranges.maxSensorDistance : 0;
  Scan scan;
  if (ranges.sensedData.empty()) return scan;
  // The first sensor's frame is that of them all.
  const mrpt::math::TPose3D& firstPose = ranges.sensedData.front().sensorPose;
  const Eigen::Isometry3d first = isometryOf(CPose3D(firstPose));
  scan.sensorPose_map = isometryOf(robotPose) * first;
  for (const auto& measurement : ranges.sensedData)
  {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    if (!(measurement.sensorPose == firstPose))
      pose = first.inverse() * isometryOf(CPose3D(measurement.sensorPose));
    RayFan& fan = scan.fans.emplace_back();
    fan.centre = pose.translation();
    fan.statedRangeMin_m = rangeMin_m;
    fan.statedRangeMax_m = rangeMax_m;
    fan.beam.halfWidth_rad = fan.beam.halfHeight_rad = halfApertureOf(statedApertureOf(ranges));
    const double range_m = measurement.sensedDistance;
    addRange(range_m, meaningOf(range_m, RayEnd::NoReturn, fan), pose.linear().col(0), fan);
  }
  return scan;
}

/** Rank among the echoes of one pulse, which drivers write as observations of the same time: "SONAR/echo2" is
 * that of the second. 0: the first, or no such label. */
uint8_t echoRankOf(const std::string& label)
{
  constexpr std::string_view kEnding = "/echo";
  const size_t at = label.rfind(kEnding);
  if (at == std::string::npos) return 0;
  unsigned number = 0;
  const char* end = label.data() + label.size();
  const auto [stopped, error] = std::from_chars(label.data() + at + kEnding.size(), end, number);
  if (stopped != end) return 0;
  constexpr uint8_t kLast = 255;
  if (error == std::errc::result_out_of_range || number > kLast) return kLast;
  return static_cast<uint8_t>(std::max(number, 1U) - 1);
}

/// Holds externally stored data in memory while it lives.
class LoadedData
{
 public:
  explicit LoadedData(const CObservation& observation)
      : observation_(observation), wasLoaded_(isLoaded(observation))
  {
    if (!wasLoaded_) observation_.load();
  }
  ~LoadedData()
  {
    if (wasLoaded_) return;
    try
    {
      observation_.unload();
    }
    catch (const std::exception&)
    {
      // It stays in memory: a loss of memory only, and nothing that the caller could mend.
    }
  }
  LoadedData(const LoadedData&) = delete;
  LoadedData& operator=(const LoadedData&) = delete;

 private:
  static bool isLoaded(const CObservation& observation)
  {
    if (const auto* scan3D = dynamic_cast<const CObservation3DRangeScan*>(&observation))
      return !(scan3D->hasRangeImage && scan3D->rangeImage_isExternallyStored() &&
               scan3D->rangeImage.size() == 0) &&
             !(scan3D->hasPoints3D && scan3D->points3D_isExternallyStored() && scan3D->points3D_x.empty());
    if (const auto* cloud = dynamic_cast<const CObservationPointCloud*>(&observation))
      return !cloud->isExternallyStored() || cloud->pointcloud;
    if (const auto* rotating = dynamic_cast<const CObservationRotatingScan*>(&observation))
      return !compat::isExternallyStored(*rotating) || rotating->rangeImage.size() != 0;
    return true;
  }

  const CObservation& observation_;
  const bool wasLoaded_;
};

Scan raysOfSupported(const CObservation& observation, const CPose3D& robotPose)
{
  const LoadedData loaded(observation);
  if (const auto* scan2D = dynamic_cast<const CObservation2DRangeScan*>(&observation))
    return raysOf2DRangeScan(*scan2D, robotPose);
  if (const auto* scan3D = dynamic_cast<const CObservation3DRangeScan*>(&observation))
    return raysOf3DRangeScan(*scan3D, robotPose);
  if (const auto* cloud = dynamic_cast<const CObservationPointCloud*>(&observation))
    return raysOfPointCloud(*cloud, robotPose);
  if (const auto* velodyne = dynamic_cast<const CObservationVelodyneScan*>(&observation))
    return raysOfVelodyneScan(*velodyne, robotPose);
  if (const auto* rotating = dynamic_cast<const CObservationRotatingScan*>(&observation))
    return raysOfRotatingScan(*rotating, robotPose);
  return raysOfRange(dynamic_cast<const CObservationRange&>(observation), robotPose);
}

}  // namespace

bool supportsObservation(const CObservation& observation)
{
  if (const auto* rotating = dynamic_cast<const CObservationRotatingScan*>(&observation))
    return hasKnownRows(*rotating);
  return dynamic_cast<const CObservation2DRangeScan*>(&observation) ||
         dynamic_cast<const CObservation3DRangeScan*>(&observation) ||
         dynamic_cast<const CObservationPointCloud*>(&observation) ||
         dynamic_cast<const CObservationVelodyneScan*>(&observation) ||
         dynamic_cast<const CObservationRange*>(&observation);
}

double statedApertureOf(const CObservation& observation)
{
  if (const auto* scan2D = dynamic_cast<const CObservation2DRangeScan*>(&observation))
    return scan2D->beamAperture;
  if (const auto* ranges = dynamic_cast<const CObservationRange*>(&observation))
    return compat::coneApertureOf(*ranges);
  return 0;
}

std::optional<Scan> raysOf(const CObservation& observation, const CPose3D& robotPose)
{
  if (!supportsObservation(observation)) return std::nullopt;
  try
  {
    Scan scan = raysOfSupported(observation, robotPose);
    scan.requireRigidPose();
    if (const uint8_t echo = echoRankOf(observation.sensorLabel))
      for (RayFan& fan : scan.fans)
        for (Ray& ray : fan.rays) ray.echo = echo;
    return scan;
  }
  catch (const std::exception& error)
  {
    throw std::runtime_error(std::string("cannot read the ") + observation.GetRuntimeClass()->className +
                             " of sensor '" + observation.sensorLabel + "': " + compat::messageOf(error));
  }
}

}  // namespace lamap
