#include <lamap_mrpt/learned_map/end_point_likelihood.h>

#include <lamap_mrpt/observations/observation_rays.h>

#include <algorithm>
#include <cmath>

namespace lamap
{
EndPoints endPointsOf(const mrpt::obs::CObservation& observation, const RangeOptions& limits)
{
  EndPoints endPoints;
  endPoints.limits = limits;
  const auto scan = raysOf(observation, mrpt::poses::CPose3D());
  if (!scan) return endPoints;
  const Scan selected = selectRays(*scan, limits).scan;
  for (const RayFan& fan : selected.fans)
    for (const Ray& ray : fan.rays)
      if (ray.meaning == RayEnd::Return) endPoints.ends_robot.push_back(selected.inMap(ray.end));
  return endPoints;
}

EndPointLikelihood::EndPointLikelihood(const CLearnedMap& map, const CLearnedMap::TLikelihoodOptions& options)
    : map_(map), options_(options), resolution_(map.resolution()), layer_(map.planarLayer())
{
  // Beyond this many σ the weight is below 5 %.
  constexpr double kReach_std = 2.45;
  constexpr double kMostCells = 64;
  const double std_cells = options.endPointStd / resolution_;
  const int reach = static_cast<int>(std::min(kReach_std * std_cells, kMostCells));
  for (int z = layer_ ? 0 : -reach; z <= (layer_ ? 0 : reach); ++z)
    for (int y = -reach; y <= reach; ++y)
      for (int x = -reach; x <= reach; ++x)
      {
        const double squared = x * x + y * y + z * z;
        if (squared > reach * reach) continue;
        neighbours_.push_back(
            {{x, y, z}, squared == 0 ? 1.0 : std::exp(-0.5 * squared / (std_cells * std_cells))});
      }
  std::stable_sort(neighbours_.begin(), neighbours_.end(),
                   [](const Neighbour& a, const Neighbour& b) { return a.weight > b.weight; });
}

double EndPointLikelihood::logOf(const EndPoints& endPoints, const mrpt::poses::CPose3D& robotPose) const
{
  const Eigen::Matrix3d rotation = robotPose.getRotationMatrix().asEigen();
  const Eigen::Vector3d translation(robotPose.x(), robotPose.y(), robotPose.z());
  const std::lock_guard<std::mutex> lock(mutex_);
  double sum = 0;
  for (const Eigen::Vector3d& end : endPoints.ends_robot) sum += termAt(rotation * end + translation);
  return options_.independence * sum;
}

double EndPointLikelihood::termAt(const Eigen::Vector3d& point_map) const
{
  auto cell = cellAt(point_map, resolution_);
  if (!cell) return termOf(options_.unobservedProb);
  if (layer_) cell->z = *layer_;
  const auto known = terms_.find(*cell);
  if (known != terms_.end()) return known->second;
  // A lost filter in a large map must not fill the memory.
  constexpr size_t kMostTerms = size_t{1} << 22;
  if (terms_.size() >= kMostTerms) terms_.clear();
  const auto term = static_cast<float>(termOf(probAround(*cell)));
  terms_.emplace(*cell, term);
  return term;
}

double EndPointLikelihood::termOf(double prob) const
{
  return std::log((1 - options_.outlierProb) * prob + 0.5 * options_.outlierProb);
}

double EndPointLikelihood::probAround(const CellIndex& cell) const
{
  const auto own = map_.estimateCell(cell);
  double largest = own ? own->prob : options_.unobservedProb;
  for (const Neighbour& neighbour : neighbours_)
  {
    if (neighbour.weight <= largest) break;  // because P ≤ 1
    const auto estimate = map_.estimateCell(
        {cell.x + neighbour.offset.x, cell.y + neighbour.offset.y, cell.z + neighbour.offset.z});
    if (estimate) largest = std::max(largest, neighbour.weight * estimate->prob);
  }
  return largest;
}

}  // namespace lamap
