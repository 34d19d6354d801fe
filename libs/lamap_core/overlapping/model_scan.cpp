#include <lamap_core/overlapping/model_scan.h>

#include <lamap_core/scan/scan_frame.h>

#include <cmath>
#include <stdexcept>
#include <string>

namespace lamap
{
namespace
{
/// Rᵀ·M with R a model's rotation, in an order of operations that is always the same.
Eigen::Matrix3d turnedBack(const ModelPose& frame, const Eigen::Matrix3d& matrix)
{
  Eigen::Matrix3d turned;
  for (int column = 0; column < 3; ++column) turned.col(column) = frame.turnedBack(matrix.col(column));
  return turned;
}

/// Rᵀ·M·R.
Eigen::Matrix3d covarianceTurnedBack(const ModelPose& frame, const Eigen::Matrix3d& covariance)
{
  return turnedBack(frame, turnedBack(frame, covariance).transpose()).transpose();
}

const RayFan* firstPlaced(const Scan& selected, const ModelShape& shape)
{
  for (const RayFan& fan : selected.fans)
  {
    if (fan.rays.empty()) continue;
    Eigen::Vector3d centre = selected.inMap(fan.centre);
    if (shape.planar) centre.z() = 0;
    if (cellAt(centre, shape.resolution_m)) return &fan;
  }
  return nullptr;
}

/// From a sensor's frame to a model's.
class SensorInModel
{
 public:
  SensorInModel(const Scan& scan, const RayFan& first, const ModelPose& own, const ModelPose& frame,
                const ModelShape& shape)
      : from_(first.centre), planar_(shape.planar)
  {
    const Eigen::Vector3d cells(static_cast<double>(own.anchor.x) - frame.anchor.x,
                                static_cast<double>(own.anchor.y) - frame.anchor.y,
                                static_cast<double>(own.anchor.z) - frame.anchor.z);
    to_ = frame.turnedBack(cells * shape.resolution_m + (own.offset_m - frame.offset_m));
    rotation_ = turnedBack(frame, scan.sensorPose_map.linear());
    constexpr double kNoTurn = 1e-12;  // but for the rounding of the rotation itself
    if ((rotation_ - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < kNoTurn) rotation_.setIdentity();
  }

  [[nodiscard]] Eigen::Vector3d turned(const Eigen::Vector3d& v) const
  {
    const auto along = [&](int axis)
    { return (rotation_(axis, 0) * v.x() + rotation_(axis, 1) * v.y()) + rotation_(axis, 2) * v.z(); };
    return {along(0), along(1), along(2)};
  }
  [[nodiscard]] Eigen::Vector3d place(const Eigen::Vector3d& point) const
  {
    Eigen::Vector3d p = turned(point - from_) + to_;
    if (planar_) p.z() = 0;
    return p;
  }

 private:
  Eigen::Vector3d from_;  ///< in the sensor's frame
  Eigen::Vector3d to_;    ///< the same place in the model's
  Eigen::Matrix3d rotation_;
  bool planar_;
};

/// Puts fans into a model's frame.
/// Half of what a frame of cells can hold, so that nothing on the way meets its end.
bool isNear(const Eigen::Vector3d& p, const ModelShape& shape)
{
  return p.cwiseAbs().maxCoeff() < 0.5 * ScanFrame::kReach_cells * shape.resolution_m;
}

bool isPoint(const Eigen::Vector3d& ray, const ModelShape& shape)
{
  return ray.x() == 0 && ray.y() == 0 && (shape.planar || ray.z() == 0);
}

/// Where the free space of a ray ends, or its hit is.
Eigen::Vector3d endOf(const RayFan& fan, const Ray& ray)
{
  return ray.meaning == RayEnd::Return ? ray.end : Eigen::Vector3d(fan.centre + ray.end);
}

class FanMover
{
 public:
  FanMover(const SensorInModel& sensor, const ModelShape& shape, RayCounts& counts)
      : sensor_(sensor), shape_(shape), counts_(counts)
  {
  }

  RayFan move(const RayFan& fan)
  {
    RayFan moved;
    moved.centre = sensor_.place(fan.centre);
    moved.statedRangeMax_m = fan.statedRangeMax_m;
    moved.beam = fan.beam;
    moved.beam.up = sensor_.turned(fan.beam.up);
    moved.rays.reserve(fan.rays.size());
    for (const Ray& ray : fan.rays)
    {
      if (ray.meaning != RayEnd::Return) continue;
      const Eigen::Vector3d end = sensor_.place(ray.end);
      if (isUsable(moved.centre, end, end - moved.centre, counts_.hits))
        moved.rays.push_back({end, RayEnd::Return, ray.echo});
    }
    for (const Ray& ray : fan.rays)
    {
      if (ray.meaning == RayEnd::Return) continue;
      const Eigen::Vector3d turned = sensor_.turned(ray.end);
      if (isUsable(moved.centre, moved.centre + turned, turned, counts_.freeOnly))
        moved.rays.push_back({turned, ray.meaning, ray.echo});
    }
    return moved;
  }

