#include <lamap_mrpt/end_point_likelihood.h>

#include <lamap_mrpt/observation_rays.h>

#include <cmath>

namespace lamap
{
EndPoints endPointsOf(const mrpt::obs::CObservation& observation, const RangeLimits& limits)
{
  EndPoints endPoints;
  endPoints.limits = limits;
  const auto scan = raysOf(observation, mrpt::poses::CPose3D());
  if (!scan) return endPoints;
  for (const SelectedFan& fan : selectRays(*scan, limits).fans)
    endPoints.ends_robot.insert(endPoints.ends_robot.end(), fan.hitEnds_map.begin(), fan.hitEnds_map.end());
  return endPoints;
}

double endPointLogLikelihood(const CLearnedMap& map, const EndPoints& endPoints,
                             const mrpt::poses::CPose3D& robotPose,
                             const CLearnedMap::TLikelihoodOptions& options)
{
  const auto& rotation = robotPose.getRotationMatrix();
  const double floor = 0.5 * options.outlierProb;
  double sum = 0;
  for (const Eigen::Vector3d& end : endPoints.ends_robot)
  {
    const mrpt::math::TPoint3D end_map(
        rotation(0, 0) * end.x() + rotation(0, 1) * end.y() + rotation(0, 2) * end.z() + robotPose.x(),
        rotation(1, 0) * end.x() + rotation(1, 1) * end.y() + rotation(1, 2) * end.z() + robotPose.y(),
        rotation(2, 0) * end.x() + rotation(2, 1) * end.y() + rotation(2, 2) * end.z() + robotPose.z());
    const auto estimate = map.estimateAt(end_map);
    sum += std::log((1 - options.outlierProb) * (estimate ? estimate->prob : options.unobservedProb) + floor);
  }
  return options.independence * sum;
}

}  // namespace lamap
