#include <gtest/gtest.h>
#include <lamap_mrpt/compat/mrpt_compat.h>
#include <lamap_mrpt/observations/observation_rays.h>
#include <mrpt/io/lazy_load_path.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRange.h>
#include <mrpt/obs/CObservationRotatingScan.h>
#include <mrpt/obs/CObservationVelodyneScan.h>
#include <mrpt/obs/CRawlog.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>

namespace
{
using lamap::raysOf;
using lamap::Scan;
using lamap::supportsObservation;
using mrpt::obs::CObservation2DRangeScan;
using mrpt::obs::CObservation3DRangeScan;
using mrpt::obs::CObservationPointCloud;
using mrpt::obs::CObservationRange;
using mrpt::obs::CObservationRotatingScan;
using mrpt::obs::CObservationVelodyneScan;
using mrpt::poses::CPose3D;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

// Robot and sensor both rotated about all axes and translated.
constexpr std::array<double, 6> kRobot = {10.0, -4.0, 1.5, 0.7, -0.2, 0.3};
constexpr std::array<double, 6> kSensor = {0.4, 0.25, 0.9, -1.1, 0.35, -0.6};

CPose3D poseOf(const std::array<double, 6>& p)
{
  return {p[0], p[1], p[2], p[3], p[4], p[5]};
}

/// Rotation by yaw, pitch and roll about z, y and x, as MRPT defines them; composed here without MRPT.
Eigen::Matrix3d rotationOf(const std::array<double, 6>& p)
{
  return (Eigen::AngleAxisd(p[3], Eigen::Vector3d::UnitZ()) *
          Eigen::AngleAxisd(p[4], Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(p[5], Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

Eigen::Vector3d inMap(const Eigen::Vector3d& point_sensor, const std::array<double, 6>& sensor = kSensor)
{
  const Eigen::Vector3d point_robot =
      rotationOf(sensor) * point_sensor + Eigen::Vector3d(sensor[0], sensor[1], sensor[2]);
  return rotationOf(kRobot) * point_robot + Eigen::Vector3d(kRobot[0], kRobot[1], kRobot[2]);
}

Eigen::Vector3d directionInMap(const Eigen::Vector3d& direction,
                               const std::array<double, 6>& sensor = kSensor)
{
  return rotationOf(kRobot) * rotationOf(sensor) * direction;
}

void expectNear(const Eigen::Vector3d& actual, const Eigen::Vector3d& expected, double tolerance = 1e-9)
{
  EXPECT_LT((actual - expected).norm(), tolerance)
      << actual.transpose() << " instead of " << expected.transpose();
}

/// A fan whose rays are turned into the map's frame.
struct FanInMap
{
  FanInMap(const Scan& scan, const lamap::RayFan& fan)
      : centre(scan.inMap(fan.centre)),
        statedRangeMin_m(fan.statedRangeMin_m),
        statedRangeMax_m(fan.statedRangeMax_m),
        rays(fan.rays)
  {
    for (const lamap::Ray& ray : fan.rays)
    {
      if (ray.meaning == lamap::RayEnd::Return)
        returns.push_back(scan.inMap(ray.end));
      else if (ray.meaning == lamap::RayEnd::NoReturn)
        noReturns.push_back(scan.turnedToMap(ray.end));
    }
  }
  [[nodiscard]] std::size_t countOf(lamap::RayEnd meaning) const
  {
    return static_cast<std::size_t>(std::count_if(
        rays.begin(), rays.end(), [&](const lamap::Ray& ray) { return ray.meaning == meaning; }));
  }

  Eigen::Vector3d centre;
  std::vector<Eigen::Vector3d> returns;
  std::vector<Eigen::Vector3d> noReturns;  ///< their directions
  double statedRangeMin_m;
  double statedRangeMax_m;
  std::vector<lamap::Ray> rays;  ///< as they are
};

/// The only fan of an observation seen from kRobot.
FanInMap onlyFan(const mrpt::obs::CObservation& observation)
{
  EXPECT_TRUE(supportsObservation(observation));
  const std::optional<Scan> scan = raysOf(observation, poseOf(kRobot));
  EXPECT_TRUE(scan.has_value());
  EXPECT_EQ(scan->fans.size(), 1u);
  return {*scan, scan->fans.at(0)};
}

std::string messageOf(const mrpt::obs::CObservation& observation)
{
  try
  {
    static_cast<void>(raysOf(observation, CPose3D()));
  }
  catch (const std::runtime_error& error)
  {
    return error.what();
  }
  return "no error";
}

/// A folder of its own for externally stored data, where MRPT looks for it.
class ExternalFolder
{
 public:
  ExternalFolder() : path_(std::filesystem::path(::testing::TempDir()) / "lamap_external_XXXXXX")
  {
    std::string name = path_.string();
    if (!mkdtemp(name.data())) throw std::runtime_error("no temporary folder");
    path_ = name;
    before_ = mrpt::io::getLazyLoadPathBase();
    mrpt::io::setLazyLoadPathBase(path_.string());
  }
  ~ExternalFolder()
  {
    mrpt::io::setLazyLoadPathBase(before_);
    std::filesystem::remove_all(path_);
  }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  std::string before_;
};

const std::filesystem::path kDatasets = "/usr/share/mrpt/datasets";

/// The first observation of a class in one of MRPT's own logs; null where they are not installed.
template <typename Observation>
typename Observation::Ptr firstOf(const std::string& log)
{
  if (!std::filesystem::exists(kDatasets / log)) return nullptr;
  mrpt::obs::CRawlog rawlog;
  if (!rawlog.loadFromRawLogFile((kDatasets / log).string())) return nullptr;
  for (std::size_t i = 0; i < rawlog.size(); ++i)
  {
    const auto entry = rawlog.getAsGeneric(i);
    if (auto found = std::dynamic_pointer_cast<Observation>(entry)) return found;
    if (const auto frame = std::dynamic_pointer_cast<mrpt::obs::CSensoryFrame>(entry))
      if (auto found = frame->getObservationByClass<Observation>()) return found;
  }
  return nullptr;
}

CObservation2DRangeScan scanOf(const std::vector<float>& ranges)
{
  CObservation2DRangeScan scan;
  scan.aperture = static_cast<float>(M_PI);
  scan.maxRange = 20;
  scan.sensorPose = poseOf(kSensor);
  scan.resizeScanAndAssign(ranges.size(), 0, true);
  for (std::size_t i = 0; i < ranges.size(); ++i) scan.setScanRange(i, ranges[i]);
  return scan;
}

// ---------------------------------------------------------------------------------------
// CObservation2DRangeScan

TEST(RaysOf2DRangeScan, EndPointsAreComposedOfRobotAndSensorPose)
{
  const auto fan = onlyFan(scanOf({2, 3, 4}));
  expectNear(fan.centre, inMap({0, 0, 0}));
  ASSERT_EQ(fan.returns.size(), 3u);
  expectNear(fan.returns[0], inMap({0, -2, 0}), 1e-6);  // the aperture is a float
  expectNear(fan.returns[1], inMap({3, 0, 0}));
  expectNear(fan.returns[2], inMap({0, 4, 0}), 1e-6);
  EXPECT_TRUE(fan.noReturns.empty());
  EXPECT_EQ(fan.statedRangeMin_m, 0);
  EXPECT_EQ(fan.statedRangeMax_m, 20);
}

TEST(RaysOf2DRangeScan, ScansFromLeftToRightWhereItSaysSo)
{
  auto scan = scanOf({2, 3, 4});
  scan.rightToLeft = false;
  const auto fan = onlyFan(scan);
  ASSERT_EQ(fan.returns.size(), 3u);
  expectNear(fan.returns[0], inMap({0, 2, 0}), 1e-6);
  expectNear(fan.returns[2], inMap({0, -4, 0}), 1e-6);
}

TEST(RaysOf2DRangeScan, SpreadsTheApertureOverAllRays)
{
  auto scan = scanOf({1, 1, 1, 1, 1});
  scan.aperture = 2.0f;
  const auto fan = onlyFan(scan);
  ASSERT_EQ(fan.returns.size(), 5u);
  for (int i = 0; i < 5; ++i)
    expectNear(fan.returns[static_cast<std::size_t>(i)],
               inMap({std::cos(-1 + 0.5 * i), std::sin(-1 + 0.5 * i), 0}), 1e-7);
}

TEST(RaysOf2DRangeScan, SingleRayPointsForward)
{
  const auto fan = onlyFan(scanOf({5}));
  ASSERT_EQ(fan.returns.size(), 1u);
  expectNear(fan.returns[0], inMap({5, 0, 0}));
}

TEST(RaysOf2DRangeScan, PitchSweepsFromStartToEnd)
{
  auto scan = scanOf({1, 2, 3});
  scan.deltaPitch = 0.4;
  const auto fan = onlyFan(scan);
  ASSERT_EQ(fan.returns.size(), 3u);
  auto middle = kSensor;
  middle[4] += 0.2;
  auto end = kSensor;
  end[4] += 0.4;
  expectNear(fan.returns[0], inMap({0, -1, 0}), 1e-6);
  expectNear(fan.returns[1], inMap({2, 0, 0}, middle), 1e-9);
  expectNear(fan.returns[2], inMap({0, 3, 0}, end), 1e-6);
}

TEST(RaysOf2DRangeScan, TellsNoReturnFromRejectedAndUnusable)
{
  using lamap::RayEnd;
  struct Reading
  {
    float range_m;
    bool isValid;
    RayEnd due;
  };
  const float inf = std::numeric_limits<float>::infinity();
  const std::vector<Reading> readings{
      {kNaN, true, RayEnd::Dropped},   {0, true, RayEnd::Dropped},     {20, true, RayEnd::NoReturn},
      {1e30F, true, RayEnd::NoReturn}, {inf, true, RayEnd::NoReturn},  {-inf, true, RayEnd::TooNear},
      {-1, true, RayEnd::Dropped},     {7, true, RayEnd::Return},      {20, false, RayEnd::NoReturn},
      {inf, false, RayEnd::NoReturn},  {-inf, false, RayEnd::TooNear}, {0, false, RayEnd::NoReturn},
      {7, false, RayEnd::Dropped},     {kNaN, false, RayEnd::Dropped}};
  std::vector<float> ranges_m;
  for (const Reading& reading : readings) ranges_m.push_back(reading.range_m);
  auto scan = scanOf(ranges_m);
  scan.aperture = 0;  // all forward
  for (std::size_t i = 0; i < readings.size(); ++i) scan.setScanRangeValidity(i, readings[i].isValid);
  const auto fan = onlyFan(scan);
  ASSERT_EQ(fan.rays.size(), readings.size());  // in the order of the sensor
  for (std::size_t i = 0; i < readings.size(); ++i)
  {
    EXPECT_EQ(fan.rays[i].meaning, readings[i].due) << i;
    if (readings[i].due != RayEnd::Return) expectNear(fan.rays[i].end, {1, 0, 0});
  }
  EXPECT_EQ(fan.returns.size(), 1u);
  for (const auto& direction : fan.noReturns) expectNear(direction, directionInMap({1, 0, 0}));
}

TEST(RaysOf2DRangeScan, AgreesWithMrptsOwnPointsOfARealScan)
{
  const auto scan =
      firstOf<CObservation2DRangeScan>("2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog");
  if (!scan) GTEST_SKIP() << "needs " << kDatasets << " (Debian package mrpt-common)";
  const auto fan = onlyFan(*scan);

  mrpt::maps::CSimplePointsMap points;
  points.insertionOptions.minDistBetweenLaserPoints = 0;
  points.insertionOptions.also_interpolate = false;
  const CPose3D robot = poseOf(kRobot);
  points.loadFromRangeScan(*scan, robot);
  ASSERT_EQ(fan.returns.size(), points.size());
  ASSERT_GT(points.size(), 200u);
  for (std::size_t i = 0; i < points.size(); ++i)
  {
    double x = 0;
    double y = 0;
    double z = 0;
    points.getPoint(i, x, y, z);
    expectNear(fan.returns[i], {x, y, z}, 1e-4);
  }
  EXPECT_EQ(fan.returns.size() + fan.noReturns.size(), scan->getScanSize());
}

// ---------------------------------------------------------------------------------------
// CObservation3DRangeScan

/// 2 rows × 3 columns; the principal point in the pixel of row 1, column 1.
CObservation3DRangeScan depthImage()
{
  CObservation3DRangeScan scan;
  scan.sensorPose = poseOf(kSensor);
  scan.maxRange = 6;
  scan.hasRangeImage = true;
  scan.rangeImage_setSize(2, 3);
  scan.rangeImage.fill(0);
  scan.rangeUnits = 0.002f;
  scan.cameraParams.ncols = 3;
  scan.cameraParams.nrows = 2;
  scan.cameraParams.fx(2);
  scan.cameraParams.fy(4);
  scan.cameraParams.cx(1);
  scan.cameraParams.cy(1);
  scan.rangeImage(1, 1) = 1500;  // 3 m
  scan.rangeImage(0, 2) = 2000;  // 4 m
  return scan;
}

TEST(RaysOf3DRangeScan, DepthsAreComposedOfRobotAndSensorPose)
{
  const auto fan = onlyFan(depthImage());
  expectNear(fan.centre, inMap({0, 0, 0}));
  ASSERT_EQ(fan.returns.size(), 2u);
  // y = (cx − c)/fx · depth, z = (cy − r)/fy · depth
  expectNear(fan.returns[0], inMap({4, -2, 1}), 1e-6);
  expectNear(fan.returns[1], inMap({3, 0, 0}), 1e-6);
  EXPECT_EQ(fan.statedRangeMax_m, 6);
}

TEST(RaysOf3DRangeScan, RangesAreAlongTheRayWhereTheyAreNotDepths)
{
  auto scan = depthImage();
  scan.range_is_depth = false;
  const auto fan = onlyFan(scan);
  ASSERT_EQ(fan.returns.size(), 2u);
  expectNear(fan.returns[0], inMap(4 * Eigen::Vector3d(4, -2, 1).normalized()), 1e-6);
}

TEST(RaysOf3DRangeScan, PixelsWithoutDepthAreUnknownNotFree)
{
  const auto fan = onlyFan(depthImage());
  EXPECT_EQ(fan.returns.size(), 2u);
  EXPECT_TRUE(fan.noReturns.empty());
  ASSERT_EQ(fan.rays.size(), 6u);  // row by row
  EXPECT_EQ(fan.countOf(lamap::RayEnd::Dropped), 4u);
  EXPECT_EQ(fan.rays[2].meaning, lamap::RayEnd::Return);
  expectNear(fan.rays[0].end, {1, 0.5, 0.25}, 1e-6);
}

TEST(RaysOf3DRangeScan, TakesPointsWhereThereIsNoImage)
{
  CObservation3DRangeScan scan;
  scan.sensorPose = poseOf(kSensor);
  scan.hasPoints3D = true;
  scan.points3D_x = {1, 0, kNaN};
  scan.points3D_y = {2, 0, 1};
  scan.points3D_z = {3, 0, 1};
  const auto fan = onlyFan(scan);
  ASSERT_EQ(fan.returns.size(), 2u);  // (0,0,0) is MRPT's mark of an invalid point
  expectNear(fan.returns[0], inMap({1, 2, 3}));
  EXPECT_TRUE(fan.returns[1].hasNaN());

  scan.points3D_z.pop_back();
  EXPECT_NE(messageOf(scan).find("3 x, 3 y and 2 z coordinates"), std::string::npos) << messageOf(scan);
}

TEST(RaysOf3DRangeScan, TakesPointsWhereTheImageHoldsNoReading)
{
  auto scan = depthImage();
  scan.hasPoints3D = true;
  scan.points3D_x = {1};
  scan.points3D_y = {2};
  scan.points3D_z = {3};
  EXPECT_EQ(onlyFan(scan).returns.size(), 2u) << "those of the image";
  const auto takesPoints = [](const CObservation3DRangeScan& frame)
  {
    const auto fan = onlyFan(frame);
    ASSERT_EQ(fan.returns.size(), 1u);
    expectNear(fan.returns[0], inMap({1, 2, 3}));
  };
  for (const float unit_m : {0.f, -1.f, std::numeric_limits<float>::quiet_NaN()})
  {
    auto withoutUnits = scan;
    withoutUnits.rangeUnits = unit_m;
    takesPoints(withoutUnits);
  }
  auto uncalibrated = scan;
  uncalibrated.cameraParams.fx(0);
  takesPoints(uncalibrated);
  scan.rangeImage.fill(0);
  takesPoints(scan);
  scan.hasPoints3D = false;
  EXPECT_EQ(onlyFan(scan).returns.size(), 0u);
  EXPECT_EQ(onlyFan(scan).rays.size(), 6u) << "pixels of which nothing is known";
}

TEST(RaysOf3DRangeScan, NeedsACalibrationForAnImageAlone)
{
  auto scan = depthImage();
  scan.sensorLabel = "kinect";
  scan.cameraParams.fx(0);
  EXPECT_NE(messageOf(scan).find("'kinect'"), std::string::npos) << messageOf(scan);
  EXPECT_NE(messageOf(scan).find("focal lengths"), std::string::npos) << messageOf(scan);

  scan.hasPoints3D = true;
  scan.points3D_x = scan.points3D_y = scan.points3D_z = {1};
  EXPECT_EQ(onlyFan(scan).returns.size(), 1u);
}

TEST(RaysOf3DRangeScan, FollowsTheLastCameraOfSeveral)
{
  auto other = depthImage();
  other.cameraParams.fx(1);
  expectNear(onlyFan(depthImage()).returns[0], inMap({4, -2, 1}), 1e-6);
  expectNear(onlyFan(other).returns[0], inMap({4, -4, 1}), 1e-6);
  expectNear(onlyFan(depthImage()).returns[0], inMap({4, -2, 1}), 1e-6);
}

TEST(RaysOf3DRangeScan, LoadsExternalDataAndLetsItGoAgain)
{
  const ExternalFolder folder;
  auto scan = depthImage();
  scan.rangeImage_convertToExternalStorage("depth", folder.path().string());
  ASSERT_EQ(scan.rangeImage.size(), 0);
  auto fan = onlyFan(scan);
  ASSERT_EQ(fan.returns.size(), 2u);
  expectNear(fan.returns[0], inMap({4, -2, 1}), 1e-6);
  EXPECT_EQ(scan.rangeImage.size(), 0);

  CObservation3DRangeScan points;
  points.sensorPose = poseOf(kSensor);
  points.hasPoints3D = true;
  points.resizePoints3DVectors(1);
  points.points3D_x = {1};
  points.points3D_y = {2};
  points.points3D_z = {3};
  points.points3D_convertToExternalStorage("points", folder.path().string());
  fan = onlyFan(points);
  ASSERT_EQ(fan.returns.size(), 1u);
  expectNear(fan.returns[0], inMap({1, 2, 3}));
  EXPECT_TRUE(points.points3D_x.empty());

  points.load();
  static_cast<void>(onlyFan(points));
  EXPECT_EQ(points.points3D_x.size(), 1u) << "what was in memory before stays there";
}

TEST(RaysOf3DRangeScan, NamesTheExternalFileThatIsMissing)
{
  const ExternalFolder folder;
  auto scan = depthImage();
  scan.sensorLabel = "kinect";
  scan.rangeImage_convertToExternalStorage("depth", folder.path().string());
  std::filesystem::remove(folder.path() / "depth.bin");
  EXPECT_NE(messageOf(scan).find("depth.bin"), std::string::npos) << messageOf(scan);
  EXPECT_NE(messageOf(scan).find("'kinect'"), std::string::npos) << messageOf(scan);
}

TEST(RaysOf3DRangeScan, AgreesWithMrptsOwnPointsOfARealImage)
{
  const auto scan = firstOf<CObservation3DRangeScan>("tests_rgbd.rawlog");
  if (!scan) GTEST_SKIP() << "needs " << kDatasets << " (Debian package mrpt-common)";
  ASSERT_NE(scan->cameraParams.dist[0], 0) << "the image is worth testing for its distortion";
  scan->sensorPose = poseOf(kSensor);
  const CObservation3DRangeScan before = *scan;
  const auto fan = onlyFan(*scan);
  EXPECT_EQ(scan->rangeImage, before.rangeImage);
  EXPECT_EQ(scan->points3D_x, before.points3D_x);

  mrpt::maps::CSimplePointsMap points;
  mrpt::obs::T3DPointsProjectionParams parameters;
  parameters.takeIntoAccountSensorPoseOnRobot = true;
  const CPose3D robot = poseOf(kRobot);
  parameters.robotPoseInTheWorld = robot;
  scan->unprojectInto(points, parameters);
  ASSERT_GT(points.size(), 200000u);
  ASSERT_EQ(fan.returns.size(), points.size());
  double farthest = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
  {
    double x = 0;
    double y = 0;
    double z = 0;
    points.getPoint(i, x, y, z);
    farthest = std::max(farthest, (fan.returns[i] - Eigen::Vector3d(x, y, z)).norm());
  }
  EXPECT_LT(farthest, 1e-4);
}

// ----------------------------------------------------------------------------------------
// CObservationPointCloud

CObservationPointCloud pointCloud()
{
  CObservationPointCloud cloud;
  cloud.sensorPose = poseOf(kSensor);
  const auto points = mrpt::maps::CSimplePointsMap::Create();
  points->insertPoint(1, 2, 3);
  points->insertPoint(100, -50, 7);
  cloud.pointcloud = points;
  return cloud;
}

TEST(RaysOfPointCloud, PointsAreComposedOfRobotAndSensorPose)
{
  const auto fan = onlyFan(pointCloud());
  expectNear(fan.centre, inMap({0, 0, 0}));
  ASSERT_EQ(fan.returns.size(), 2u);
  expectNear(fan.returns[0], inMap({1, 2, 3}));
  expectNear(fan.returns[1], inMap({100, -50, 7}));
  EXPECT_EQ(fan.statedRangeMin_m, 0);
  EXPECT_EQ(fan.statedRangeMax_m, 0);
}

TEST(RaysOfPointCloud, KeepsUnusablePointsToBeCounted)
{
  auto cloud = pointCloud();
  cloud.pointcloud->insertPoint(kNaN, 0, 0);
  const auto fan = onlyFan(cloud);
  ASSERT_EQ(fan.returns.size(), 3u);
  EXPECT_TRUE(fan.returns[2].hasNaN());
}

TEST(RaysOfPointCloud, WithoutCloudHasNoRays)
{
  const auto fan = onlyFan(CObservationPointCloud());
  EXPECT_TRUE(fan.returns.empty());
}

TEST(RaysOfPointCloud, LoadsExternalDataAndLetsItGoAgain)
{
  const ExternalFolder folder;
  auto cloud = pointCloud();
  cloud.setAsExternalStorage("cloud.bin", CObservationPointCloud::ExternalStorageFormat::MRPT_Serialization);
  cloud.unload();  // writes it
  ASSERT_FALSE(cloud.pointcloud);
  const auto fan = onlyFan(cloud);
  ASSERT_EQ(fan.returns.size(), 2u);
  expectNear(fan.returns[0], inMap({1, 2, 3}));
  EXPECT_FALSE(cloud.pointcloud);

  cloud.load();
  static_cast<void>(onlyFan(cloud));
  EXPECT_TRUE(cloud.pointcloud) << "what was in memory before stays there";
  cloud.unload();

  std::filesystem::remove(folder.path() / "cloud.bin");
  EXPECT_NE(messageOf(cloud).find("cloud.bin"), std::string::npos) << messageOf(cloud);
}

// --------------------------------------------------------------------------------------
// CObservationVelodyneScan

TEST(RaysOfVelodyneScan, PointsAreComposedOfRobotAndSensorPose)
{
  CObservationVelodyneScan velodyne;
  velodyne.sensorPose = poseOf(kSensor);
  velodyne.minRange = 0.5;
  velodyne.maxRange = 70;
  velodyne.point_cloud.x = {1, 4};
  velodyne.point_cloud.y = {2, 5};
  velodyne.point_cloud.z = {3, 6};
  const auto fan = onlyFan(velodyne);
  expectNear(fan.centre, inMap({0, 0, 0}));
  ASSERT_EQ(fan.returns.size(), 2u);
  expectNear(fan.returns[0], inMap({1, 2, 3}));
  expectNear(fan.returns[1], inMap({4, 5, 6}));
  EXPECT_EQ(fan.statedRangeMin_m, 0.5);
  EXPECT_EQ(fan.statedRangeMax_m, 70);
}

/// One VLP-16 packet, all blocks at azimuth 90° clockwise (to the right); only laser 1 of block 0 sees
/// something.
CObservationVelodyneScan onePacket(uint16_t distance_2mm)
{
  CObservationVelodyneScan velodyne;
  velodyne.sensorPose = poseOf(kSensor);
  velodyne.calibration = mrpt::obs::VelodyneCalibration::LoadDefaultCalibration("VLP16");
  CObservationVelodyneScan::TVelodyneRawPacket packet;
  std::memset(static_cast<void*>(&packet), 0, sizeof packet);
  auto* bytes = reinterpret_cast<uint8_t*>(&packet);
  for (int block = 0; block < CObservationVelodyneScan::BLOCKS_PER_PACKET; ++block)
  {
    uint8_t* first = bytes + block * CObservationVelodyneScan::SIZE_BLOCK;
    first[0] = 0xff;  // upper bank, 0xeeff
    first[1] = 0xee;
    first[2] = 9000 & 0xff;
    first[3] = 9000 >> 8;
  }
  bytes[4 + 3] = static_cast<uint8_t>(distance_2mm & 0xff);  // laser 1: 1° above the horizon
  bytes[4 + 4] = static_cast<uint8_t>(distance_2mm >> 8);
  packet.laser_return_mode = CObservationVelodyneScan::RETMODE_STRONGEST;
  packet.velodyne_model_ID = 0x22;
  velodyne.scan_packets.push_back(packet);
  return velodyne;
}

TEST(RaysOfVelodyneScan, ReadsPacketsWhereNoPointsWereGenerated)
{
  const auto velodyne = onePacket(5000);
  const auto fan = onlyFan(velodyne);
  ASSERT_EQ(fan.returns.size(), 1u);
  const double elevation = M_PI / 180;
  // MRPT's table of azimuths is off by up to 0.01°.
  expectNear(fan.returns[0], inMap({0, -10 * std::cos(elevation), 10 * std::sin(elevation)}), 2e-3);
  EXPECT_EQ(velodyne.point_cloud.size(), 0u) << "the observation stays as it was";
}

TEST(RaysOfVelodyneScan, KeepsReturnsFromTheLeastRangeThatItStates)
{
  auto velodyne = onePacket(300);  // 0.6 m, below MRPT's default of 1 m
  velodyne.minRange = 0.5;
  EXPECT_EQ(onlyFan(velodyne).returns.size(), 1u);
}

TEST(RaysOfVelodyneScan, UnknownCalibrationIsNamed)
{
  auto velodyne = onePacket(5000);
  velodyne.sensorLabel = "roof";
  velodyne.calibration.clear();
  EXPECT_NE(messageOf(velodyne).find("'roof'"), std::string::npos) << messageOf(velodyne);
}

TEST(RaysOfVelodyneScan, ReadsARealScan)
{
  const auto velodyne = firstOf<CObservationVelodyneScan>("test_velodyne_VLP16.rawlog");
  if (!velodyne) GTEST_SKIP() << "needs " << kDatasets << " (Debian package mrpt-common)";
  velodyne->sensorPose = poseOf(kSensor);
  const auto fan = onlyFan(*velodyne);
  velodyne->generatePointCloud();
  const auto& points = velodyne->point_cloud;
  ASSERT_GT(points.size(), 10000u);
  ASSERT_EQ(fan.returns.size(), points.size());
  for (std::size_t i = 0; i < points.size(); i += 100)
    expectNear(fan.returns[i], inMap({points.x[i], points.y[i], points.z[i]}));
}

// --------------------------------------------------------------------------------------
// CObservationRotatingScan

CObservationRotatingScan rotatingScan(int rows, int columns)
{
  CObservationRotatingScan rotating;
  rotating.sensorPose = poseOf(kSensor);
  rotating.rowCount = static_cast<uint16_t>(rows);
  rotating.columnCount = static_cast<uint16_t>(columns);
  rotating.rangeImage.setZero(rows, columns);
  rotating.rangeResolution = 0.01;
  rotating.minRange = 0.5;
  rotating.maxRange = 90;
  return rotating;
}

TEST(RaysOfRotatingScan, SingleRowIsComposedOfRobotAndSensorPose)
{
  auto rotating = rotatingScan(1, 4);
  rotating.startAzimuth = M_PI / 2;
  rotating.azimuthSpan = -1.5 * M_PI;  // clockwise: left, front, right, back
  rotating.rangeImage(0, 0) = 200;
  rotating.rangeImage(0, 2) = 300;
  rotating.rangeImage(0, 3) = 400;
  const auto fan = onlyFan(rotating);
  expectNear(fan.centre, inMap({0, 0, 0}));
  ASSERT_EQ(fan.returns.size(), 3u);
  expectNear(fan.returns[0], inMap({0, 2, 0}));
  expectNear(fan.returns[1], inMap({0, -3, 0}));
  expectNear(fan.returns[2], inMap({-4, 0, 0}));
  ASSERT_EQ(fan.noReturns.size(), 1u);
  expectNear(fan.noReturns[0], directionInMap({1, 0, 0}));
  EXPECT_EQ(fan.statedRangeMin_m, 0.5);
  EXPECT_EQ(fan.statedRangeMax_m, 90);
}

TEST(RaysOfRotatingScan, VelodyneRowsHaveTheirElevations)
{
  auto rotating = rotatingScan(16, 5);  // columns at 0°, 90°, 180°, 270°, 360°, counter-clockwise
  rotating.lidarModel = "VLP-16";
  rotating.startAzimuth = 0;
  rotating.azimuthSpan = 2 * M_PI;
  rotating.rangeImage(0, 1) = 1000;  // laser 0: 15° below the horizon
  rotating.rangeImage(1, 1) = 1000;  // laser 1: 1° above
  const auto fan = onlyFan(rotating);
  ASSERT_EQ(fan.returns.size(), 2u);
  const double degree = M_PI / 180;
  expectNear(fan.returns[0], inMap({0, 10 * std::cos(15 * degree), -10 * std::sin(15 * degree)}), 1e-6);
  expectNear(fan.returns[1], inMap({0, 10 * std::cos(degree), 10 * std::sin(degree)}), 1e-6);
  EXPECT_EQ(fan.noReturns.size(), 16u * 5u - 2u);
}

TEST(RaysOfRotatingScan, ReadsColumnsAsFromVelodyneFillsThem)
{
  auto rotating = rotatingScan(16, 384);  // one packet: 24 columns of 384 are used
  rotating.lidarModel = "VLP-16";
  rotating.startAzimuth = 0;
  rotating.azimuthSpan = 2 * M_PI;
  rotating.rangeImage(1, 6) = 1000;  // a quarter of the way, clockwise: to the right
  const auto fan = onlyFan(rotating);
  ASSERT_EQ(fan.returns.size(), 1u);
  const double degree = M_PI / 180;
  expectNear(fan.returns[0], inMap({0, -10 * std::cos(degree), 10 * std::sin(degree)}), 1e-6);
  EXPECT_EQ(fan.noReturns.size(), 15u) << "columns without any return were not measured";
}

TEST(RaysOfRotatingScan, RowsOfAnUnknownModelAreNotGuessed)
{
  auto rotating = rotatingScan(8, 5);
  rotating.lidarModel = "OS1-8";
  EXPECT_FALSE(supportsObservation(rotating));
  EXPECT_FALSE(raysOf(rotating, CPose3D()).has_value());

  auto wrongRows = rotatingScan(8, 5);
  wrongRows.lidarModel = "VLP-16";
  EXPECT_FALSE(supportsObservation(wrongRows));

  auto contradicting = rotatingScan(1, 5);
  contradicting.rangeImage.setZero(3, 5);
  EXPECT_NE(messageOf(contradicting).find("3 rows"), std::string::npos) << messageOf(contradicting);
}

TEST(RaysOfRotatingScan, RealVelodyneImageMeetsThePointsOfItsPackets)
{
  const auto rotating = firstOf<CObservationRotatingScan>("rot_scan_velodyne.rawlog");
  const auto velodyne = firstOf<CObservationVelodyneScan>("test_velodyne_VLP16.rawlog");
  if (!rotating || !velodyne)
    GTEST_SKIP() << "needs " << kDatasets << " (Debian package mrpt-common, MRPT 2.5)";
  rotating->sensorPose = velodyne->sensorPose = poseOf(kSensor);
  const auto image = onlyFan(*rotating);
  const auto packets = onlyFan(*velodyne);
  ASSERT_EQ(image.returns.size(), packets.returns.size());

  // Both hold the firings in order, but for the order within a firing. The image forgets that the lasers of a
  // firing fire one after the other: 0.13° of a turn at most, and 0.2° more where the speed of turning
  // varies.
  std::size_t unmatched = 0;
  for (std::size_t i = 0; i < image.returns.size(); ++i)
  {
    const double range = (image.returns[i] - image.centre).norm();
    double nearest = std::numeric_limits<double>::max();
    for (std::size_t j = i < 100 ? 0 : i - 100; j < std::min(i + 100, packets.returns.size()); ++j)
      nearest = std::min(nearest, (image.returns[i] - packets.returns[j]).norm());
    if (nearest > range * 0.33 * M_PI / 180) ++unmatched;
  }
  EXPECT_EQ(unmatched, 0u) << "of " << image.returns.size();
}

TEST(RaysOfRotatingScan, ReadsARealSingleRow)
{
  const auto rotating = firstOf<CObservationRotatingScan>("rot_scan_2d.rawlog");
  if (!rotating) GTEST_SKIP() << "needs " << kDatasets << " (Debian package mrpt-common, MRPT 2.5)";
  rotating->sensorPose = poseOf(kSensor);
  const auto fan = onlyFan(*rotating);
  EXPECT_EQ(fan.returns.size(), 359u);
  EXPECT_EQ(fan.noReturns.size(), 2u);
  // 361 rays over 180°: the middle one looks forward.
  ASSERT_NE(rotating->rangeImage(0, 180), 0);
  const Eigen::Vector3d forward = inMap({rotating->rangeImage(0, 180) * 0.01, 0, 0});
  double nearest = std::numeric_limits<double>::max();
  for (const auto& point : fan.returns) nearest = std::min(nearest, (point - forward).norm());
  EXPECT_LT(nearest, 1e-9);
}

// ---------------------------------------------------------------------------------------------
// CObservationRange

TEST(RaysOfRange, EachMeasurementIsAFanFromItsOwnSensorPose)
{
  CObservationRange ranges;
  ranges.minSensorDistance = 0.25f;
  ranges.maxSensorDistance = 4;
  const std::array<double, 6> other = {-0.3, 0.1, 0.2, 2.0, -0.1, 0.4};
  const auto add = [&](const std::array<double, 6>& pose, float distance)
  {
    CObservationRange::TMeasurement measurement;
    measurement.sensorPose = mrpt::math::TPose3D(pose[0], pose[1], pose[2], pose[3], pose[4], pose[5]);
    measurement.sensedDistance = distance;
    ranges.sensedData.push_back(measurement);
  };
  add(kSensor, 2.5f);
  add(other, 1.5f);
  add(kSensor, 0);
  add(other, 4);
  add(other, -1);
  add(other, kNaN);
  add(kSensor, 0.125f);

  EXPECT_TRUE(supportsObservation(ranges));
  const auto scan = raysOf(ranges, poseOf(kRobot));
  ASSERT_TRUE(scan.has_value());
  ASSERT_EQ(scan->fans.size(), 7u);
  std::vector<FanInMap> fans;
  for (const lamap::RayFan& fan : scan->fans) fans.emplace_back(*scan, fan);
  expectNear(scan->sensorPose_map.translation(), inMap({0, 0, 0}));
  expectNear(fans[0].centre, inMap({0, 0, 0}));
  expectNear(fans[1].centre, inMap({0, 0, 0}, other));
  ASSERT_EQ(fans[0].returns.size(), 1u);
  expectNear(fans[0].returns[0], inMap({2.5, 0, 0}));
  ASSERT_EQ(fans[1].returns.size(), 1u);
  expectNear(fans[1].returns[0], inMap({1.5, 0, 0}, other));
  for (const std::size_t noEcho : {2u, 3u}) ASSERT_EQ(fans[noEcho].noReturns.size(), 1u);
  expectNear(fans[2].noReturns[0], directionInMap({1, 0, 0}));
  expectNear(fans[3].noReturns[0], directionInMap({1, 0, 0}, other));
  for (const std::size_t unknown : {4u, 5u})  // negative, NaN
    EXPECT_EQ(fans[unknown].countOf(lamap::RayEnd::Dropped), 1u) << unknown;
  EXPECT_EQ(fans[6].countOf(lamap::RayEnd::TooNear), 1u);
  EXPECT_EQ(fans[0].statedRangeMin_m, 0.25);
  EXPECT_EQ(fans[0].statedRangeMax_m, 4);
  EXPECT_NEAR(scan->fans[0].beam.halfWidth_rad, 0.5 * lamap::compat::coneApertureOf(ranges), 1e-9);
  EXPECT_EQ(scan->fans[0].beam.halfHeight_rad, scan->fans[0].beam.halfWidth_rad);
  EXPECT_GT(scan->fans[0].beam.halfWidth_rad, 0);
}

// ------------------------------------------------------------------------------------------------------
// beams and echoes

TEST(RaysOfWideBeams, HaveTheApertureThatIsStated)
{
  const auto halfWidthOf = [](double aperture_rad)
  {
    auto scan2D = scanOf({2});
    scan2D.beamAperture = static_cast<float>(aperture_rad);
    const lamap::Beam beam = raysOf(scan2D, CPose3D())->fans.at(0).beam;
    EXPECT_EQ(beam.halfHeight_rad, beam.halfWidth_rad);

    mrpt::obs::CObservationRange ranges;
    lamap::compat::setConeAperture(ranges, aperture_rad);
    ranges.sensedData.emplace_back().sensedDistance = 2;
    EXPECT_EQ(raysOf(ranges, CPose3D())->fans.at(0).beam, beam);
    return beam.halfWidth_rad;
  };
  EXPECT_NEAR(halfWidthOf(0.25), 0.125, 1e-9);
  EXPECT_NEAR(halfWidthOf(3.1), 1.55, 1e-7);
  for (const double none : {0.0, -0.25, M_PI, 7.0, static_cast<double>(kNaN)})
    EXPECT_EQ(halfWidthOf(none), 0) << none;
}

TEST(RaysOfLaterEchoes, AreKnownByTheirLabel)
{
  const auto echoOf = [](const std::string& label)
  {
    auto scan = scanOf({2});
    scan.sensorLabel = label;
    return static_cast<int>(raysOf(scan, CPose3D())->fans.at(0).rays.at(0).echo);
  };
  EXPECT_EQ(echoOf("SONAR/echo1"), 0);
  EXPECT_EQ(echoOf("SONAR/echo2"), 1);
  EXPECT_EQ(echoOf("bow/echo1/echo12"), 11);
  EXPECT_EQ(echoOf("SONAR/echo256"), 255);
  EXPECT_EQ(echoOf("SONAR/echo99999999999"), 255);
  for (const char* first : {"", "SONAR", "/echo", "SONAR/echo0", "SONAR/echo-1", "SONAR/echo2b", "echo2"})
    EXPECT_EQ(echoOf(first), 0) << first;
}

// ------------------------------------------------------------------------------------------------------
// anything

TEST(RaysOf, NothingForOtherObservations)
{
  const mrpt::obs::CObservationOdometry odometry;
  EXPECT_FALSE(supportsObservation(odometry));
  EXPECT_FALSE(raysOf(odometry, CPose3D()).has_value());
}

TEST(RaysOf, HoldsMillimetresAThousandKilometresAway)
{
  auto cloud = pointCloud();
  cloud.sensorPose = CPose3D();
  const auto scan = raysOf(cloud, CPose3D(1e6, 0, 0, 0, 0, 0));
  expectNear(scan->inMap(scan->fans[0].rays[0].end), {1e6 + 1, 2, 3}, 1e-9);
}

}  // namespace
