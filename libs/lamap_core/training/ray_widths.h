#pragma once

#include <lamap_core/scan/beam_cone.h>
#include <lamap_core/scan/scan_frame.h>
#include <lamap_core/training/point_width.h>
#include <lamap_core/training/sampling_rules.h>

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace lamap
{
/// How wide the points of a scan's rays are, by the rules. A beam's cone is no width: see BeamCone.
class RayWidths
{
 public:
  RayWidths(const Scan& scan, const SamplingRules& rules, const ScanFrame& frame);

  /// From now on rays are of this fan, of the scan.
  void enterFan(const RayFan& fan);

  /// Whether any ray of the fan may have a width.
  [[nodiscard]] bool any() const { return pose_ || rangeVariance_ > 0 || !spacing_.empty(); }

  /// @return the angle that the points of the i-th ray of the fan are uncertain by, along each axis [rad]
  [[nodiscard]] double angleOf(size_t ray) const;

  /** Poses count where they make the ray's end uncertain by about a cell or more.
   * @param angle of the ray's points [rad]; @param direction_map of length 1; @param length of the ray
   * [cells]
   * @return in cells², at distances in cells */
  [[nodiscard]] RayWidth along(double angle, const Eigen::Vector3d& direction_map, double length) const;

 private:
  const Scan& scan_;
  BeamWidth beamWidth_;
  double resolution_m_;
  std::optional<PoseWidth> pose_;
  Eigen::Vector3d centre_map_ = Eigen::Vector3d::Zero();  ///< of the fan, from the sensor [m]
  std::vector<float> spacing_;
  double rangeVariance_ = 0;  ///< [cells²]
};

/// The cones of a fan's beams, by the rules.
[[nodiscard]] BeamCone coneOf(const Scan& scan, const RayFan& fan, BeamWidth beamWidth, bool planar);

}  // namespace lamap
