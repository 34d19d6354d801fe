#include <lamap_mrpt/maps/uncertain_inputs.h>

namespace lamap
{
std::optional<HilbertUncertainty> uncertaintyOf(const UncertainInputs& inputs, const Scan& scan)
{
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
