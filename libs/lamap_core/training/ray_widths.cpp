#include <lamap_core/scan/beam_spacing.h>
#include <lamap_core/training/ray_widths.h>

#include <algorithm>
#include <cmath>

namespace lamap
{
namespace
{
/// Of the distance between two beams: the standard deviation of where the beam speaks for. Chosen by log
/// loss.
constexpr double kOfSpacing = 0.2;

/// Of the half angle of a cone that is filled evenly: the standard deviation along each axis, averaged over
/// the two axes across and none along it. √(1/4 · 2/3)
constexpr double kOfCone = 0.40824829046386302;
}  // namespace

RayWidths::RayWidths(const Scan& scan, const SamplingRules& rules, const ScanFrame& frame)
    : scan_(scan), beamWidth_(rules.beamWidth), resolution_m_(frame.resolution_m())
{
  if (rules.usePoseCovariance && scan.poseCovariance && !scan.poseCovariance->isZero(0))
    pose_.emplace(*scan.poseCovariance, frame.planar());
}

void RayWidths::enterFan(const RayFan& fan)
{
  centre_map_ = scan_.turnedToMap(fan.centre);
  spacing_.clear();
  halfAngle_ = 0;
  rangeVariance_ = 0;
  if (beamWidth_ == BeamWidth::None) return;
  halfAngle_ = std::max(fan.beam.halfWidth_rad, fan.beam.halfHeight_rad);
  const double range = fan.beam.rangeStd_m / resolution_m_;
  rangeVariance_ = range * range / 3;
  if (beamWidth_ == BeamWidth::Spacing && fan.rays.size() > 1) spacing_ = beamSpacing(fan);
}

double RayWidths::angleOf(size_t ray) const
{
  return std::max(kOfCone * halfAngle_, spacing_.empty() ? 0.0 : kOfSpacing * spacing_[ray]);
}

RayWidth RayWidths::along(double angle, const Eigen::Vector3d& direction_map) const
{
  RayWidth width;
  if (pose_)
  {
    width = pose_->along(centre_map_, direction_map);
    width.constant /= resolution_m_ * resolution_m_;
    width.linear /= resolution_m_;
  }
  width.square += angle * angle;
  width.ofRange = rangeVariance_;
  return width;
}

}  // namespace lamap