 private:
  bool isUsable(const Eigen::Vector3d& centre, const Eigen::Vector3d& end, const Eigen::Vector3d& ray,
                size_t& used)
  {
    const bool isOutside = !isNear(centre, shape_) || !isNear(end, shape_);
    if (!isPoint(ray, shape_) && !isOutside) return true;
    --used;
    ++(isOutside ? counts_.outside : counts_.tooNear);
    return false;
  }

  const SensorInModel& sensor_;
  const ModelShape& shape_;
  RayCounts& counts_;
};

HilbertUncertainty inModel(const HilbertUncertainty& uncertainty, const Scan& scan, const ModelPose& frame,
                           const SensorInModel& sensor, const ModelShape& shape)
{
  HilbertUncertainty turned = uncertainty;
  for (const int row : {0, 3})
    for (const int column : {0, 3})
      turned.pose.block<3, 3>(row, column) =
          covarianceTurnedBack(frame, uncertainty.pose.block<3, 3>(row, column));
  turned.point = covarianceTurnedBack(frame, uncertainty.point);
  turned.centre = sensor.place(Eigen::Vector3d::Zero()) +
                  frame.turnedBack(uncertainty.centre - scan.inMap(Eigen::Vector3d::Zero()));
  if (shape.planar) turned.centre.z() = shape.flatHeight();
  return turned;
}

}  // namespace

void ModelScan::check(const ModelShape& shape) const
{
  const auto require = [](bool condition, const char* what)
  {
    if (!condition) throw std::runtime_error(std::string("a waiting scan of the map is corrupt: ") + what);
  };
  for (const RayFan& fan : rays.scan.fans)
  {
    require(isLegalBeam(fan.beam), "its beam has no legal width");
    require(fan.statedRangeMax_m >= 0 && std::isfinite(fan.statedRangeMax_m), "its range is not legal");
    // The centre of a fan without rays may be anywhere.
    if (fan.rays.empty()) continue;
    require(fan.centre.allFinite() && isNear(fan.centre, shape), "its sensor is out of reach");
    for (const Ray& ray : fan.rays)
    {
      require(ray.end.allFinite() && isNear(endOf(fan, ray), shape), "a ray is not finite, or out of reach");
      require(!isPoint(fan.directionOf(ray), shape), "a ray has no length");
    }
  }
  if (!uncertainty) return;
  try
  {
    uncertainty->validate();
  }
  catch (const std::invalid_argument& error)
  {
    require(false, error.what());
  }
}

bool operator==(const ModelScan& a, const ModelScan& b)
{
  return a.rays.scan.fans == b.rays.scan.fans && a.uncertainty == b.uncertainty;
}

std::optional<ModelPose> modelFrameOf(const Scan& selected, const ModelShape& shape)
{
  const RayFan* first = firstPlaced(selected, shape);
  if (first == nullptr) return std::nullopt;
  Eigen::Isometry3d pose(selected.sensorPose_map);
  pose.translation() = selected.inMap(first->centre);
  return ModelPose::of(pose, shape.resolution_m, shape.planar);
}

ModelScan scanInModel(const SelectedRays& selected, const HilbertUncertainty* uncertainty,
                      const ModelPose& frame, const ModelShape& shape)
{
  ModelScan result;
  RayCounts& counts = result.rays.counts;
  counts = selected.counts;
  const std::optional<ModelPose> own = modelFrameOf(selected.scan, shape);
  if (!own)
  {
    counts.outside += counts.used();
    counts.hits = counts.freeOnly = 0;
    return result;
  }
  const SensorInModel sensor(selected.scan, *firstPlaced(selected.scan, shape), *own, frame, shape);
  FanMover mover(sensor, shape, counts);
  for (const RayFan& fan : selected.scan.fans) result.rays.scan.fans.push_back(mover.move(fan));
  if (uncertainty != nullptr && uncertainty->any())
    result.uncertainty = inModel(*uncertainty, selected.scan, frame, sensor, shape);
  return result;
}

}  // namespace lamap
