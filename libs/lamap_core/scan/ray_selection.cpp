#include <lamap_core/scan/ray_selection.h>

#include <lamap_core/options/shared_options.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace lamap
{
namespace
{
/// Coordinates beyond this [m] are no places on a map; differences and squares of smaller ones are exact
/// enough.
constexpr double kMaxCoordinate_m = 1e12;

bool isPlace(const Eigen::Vector3d& point)
{
  return (point.array().abs() <= kMaxCoordinate_m).all();  // false for NaN
}

/// Selects the rays of one fan.
class FanSelector
{
 public:
  FanSelector(const RayFan& fan, const RangeOptions& limits, RayCounts& counts)
      : min_m_(std::max(limits.minRange, fan.statedRangeMin_m)),
        max_m_(limits.maxRange > 0 ? limits.maxRange : fan.statedRangeMax_m),
        noReturnIsFree_(limits.considerInvalidRangesAsFreeSpace),
        counts_(counts)
  {
    selected.centre = fan.centre;
    selected.beam = fan.beam;
    selected.statedRangeMin_m = min_m_;
    selected.statedRangeMax_m = max_m_ > 0 ? max_m_ : 0;
    if (!(max_m_ > 0)) max_m_ = std::numeric_limits<double>::infinity();
  }

  void add(const Ray& ray)
  {
    switch (ray.meaning)
    {
      case RayEnd::Return:
        return addReturn(ray);
      case RayEnd::NoReturn:
        return addFree(ray, max_m_);
      case RayEnd::Cut:
        return addFree(ray, std::min(max_m_, ray.end.norm()));
      case RayEnd::Dropped:
        return count(counts_.dropped);
      case RayEnd::TooNear:
        return count(counts_.tooNear);
    }
  }

  RayFan selected;

 private:
  void addReturn(const Ray& ray)
  {
    if (!ray.end.allFinite()) return count(counts_.notFinite);
    if (!isPlace(ray.end)) return count(counts_.outside);
    const Eigen::Vector3d fromCentre = ray.end - selected.centre;
    const double range = fromCentre.norm();
    if (!(range > 0) || range < min_m_) return count(counts_.tooNear);
    if (range > max_m_)
    {
      selected.rays.push_back({fromCentre * (max_m_ / range), RayEnd::Cut, ray.echo});
      return count(counts_.freeOnly);
    }
    selected.rays.push_back(ray);
    count(counts_.hits);
  }

  void addFree(const Ray& ray, double length_m)
  {
    if (!ray.end.allFinite()) return count(counts_.notFinite);
    const double largest = ray.end.cwiseAbs().maxCoeff();
    if (!(largest > 0)) return count(counts_.tooNear);
    const bool isWanted = noReturnIsFree_ || ray.meaning == RayEnd::Cut;
    if (!isWanted || !std::isfinite(length_m)) return count(counts_.unbounded);
    // Any length will do: divided by the largest part first, so that no square is too small or too large.
    selected.rays.push_back({(ray.end / largest).normalized() * length_m, ray.meaning, ray.echo});
    count(counts_.freeOnly);
  }

  static void count(size_t& counter) { ++counter; }

  double min_m_;
  double max_m_;
  bool noReturnIsFree_;
  RayCounts& counts_;
};

}  // namespace

const OptionTable& RangeOptions::optionTable()
{
  using Self = RangeOptions;
  static const OptionTable table =
      OptionTableOf<Self>("insertOpts")
          .add("minRange", &Self::minRange, metres().from(0).to(kMetresMost), "closer returns are ignored")
          .add("maxRange", &Self::maxRange, metres().above(0).to(kMetresMost).orZero().exceeds("minRange"),
               "hits and free space end here; 0: the range that the observation states, if any")
          .add("considerInvalidRangesAsFreeSpace", &Self::considerInvalidRangesAsFreeSpace, plain(),
               "rays without a return are free up to the maximum range")
          .add("rayDecimation", &Self::rayDecimation, plain().from(1).to(kWholeMost),
               "use every Nth ray of an observation");
  return table;
}

RayCounts& RayCounts::operator+=(const RayCounts& other)
{
  hits += other.hits;
  freeOnly += other.freeOnly;
  decimated += other.decimated;
  dropped += other.dropped;
  notFinite += other.notFinite;
  tooNear += other.tooNear;
  unbounded += other.unbounded;
  outside += other.outside;
  return *this;
}

Eigen::Vector3d SelectedRays::firstCentre_map() const
{
  for (const RayFan& fan : scan.fans)
    if (!fan.rays.empty()) return scan.inMap(fan.centre);
  return scan.sensorPose_map.translation();
}

SelectedRays selectRays(const Scan& scan, const RangeOptions& limits)
{
  requireLegalOptions(limits, std::nullopt);

  SelectedRays rays;
  rays.scan.sensorPose_map = scan.sensorPose_map;
  rays.scan.poseCovariance = scan.poseCovariance;
  const bool hasPose = scan.sensorPose_map.matrix().allFinite();
  uint32_t untilNext = 0;
  for (const RayFan& fan : scan.fans)
  {
    FanSelector selector(fan, limits, rays.counts);
    selector.selected.rays.reserve(fan.rays.size() / limits.rayDecimation + 1);
    const bool isFinite = hasPose && fan.centre.allFinite();
    const bool isUsable = isFinite && isPlace(fan.centre) && isPlace(scan.inMap(fan.centre));
    size_t& lost = isFinite ? rays.counts.outside : rays.counts.notFinite;
    for (const Ray& ray : fan.rays)
    {
      const bool skipped = untilNext != 0;
      untilNext = skipped ? untilNext - 1 : limits.rayDecimation - 1;
      if (skipped)
        ++rays.counts.decimated;
      else if (isUsable)
        selector.add(ray);
      else
        ++lost;
    }
    rays.scan.fans.push_back(std::move(selector.selected));
  }
  return rays;
}

}  // namespace lamap
