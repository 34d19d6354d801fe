#include <lamap_tools/simulate/simulated_log.h>

#include <lamap_mrpt/compat/mrpt_compat.h>
#include <lamap_tools/files/file_output.h>
#include <mrpt/core/Clock.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CActionRobotMovement3D.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRange.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>
#include <mrpt/serialization/CArchive.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string_view>
#include <type_traits>

namespace lamap::tools
{
namespace
{
using mrpt::obs::CObservation;
using mrpt::poses::CPose3D;
using sim::Pose;
using sim::SensorKind;

/// MRPT's archive over a file that detects every write error.
class FileArchive : public mrpt::serialization::CArchive
{
 public:
  explicit FileArchive(FileOutput& file) : file_(file) {}
  [[nodiscard]] std::string getArchiveDescription() const override { return "simulated log"; }

 protected:
  size_t write(const void* bytes, size_t count) override
  {
    file_.append(std::string_view(static_cast<const char*>(bytes), count));
    return count;
  }
  size_t read(void*, size_t) override { throw std::logic_error("opened for writing"); }

 private:
  FileOutput& file_;
};

CPose3D mrptPose(const Pose& pose)
{
  const Eigen::Vector3d& p = pose.position_map;
  return CPose3D(p.x(), p.y(), p.z(), pose.yaw_rad, pose.pitch_rad, pose.roll_rad);
}

/// Rounded by less than 1e-9, so that the last bits of a processor's trigonometry have no effect.
double coarse(double length_or_angle)
{
  constexpr int kBits = 32;
  return std::ldexp(std::nearbyint(std::ldexp(length_or_angle, kBits)), -kBits);
}

CPose3D coarse(const CPose3D& pose)
{
  return CPose3D(coarse(pose.x()), coarse(pose.y()), coarse(pose.z()), coarse(pose.yaw()),
                 coarse(pose.pitch()), coarse(pose.roll()));
}

/// Turns readings into observations.
class ObservationMaker
{
 public:
  explicit ObservationMaker(const LogOptions& options)
      : sensor_(options.sensor), noise_(options.noise), missingAs_(options.missingAs)
  {
  }

  [[nodiscard]] CObservation::Ptr scan(const std::vector<sim::BeamReading>& readings, double height_m) const
  {
    if (sensor_.kind == SensorKind::Planar) return planarScan(readings, height_m);
    auto cloud = mrpt::obs::CObservationPointCloud::Create();
    cloud->sensorLabel = sensor_.name;
    auto points = mrpt::maps::CSimplePointsMap::Create();
    points->reserve(readings.size());
    for (const sim::BeamReading& reading : readings)
    {
      if (reading.lost_m && missingAs_ == MissingAs::Invalid) continue;
      const Eigen::Vector3d point_sensor =
          reading.lost_m ? lostPoint(reading.point_sensor) : reading.point_sensor;
      const Eigen::Vector3f point = point_sensor.cast<float>();
      points->insertPointFast(point.x(), point.y(), point.z());
    }
    cloud->pointcloud = points;
    return cloud;
  }

  /// One observation per echo rank; without any echo, one invalid observation.
  [[nodiscard]] std::vector<CObservation::Ptr> ping(const sim::HeadTurn& head,
                                                    const std::vector<sim::Echo>& echoes) const
  {
    const CPose3D headPose(0, 0, 0, head.yaw_rad, head.pitch_rad, 0);
    if (sensor_.echoRanks == 1) return {singleEcho(headPose, echoes)};
    std::vector<CObservation::Ptr> all;
    for (const sim::Echo& echo : echoes)
      if (!echo.lost) all.push_back(beam(headPose, static_cast<int>(all.size()) + 1, &echo));
    if (all.empty()) all.push_back(beam(headPose, 1, echoes.empty() ? nullptr : &echoes.front()));
    return all;
  }

 private:
  /// What stands for a range.
  [[nodiscard]] float lostRange(double range_m) const
  {
    switch (missingAs_)
    {
      case MissingAs::Zero:
        return 0;
      case MissingAs::Nan:
        return std::numeric_limits<float>::quiet_NaN();
      case MissingAs::Inf:
        return std::numeric_limits<float>::infinity();
      case MissingAs::Invalid:
        return static_cast<float>(range_m);
      case MissingAs::Open:
      case MissingAs::Max:
        break;
    }
    return static_cast<float>(sensor_.rangeMax_m);
  }

  /// What stands for a point. @param open  what would stand there if nothing had returned
  [[nodiscard]] Eigen::Vector3d lostPoint(const Eigen::Vector3d& open) const
  {
    if (missingAs_ == MissingAs::Zero) return Eigen::Vector3d::Zero();
    if (missingAs_ == MissingAs::Nan)
      return Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
    if (missingAs_ == MissingAs::Inf)
      return open.unaryExpr(
          [](double x) { return x == 0 ? 0.0 : std::copysign(std::numeric_limits<double>::infinity(), x); });
    if (missingAs_ == MissingAs::Max) return open * (sensor_.rangeMax_m / open.norm());
    return open;
  }

