#include <lamap_mrpt/maps/uncertain_inputs.h>
#include <lamap_mrpt/options/map_sections.h>

namespace lamap
{
void warnWithoutCovariance(const Scan& scan)
{
  if (!scan.poseCovariance || scan.poseCovariance->isZero(0))
    warnOnce(
        "insertOpts.usePoseCovariance = true: the pose of a scan has no covariance, or a zero one; such "
        "scans count as certain");
}

std::optional<HilbertUncertainty> uncertaintyOf(const UncertainInputs& inputs, const Scan& scan)
{
  if (inputs.usePoseCovariance) warnWithoutCovariance(scan);
  HilbertUncertainty uncertainty;
  if (inputs.usePoseCovariance && scan.poseCovariance)
  {
    uncertainty.pose = *scan.poseCovariance;
    uncertainty.centre = scan.sensorPose_map.translation();
  }
  uncertainty.rangeStd_m = inputs.rangeStd;
  uncertainty.point = Eigen::Matrix3d::Identity() * (inputs.pointStd * inputs.pointStd);
  if (!uncertainty.any()) return std::nullopt;
  return uncertainty;
}

}  // namespace lamap
