#include <lamap_mrpt/learned_map/end_point_likelihood.h>

#include <lamap_mrpt/observations/observation_rays.h>

#include <algorithm>
#include <cmath>
#include <functional>

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
    {
      if (ray.meaning != RayEnd::Return) continue;
      const Eigen::Vector3d direction = selected.turnedToMap(fan.directionOf(ray));
      const double range_m = direction.norm();
      const Eigen::Vector3d backwards =
          range_m > 0 ? Eigen::Vector3d(-direction / range_m) : Eigen::Vector3d::Zero();
      endPoints.ends.push_back({selected.inMap(ray.end), backwards, range_m});
    }
  return endPoints;
}

EndPointLikelihood::EndPointLikelihood(const CLearnedMap& map, const CLearnedMap::TLikelihoodOptions& options)
    : map_(map), options_(options), resolution_(map.resolution()), layer_(map.planarLayer())
{
  // Nearer, the point would often lie in the cell of the end itself.
  constexpr double kNearest_cells = 2;
  if (options.freeBefore > 0) freeBefore_m_ = std::max(options.freeBefore, kNearest_cells * resolution_);
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
  const std::lock_guard<std::mutex> lock(mutex_);
  double sum = 0;
  const auto add = [&](CellProbs& cells) { sum = sumOf(cells, endPoints, robotPose); };
  map_.withProbs(std::cref(add));  // by reference: a copy would be allocated
  return options_.independence * sum;
}

double EndPointLikelihood::sumOf(CellProbs& cells, const EndPoints& endPoints,
                                 const mrpt::poses::CPose3D& robotPose) const
{
  const Eigen::Matrix3d rotation = robotPose.getRotationMatrix().asEigen();
  const Eigen::Vector3d translation(robotPose.x(), robotPose.y(), robotPose.z());
  double sum = 0;
  for (const EndPoints::End& end : endPoints.ends)
  {
    const Eigen::Vector3d point_map = rotation * end.point_robot + translation;
    double prob = probAt(cells, point_map);
    if (freeBefore_m_ > 0 && end.range_m > freeBefore_m_)
      prob *= 1 - ownProbAt(cells, point_map + freeBefore_m_ * (rotation * end.backwards_robot));
    sum += std::log((1 - options_.outlierProb) * prob + 0.5 * options_.outlierProb);
  }
  return sum;
}

double EndPointLikelihood::probAt(CellProbs& cells, const Eigen::Vector3d& point_map) const
{
  return kept(ends_, point_map, [&](const CellIndex& cell) { return probAround(cells, cell); });
}

double EndPointLikelihood::ownProbAt(CellProbs& cells, const Eigen::Vector3d& point_map) const
{
  return kept(ownCells_, point_map,
              [&](const CellIndex& cell) { return cells.prob(cell).value_or(options_.unobservedProb); });
}

template <typename Compute>
double EndPointLikelihood::kept(Probs& probs, const Eigen::Vector3d& point_map, Compute&& compute) const
{
  auto cell = cellAt(point_map, resolution_);
  if (!cell) return options_.unobservedProb;
  if (layer_) cell->z = *layer_;
  const uint32_t change = map_.contentChanges();
  const auto known = probs.find(*cell);
  if (known != probs.end())
  {
    Prob& kept = known.value();
    if (kept.change != change) kept = {static_cast<float>(compute(*cell)), change};
    return kept.prob;
  }
  // A lost filter in a large map must not fill the memory.
  constexpr size_t kMostProbs = size_t{1} << 22;
  if (probs.size() >= kMostProbs) probs.clear();
  const auto prob = static_cast<float>(compute(*cell));
  probs.emplace(*cell, Prob{prob, change});
  return prob;
}

double EndPointLikelihood::probAround(CellProbs& cells, const CellIndex& cell) const
{
  double largest = cells.prob(cell).value_or(options_.unobservedProb);
  for (const Neighbour& neighbour : neighbours_)
  {
    if (neighbour.weight <= largest) break;  // because P ≤ 1
    const auto prob =
        cells.prob({cell.x + neighbour.offset.x, cell.y + neighbour.offset.y, cell.z + neighbour.offset.z});
    if (prob) largest = std::max(largest, neighbour.weight * *prob);
  }
  return largest;
}

}  // namespace lamap