  [[nodiscard]] CObservation::Ptr planarScan(const std::vector<sim::BeamReading>& readings,
                                             double height_m) const
  {
    auto scan = mrpt::obs::CObservation2DRangeScan::Create();
    scan->sensorLabel = sensor_.name;
    scan->sensorPose = CPose3D(0, 0, height_m, 0, 0, 0);
    scan->aperture = static_cast<float>(sensor_.aperture_rad);
    scan->maxRange = static_cast<float>(sensor_.rangeMax_m);
    scan->stdError = static_cast<float>(noise_.range_m);
    scan->rightToLeft = true;
    scan->resizeScan(readings.size());
    for (size_t i = 0; i < readings.size(); ++i)
    {
      const auto& [range_m, lost_m, point] = readings[i];
      scan->setScanRange(
          i, lost_m ? lostRange(*lost_m) : static_cast<float>(range_m.value_or(sensor_.rangeMax_m)));
      scan->setScanRangeValidity(i, range_m.has_value());
    }
    return scan;
  }

  [[nodiscard]] CObservation::Ptr beam(const CPose3D& headPose, int rank, const sim::Echo* echo) const
  {
    auto scan = mrpt::obs::CObservation2DRangeScan::Create();
    scan->sensorLabel = "SONAR/echo" + std::to_string(rank);
    scan->sensorPose = headPose;
    scan->aperture = 0;  // a fan of one beam: only with this does MRPT point it straight ahead
    scan->beamAperture = static_cast<float>(sensor_.aperture_rad);
    scan->maxRange = static_cast<float>(sensor_.rangeMax_m);
    scan->stdError = static_cast<float>(noise_.range_m);
    scan->rightToLeft = true;
    scan->resizeScan(1);
    scan->setScanHasIntensity(true);
    const bool heard = echo != nullptr && !echo->lost;
    scan->setScanRange(0, echo == nullptr ? static_cast<float>(sensor_.rangeMax_m)
                          : echo->lost    ? lostRange(echo->range_m)
                                          : static_cast<float>(echo->range_m));
    scan->setScanRangeValidity(0, heard);
    scan->setScanIntensity(0, heard ? echo->intensity : 0);
    return scan;
  }

  [[nodiscard]] CObservation::Ptr singleEcho(const CPose3D& headPose,
                                             const std::vector<sim::Echo>& echoes) const
  {
    auto ranges = mrpt::obs::CObservationRange::Create();
    ranges->sensorLabel = "SONAR";
    ranges->minSensorDistance = 0;
    ranges->maxSensorDistance = static_cast<float>(sensor_.rangeMax_m);
    compat::setConeAperture(*ranges, sensor_.aperture_rad);
    mrpt::obs::CObservationRange::TMeasurement measurement;
    measurement.sensorPose = headPose.asTPose();
    measurement.sensedDistance = 0;
    const bool lost = !echoes.empty() && echoes.front().lost;
    if (lost && missingAs_ == MissingAs::Invalid) return ranges;
    if (lost && missingAs_ != MissingAs::Open) measurement.sensedDistance = lostRange(0);
    if (!echoes.empty() && !lost) measurement.sensedDistance = static_cast<float>(echoes.front().range_m);
    ranges->sensedData.push_back(measurement);
    return ranges;
  }

  sim::SensorModel sensor_;
  sim::NoiseOptions noise_;
  MissingAs missingAs_;
};

/// Common to both kinds of logs: shots become frames with a time.
class FramedLog : public SimulatedLog
{
 public:
  FramedLog(FileOutput& file, const LogOptions& options)
      : options_(options), archive_(file), observations_(options)
  {
  }

  void addScan(const Pose& reported, const std::vector<sim::BeamReading>& readings) override
  {
    add(reported, {observations_.scan(readings, reported.position_map.z())});
  }
  void addPing(const Pose& reported, const sim::HeadTurn& head, const std::vector<sim::Echo>& echoes) override
  {
    add(reported, observations_.ping(head, echoes));
  }

 protected:
  virtual void addFrame(const Pose& robot, const mrpt::obs::CSensoryFrame::Ptr& frame,
                        mrpt::Clock::time_point time) = 0;

  LogOptions options_;
  FileArchive archive_;

 private:
  void add(const Pose& reported, const std::vector<CObservation::Ptr>& observations)
  {
    const auto time = mrpt::Clock::fromDouble(timeOfShot(options_.sensor, shots_++));
    auto frame = mrpt::obs::CSensoryFrame::Create();
    for (const CObservation::Ptr& observation : observations)
    {
      observation->timestamp = time;
      frame->insert(observation);
    }
    addFrame(robotPose(options_.sensor, reported), frame, time);
  }

  ObservationMaker observations_;
  size_t shots_ = 0;
};

class Rawlog : public FramedLog
{
 public:
  Rawlog(FileOutput& file, const LogOptions& options)
      : FramedLog(file, options), random_(options.seed, kOdometryStream)
  {
  }

  void finish() override {}

