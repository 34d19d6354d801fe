#include <lamap_core/options/shared_options.h>
#include <lamap_core/scan/open_space.h>
#include <lamap_core/scan/ray_selection.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

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

/// The smaller of two maximum ranges; infinite where neither is stated.
double smallerRange(double one_m, double other_m)
{
  double smaller_m = std::numeric_limits<double>::infinity();
  for (const double range_m : {one_m, other_m})
    if (range_m > 0) smaller_m = std::min(smaller_m, range_m);
  return smaller_m;
}

/// Selects the rays of one fan.
class FanSelector
{
 public:
  FanSelector(const RayFan& fan, const RangeOptions& limits, double longest_m, RayCounts& counts)
      : min_m_(std::max(limits.minRange, fan.statedRangeMin_m)),
        max_m_(smallerRange(limits.maxRange, fan.statedRangeMax_m)),
        longest_m_(longest_m),
        openSpace_(limits.considerInvalidRangesAsFreeSpace ? std::make_optional<OpenSpace>(fan, min_m_)
                                                           : std::nullopt),
        counts_(counts)
  {
    selected.centre = fan.centre;
    selected.beam = fan.beam;
    selected.statedRangeMin_m = min_m_;
    selected.statedRangeMax_m = std::isfinite(max_m_) ? max_m_ : 0;
  }

  void add(const Ray& ray)
  {
    switch (ray.meaning)
    {
      case RayEnd::Return:
        return addReturn(ray);
      case RayEnd::NoReturn:
        return addNoReturn(ray);
      case RayEnd::Cut:
        return addCut(ray);
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
    if (isTooLong(std::min(range, max_m_))) return;
    if (range > max_m_)
    {
      selected.rays.push_back({fromCentre * (max_m_ / range), RayEnd::Cut, ray.echo});
      return count(counts_.freeOnly);
    }
    selected.rays.push_back(ray);
    count(counts_.hits);
  }

  void addNoReturn(const Ray& ray)
  {
    if (!isDirection(ray)) return;
    if (!openSpace_) return count(counts_.unbounded);
    const double length_m = std::min(max_m_, openSpace_->reach_m(ray.end));
    if (!std::isfinite(length_m)) return count(counts_.unbounded);
    if (isTooLong(length_m)) return;
    addFree(ray, length_m);
    count(counts_.noReturn);
    counts_.noReturnLength_m += length_m;
    counts_.noReturnLongest_m = std::max(counts_.noReturnLongest_m, length_m);
  }

  void addCut(const Ray& ray)
  {
    if (!isDirection(ray)) return;
    const double length_m = std::min(max_m_, ray.end.norm());
    if (!isTooLong(length_m)) addFree(ray, length_m);
  }

  /// Counts the ray if it has no direction.
  bool isDirection(const Ray& ray)
  {
    const bool isFinite = ray.end.allFinite();
    const bool isLong = isFinite && !ray.end.isZero(0);
    if (!isLong) count(isFinite ? counts_.tooNear : counts_.notFinite);
    return isLong;
  }

  /// Counts the ray if it is.
  bool isTooLong(double length_m)
  {
    if (length_m <= longest_m_) return false;
    count(counts_.tooLong);
    counts_.tooLongLongest_m = std::max(counts_.tooLongLongest_m, length_m);
    return true;
  }

  void addFree(const Ray& ray, double length_m)
  {
    // Any length will do: divided by the largest part first, so that no square is too small or too large.
    const Eigen::Vector3d scaled = ray.end / ray.end.cwiseAbs().maxCoeff();
    selected.rays.push_back({scaled.normalized() * length_m, ray.meaning, ray.echo});
    count(counts_.freeOnly);
  }

  static void count(size_t& counter) { ++counter; }

  double min_m_;
  double max_m_;
  double longest_m_;
  std::optional<OpenSpace> openSpace_;  ///< nothing: rays without return are not wanted
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
               "hits and free space end here, or at the range that the observation states if that is less; "
               "0: only there")
          .add("considerInvalidRangesAsFreeSpace", &Self::considerInvalidRangesAsFreeSpace, plain(),
               "rays without a return are free up to the maximum range, but not beyond the returns beside "
               "them")
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
  tooLong += other.tooLong;
  outside += other.outside;
  noReturn += other.noReturn;
  narrowed += other.narrowed;
  noReturnLength_m += other.noReturnLength_m;
  noReturnLongest_m = std::max(noReturnLongest_m, other.noReturnLongest_m);
  tooLongLongest_m = std::max(tooLongLongest_m, other.tooLongLongest_m);
  return *this;
}

Eigen::Vector3d SelectedRays::firstCentre_map() const
{
  for (const RayFan& fan : scan.fans)
    if (!fan.rays.empty()) return scan.inMap(fan.centre);
  return scan.sensorPose_map.translation();
}

SelectedRays selectRays(const Scan& scan, const RangeOptions& limits, std::optional<double> resolution_m)
{
  requireLegalOptions(limits, std::nullopt);
  scan.requireRigidPose();

  SelectedRays rays;
  rays.scan.sensorPose_map = scan.sensorPose_map;
  rays.scan.poseCovariance = scan.poseCovariance;
  const bool hasPose = scan.sensorPose_map.matrix().allFinite();
  const double longest_m =
      resolution_m ? kLongestRay_cells * *resolution_m : std::numeric_limits<double>::infinity();
  uint32_t untilNext = 0;
  for (const RayFan& fan : scan.fans)
  {
    if (!isLegalBeam(fan.beam))
      throw std::invalid_argument(
          "the beam of a scan has an angle, a deviation or an axis that is not legal");
    FanSelector selector(fan, limits, longest_m, rays.counts);
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
