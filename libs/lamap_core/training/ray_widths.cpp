#include <lamap_core/scan/beam_spacing.h>
#include <lamap_core/training/ray_widths.h>

namespace lamap
{
namespace
{
/// Of the distance between two beams: the standard deviation of where the beam speaks for. Chosen by log
/// loss.
constexpr double kOfSpacing = 0.2;

/// Of the end of a ray, from its pose [cells]: less is left out, because it costs more than it tells. Chosen
/// by log loss.
constexpr double kLeastOfPose_cells = 0.99;

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
  rangeVariance_ = 0;
  if (beamWidth_ == BeamWidth::None) return;
  const double range = fan.beam.rangeStd_m / resolution_m_;
  rangeVariance_ = range * range / 3;
  if (beamWidth_ == BeamWidth::Spacing && fan.rays.size() > 1) spacing_ = beamSpacing(fan);
}

double RayWidths::angleOf(size_t ray) const
{
  return spacing_.empty() ? 0.0 : kOfSpacing * spacing_[ray];
}

RayWidth RayWidths::along(double angle, const Eigen::Vector3d& direction_map, double length) const
{
  RayWidth width;
  if (pose_)
  {
    width = pose_->along(centre_map_, direction_map);
    width.constant /= resolution_m_ * resolution_m_;
    width.linear /= resolution_m_;
    if (width.variance(length) < kLeastOfPose_cells * kLeastOfPose_cells) width = {};
  }
  width.square += angle * angle;
  width.ofRange = rangeVariance_;
  return width;
}

BeamCone coneOf(const Scan& scan, const RayFan& fan, BeamWidth beamWidth, bool planar)
{
  if (beamWidth == BeamWidth::None) return {};
  std::optional<Eigen::Vector3d> vertical;
  if (planar) vertical = scan.sensorPose_map.linear().row(2).transpose();
  return {fan.beam, vertical};
}

}  // namespace lamap