 protected:
  void addFrame(const Pose& robot, const mrpt::obs::CSensoryFrame::Ptr& frame,
                mrpt::Clock::time_point time) override
  {
    // Relative to the sum of the log's movements, so that rounding errors do not accumulate.
    const CPose3D exact = coarse(mrptPose(robot) - accumulated_);
    accumulated_ = accumulated_ + exact;
    mrpt::obs::CActionCollection actions;
    const CPose3D reported = first_ ? exact : disturbed(exact);
    if (options_.sensor.kind == SensorKind::Planar)
      actions.insert(movement2D(reported, time));
    else
      actions.insert(movement3D(reported, time));
    first_ = false;
    archive_ << actions << *frame;
  }

 private:
  static constexpr uint64_t kOdometryStream = 7;

  [[nodiscard]] CPose3D disturbed(const CPose3D& increment)
  {
    if (options_.odometryNoise == 0) return increment;
    const double length = options_.odometryNoise * std::hypot(increment.x(), increment.y(), increment.z());
    const Eigen::Vector3d along = length * random_.normal3();
    const double turn = options_.odometryNoise * std::abs(increment.yaw()) * random_.normal();
    const bool planar = options_.sensor.kind == SensorKind::Planar;
    return coarse(CPose3D(increment.x() + along.x(), increment.y() + along.y(),
                          increment.z() + (planar ? 0 : along.z()), increment.yaw() + turn, increment.pitch(),
                          increment.roll()));
  }

  [[nodiscard]] static mrpt::obs::CActionRobotMovement2D movement2D(const CPose3D& increment,
                                                                    mrpt::Clock::time_point time)
  {
    mrpt::obs::CActionRobotMovement2D action;
    action.timestamp = time;
    const mrpt::obs::CActionRobotMovement2D::TMotionModelOptions options;
    action.computeFromOdometry(mrpt::poses::CPose2D(increment), options);
    return action;
  }

  [[nodiscard]] mrpt::obs::CActionRobotMovement3D movement3D(const CPose3D& increment,
                                                             mrpt::Clock::time_point time) const
  {
    mrpt::obs::CActionRobotMovement3D action;
    action.timestamp = time;
    action.rawOdometryIncrementReading = increment;
    action.poseChange.mean = increment;  // computeFromOdometry() would draw it at random
    const double share = options_.odometryNoise;
    const double length = share * increment.norm();
    const double turn = share * std::abs(increment.yaw());
    constexpr double kLeast = 1e-3;  // [m], [rad]: programs that draw from it need a covariance
    const auto& noise = options_.noise;
    action.poseChange.cov.setZero();
    for (int i = 0; i < 6; ++i)
    {
      const double pose = i < 3 ? noise.position_m : noise.turn_rad;
      const double odometry = i < 3 ? length : i == 3 ? turn : 0;
      action.poseChange.cov(i, i) = kLeast * kLeast + 2 * pose * pose + odometry * odometry;
    }
    return action;
  }

  sim::Random random_;
  CPose3D accumulated_;
  bool first_ = true;
};

class Simplemap : public FramedLog
{
 public:
  using FramedLog::FramedLog;

  void finish() override { archive_ << map_; }

 protected:
  void addFrame(const Pose& robot, const mrpt::obs::CSensoryFrame::Ptr& frame,
                mrpt::Clock::time_point) override
  {
    auto pose = mrpt::poses::CPose3DPDFGaussian::Create();
    pose->mean = coarse(mrptPose(robot));
    pose->cov.setZero();
    const auto& noise = options_.noise;
    const bool planar = options_.sensor.kind == SensorKind::Planar;
    for (int i = 0; i < 6; ++i)  // x, y, z, yaw, pitch, roll
    {
      const bool errs = !planar || i < 2 || i == 3;
      const double deviation = i < 3 ? noise.position_m : noise.turn_rad;
      pose->cov(i, i) = errs ? deviation * deviation : 0;
    }
    map_.insert(pose, frame);
  }

 private:
  mrpt::maps::CSimpleMap map_;
};
}  // namespace

const std::vector<std::string>& missingAsNames()
{
  static const std::vector<std::string> names{"open", "zero", "nan", "inf", "max", "invalid"};
  return names;
}

MissingAs missingAs(const std::string& name)
{
  const auto& names = missingAsNames();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) throw std::out_of_range(name + ": no code for a lost return");
  return static_cast<MissingAs>(found - names.begin());
}

double timeOfShot(const sim::SensorModel& sensor, size_t shot)
{
  constexpr double kBegin = 1577836800;  // 2020-01-01 00:00:00 UTC: the same in every log
  return kBegin + static_cast<double>(shot) * sensor.period_s;
}

Pose robotPose(const sim::SensorModel& sensor, const Pose& sensorPose)
{
  Pose pose = sensorPose;
  if (sensor.kind == SensorKind::Planar) pose.position_map.z() = 0;
  return pose;
}

std::unique_ptr<SimulatedLog> makeRawlog(FileOutput& file, const LogOptions& options)
{
  return std::make_unique<Rawlog>(file, options);
}

std::unique_ptr<SimulatedLog> makeSimplemap(FileOutput& file, const LogOptions& options)
{
  return std::make_unique<Simplemap>(file, options);
}

}  // namespace lamap::tools
