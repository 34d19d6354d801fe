#include <support/overlapping_oracle.h>

#include <lamap_core/scan/lattice_frame.h>
#include <lamap_core/training/hilbert_training.h>
#include <support/hilbert_oracle.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

namespace lamap::test
{
namespace
{
constexpr double kPi = 3.141592653589793;
constexpr double kDoubt_m = 1e-5;

Eigen::Isometry3d inPlane(const Eigen::Isometry3d& pose)
{
  Eigen::Isometry3d flat = Eigen::Isometry3d::Identity();
  const double yaw = std::atan2(pose.linear()(1, 0), pose.linear()(0, 0));
  flat.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  flat.translation() = Eigen::Vector3d(pose.translation().x(), pose.translation().y(), 0);
  return flat;
}

/// Bin of a direction; doubtful next to the edge of a bin.
std::pair<int, int> binOf(const Eigen::Vector3d& d, double bin_deg, bool planar, bool& doubtful)
{
  const auto binAlong = [&](double angle_rad)
  {
    const double bins = angle_rad * 180.0 / kPi / bin_deg;
    // Angles are worked out to 1e-5 rad.
    if (std::abs(bins - std::round(bins)) < 1e-3) doubtful = true;
    return static_cast<int>(std::floor(bins));
  };
  const int column = binAlong(std::atan2(d.y(), d.x()) + kPi);
  return {planar ? 0 : binAlong(std::atan2(d.z(), std::hypot(d.x(), d.y())) + kPi / 2), column};
}
/// Of the row, the one below and the one above; beyond the edge of the field a floor or a ceiling goes on.
/// @param ofRow by row relative to that of the place. @param row that one. @param bin_deg height of a row
double shortestAround(const std::map<int, Eigen::Vector3d>& ofRow, int row, double bin_deg)
{
  const auto own = ofRow.find(0);
  if (own == ofRow.end()) return 0;
  double shortest = own->second.norm();
  for (const int side : {-1, 1})
  {
    const double height = own->second.z();
    const double farSide_rad = ((row + (side > 0 ? 1 : 0)) * bin_deg - 90) * kPi / 180;
    if (const auto other = ofRow.find(side); other != ofRow.end())
      shortest = std::min(shortest, other->second.norm());
    else if (height * side > 0)
      shortest = std::min(shortest, height / std::sin(farSide_rad));
  }
  return shortest;
}

/// Of the part itself, else of the next ones to its left and right, up to ten away.
double shortestBeside(const std::map<int, double>& ofPart)
{
  if (const auto own = ofPart.find(0); own != ofPart.end()) return own->second;
  double shortest = std::numeric_limits<double>::infinity();
  for (const int side : {-1, 1})
    for (int step = 1; step <= 10; ++step)
      if (const auto next = ofPart.find(side * step); next != ofPart.end())
      {
        shortest = std::min(shortest, next->second);
        break;
      }
  return std::isfinite(shortest) ? shortest : 0;
}
}  // namespace

void OverlappingOracle::addModel(const HilbertModel& model, const std::vector<Scan>& scans)
{
  const bool planar = structure_.planar;
  Model own;
  const Eigen::Isometry3d sensorPose(scans.front().sensorPose_map);
  own.pose = planar ? inPlane(sensorPose) : sensorPose;
  own.bias = model.bias;
  const double h = structure_.latticeSpacing;
  size_t number = 0;
  for (size_t b = 0; b < model.sites.blocks.size(); ++b)
    for (int offset = 0; offset < 512; ++offset)
    {
      if ((model.sites.bits[b][static_cast<size_t>(offset / 64)] >> (offset % 64) & 1) == 0) continue;
      const BlockIndex& block = model.sites.blocks[b];
      const Eigen::Vector3d site(block.x * 8 + offset % 8, block.y * 8 + offset / 8 % 8,
                                 block.z * 8 + offset / 64);
      own.kernels.push_back({h * (site.array() + 0.5), model.sites.weights[number++]});
    }
  for (size_t k = 0; k < model.inducing.size(); ++k)
    own.kernels.push_back({model.inducing[k], model.kernelWeights[k]});

  // The rays in the model's frame, and the training points that they give there.
  const HilbertFrame frame = HilbertFrame::ofModel(structure_.resolution, structure_.latticeSpacing, planar);
  std::vector<Eigen::Vector3d> points;
  for (const Scan& scan : scans)
  {
    // By way of the map's frame.
    const Eigen::Matrix3d turn = scan.sensorPose_map.linear();
    const Eigen::Vector3d shift = scan.sensorPose_map.translation();
    const auto toModel = [&](const Eigen::Vector3d& point)
    {
      Eigen::Vector3d p = turn * point + shift;
      if (planar) p.z() = 0;
      return Eigen::Vector3d(own.pose.inverse() * p);
    };
    Scan moved;
    for (const RayFan& fan : selectRays(scan, inference_.rangeLimits()).scan.fans)
    {
      RayFan movedFan;
      movedFan.centre = toModel(fan.centre);
      Sensor sensor{movedFan.centre, fan.statedRangeMax_m, {}};
      if (sensor.rangeMax_m == 0) sensor.rangeMax_m = std::numeric_limits<double>::infinity();
      for (const Ray& ray : fan.rays)
      {
        if (ray.meaning == RayEnd::Return)
        {
          own.hits_map.push_back(turn * ray.end + shift);
          movedFan.addReturn(toModel(ray.end));
          sensor.rays.push_back(movedFan.rays.back().end - movedFan.centre);
          continue;
        }
        Eigen::Vector3d inMap = turn * ray.end;
        if (planar) inMap.z() = 0;
        sensor.rays.emplace_back(own.pose.linear().transpose() * inMap);
        movedFan.add(RayEnd::Cut, sensor.rays.back());
      }
      if (!sensor.rays.empty()) own.sensors.push_back(sensor);
      moved.fans.push_back(movedFan);
    }
    RangeOptions none;
    const HilbertTrainingSet set = trainingSetOf(moved, none, inference_.rules(), frame);
    points.insert(points.end(), set.points.begin(), set.points.end());
  }
  for (int axis = 0; axis < 3; ++axis)
  {
    std::vector<double> along;
    for (const Eigen::Vector3d& p : points) along.push_back(p[axis]);
    std::sort(along.begin(), along.end());
    const auto cut = std::min((along.size() - 1) / 2, static_cast<size_t>(inference_.boxQuantile *
                                                                          static_cast<double>(along.size())));
    own.low[axis] = along[cut] - 1.5 * structure_.resolution;
    own.high[axis] = along[along.size() - 1 - cut] + 1.5 * structure_.resolution;
  }
  models_.push_back(own);
}

OverlappingOracle::Seen OverlappingOracle::lookAt(const Model& model, const Eigen::Vector3d& p,
                                                  bool& doubtful) const
{
  Seen any;
  for (const Sensor& sensor : model.sensors)
  {
    Eigen::Vector3d d = p - sensor.origin;
    if (structure_.planar) d.z() = 0;
    const double range = d.norm();
    const auto within = [&](double limit)
    {
      if (std::abs(range - limit) < kDoubt_m) doubtful = true;
      return range <= limit;
    };
    if (!within(sensor.rangeMax_m)) continue;
    if (within(inference_.fieldNear))
    {
      any = {true, true};
      continue;
    }
    const auto bin = binOf(d, inference_.fieldAngle, structure_.planar, doubtful);
    // All fans from the same place see together.
    double depth = 0;
    std::map<int, Eigen::Vector3d> shortestOfRow;  // relative to the bin's row, in its column
    std::map<int, double> shortestOfPart;  // planar: relative to the place's fifth of a bin, round both ways
    const double part_deg = inference_.fieldAngle / 5;
    bool onEdgeOfPart = false;
    const auto part = binOf(d, part_deg, structure_.planar, onEdgeOfPart);
    if (structure_.planar && onEdgeOfPart) doubtful = true;
    std::set<int> doubtfulParts;
    const int parts = 5 * static_cast<int>(std::ceil(360.0 / inference_.fieldAngle));
    for (const Sensor& other : model.sensors)
    {
      if ((other.origin - sensor.origin).norm() > 1e-9 || other.rangeMax_m != sensor.rangeMax_m) continue;
      for (Eigen::Vector3d ray : other.rays)
      {
        if (structure_.planar) ray.z() = 0;
        bool rayDoubtful = false;
        const auto rayBin = binOf(ray, inference_.fieldAngle, structure_.planar, rayDoubtful);
        bool partDoubtful = false;
        const auto rayPart = binOf(ray, part_deg, structure_.planar, partDoubtful);
        // A ray on the edge of a bin may be on its other side.
        const bool touches =
            std::abs(rayBin.first - bin.first) <= 1 && std::abs(rayBin.second - bin.second) <= 1;
        if (rayDoubtful && touches) doubtful = true;
        if (partDoubtful && structure_.planar) doubtfulParts.insert(rayPart.second - part.second);
        const auto keep = [&](std::map<int, double>& shortest, int key)
        {
          const auto [held, isNew] = shortest.emplace(key, ray.norm());
          if (!isNew) held->second = std::min(held->second, ray.norm());
        };
        if (rayBin == bin) depth = std::max(depth, ray.norm());
        if (rayBin.second == bin.second)
        {
          Eigen::Vector3d& held = shortestOfRow.emplace(rayBin.first - bin.first, ray).first->second;
          if (ray.norm() < held.norm()) held = ray;
        }
        for (const int turn : {-parts, 0, parts}) keep(shortestOfPart, rayPart.second - part.second + turn);
      }
    }
    // Rays count that lie no farther away than the next ones to the left and to the right.
    const auto next = [&](int side)
    {
      int step = 0;
      while (step <= 10 && shortestOfPart.count(side * step) == 0) ++step;
      return side * (step + 1);
    };
    for (const int doubt : doubtfulParts)
      if (doubt >= next(-1) && doubt <= next(1)) doubtful = true;
    const double shortest = structure_.planar
                                ? shortestBeside(shortestOfPart)
                                : shortestAround(shortestOfRow, bin.first, inference_.fieldAngle);
    if (depth > 0 && within(depth + inference_.fieldDepth)) any.inField = true;
    // A share of the depth, in 1/255.
    const double share = depth > 0 ? std::min(shortest / depth * 255 + 1e-3, 255.0) : 0;
    if (depth > 0 && share < 255 && std::abs(share - std::round(share)) < 2e-3) doubtful = true;
    if (depth > 0 && within(depth * std::floor(share) / 255)) any.open = true;
  }
  return any;
}

/// Whether a ray of the model ended in the cell of the map that holds the point.
bool OverlappingOracle::isHit(const Model& model, const Eigen::Vector3d& point_map, bool& doubtful) const
{
  if (inference_.trainingPoints != HilbertPoints::Cells) return false;
  bool any = false;
  for (const Eigen::Vector3d& hit : model.hits_map)
  {
    bool same = true;
    bool onFace = false;
    for (int axis = 0; axis < (structure_.planar ? 2 : 3); ++axis)
    {
      const double low = std::floor(point_map[axis] / structure_.resolution) * structure_.resolution;
      const double inside = hit[axis] - low;
      same = same && inside > -kDoubt_m && inside < structure_.resolution + kDoubt_m;
      onFace = onFace || std::abs(inside) < kDoubt_m || std::abs(inside - structure_.resolution) < kDoubt_m;
    }
    doubtful = doubtful || (same && onFace);
    any = any || same;
  }
  return any;
}

OverlappingOracle::Answer OverlappingOracle::at(const Eigen::Vector3d& point_map) const
{
  Answer answer;
  double seen = 0;
  double unseen = 0;
  for (const Model& model : models_)
  {
    Eigen::Vector3d place = point_map;
    if (structure_.planar) place.z() = 0;
    Eigen::Vector3d p = model.pose.inverse() * place;
    if (structure_.planar) p.z() = structure_.latticeSpacing / 2;
    bool inBox = true;
    for (int axis = 0; axis < (structure_.planar ? 2 : 3); ++axis)
    {
      inBox = inBox && p[axis] >= model.low[axis] && p[axis] <= model.high[axis];
      for (const double face : {model.low[axis], model.high[axis]})
        if (std::abs(p[axis] - face) < kDoubt_m) answer.doubtful = true;
    }
    if (!inBox) continue;
    const double gamma = structure_.resolvedGamma();
    const bool compact = structure_.features == HilbertFeatures::Compact;
    double f = model.bias;
    bool reached = !compact;
    bool barely = false;
    for (const Kernel& kernel : model.kernels)
    {
      double k = std::exp(-gamma * (p - kernel.centre).squaredNorm());
      if (compact)
      {
        k -= structure_.cutoff;
        if (std::abs(k) < 1e-6) barely = true;
        if (k <= 0) continue;
        reached = reached || k > 1e-6;
      }
      f += kernel.weight * k;
    }
    if (isHit(model, point_map, answer.doubtful))
    {
      f = reached ? std::max(f, 1.0) : 1.0;
      reached = true;
    }
    if (!reached && barely) answer.doubtful = true;
    if (!reached) continue;
    const Seen by = lookAt(model, p, answer.doubtful);
    if (std::abs(f) < kDoubt_m) answer.doubtful = true;  // on the edge of being free
    if (by.inField && (f >= 0 || by.open))
    {
      answer.inField = true;
      seen += inference_.fieldWeight * f;
    }
    else if (structure_.outOfFieldLimit > 0)
    {
      answer.outOfField = true;
      unseen += f;
    }
  }
  const double limit = structure_.outOfFieldLimit;
  answer.logodds = answer.inField ? seen : std::clamp(unseen, -limit, limit);
  return answer;
}

}  // namespace lamap::test
