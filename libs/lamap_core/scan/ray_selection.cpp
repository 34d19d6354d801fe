#include <lamap_core/scan/ray_selection.h>

#include <lamap_core/options/legal_range.h>

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
  FanSelector(const RayFan& fan, const RangeLimits& limits, RayCounts& counts)
      : min_m_(std::max(limits.min_m, fan.statedRangeMin_m)),
        max_m_(limits.max_m > 0 ? limits.max_m : fan.statedRangeMax_m),
        noReturnIsFree_(limits.noReturnIsFree),
        counts_(counts)
  {
    selected.origin_map = fan.origin_map;
    if (!(max_m_ > 0)) max_m_ = std::numeric_limits<double>::infinity();
  }

  void addReturn(const Eigen::Vector3d& end)
  {
    if (!end.allFinite()) return count(counts_.notFinite);
    if (!isPlace(end)) return count(counts_.outside);
    const Eigen::Vector3d ray = end - selected.origin_map;
    const double range = ray.norm();
    if (!(range > 0) || range < min_m_) return count(counts_.tooNear);
    if (range > max_m_)
    {
      selected.freeRays_map.push_back(ray * (max_m_ / range));
      return count(counts_.freeOnly);
    }
    selected.hitEnds_map.push_back(end);
    count(counts_.hits);
  }

  void addNoReturn(const Eigen::Vector3d& direction)
  {
    if (!direction.allFinite()) return count(counts_.notFinite);
    const double largest = direction.cwiseAbs().maxCoeff();
    if (!(largest > 0)) return count(counts_.tooNear);
    if (!noReturnIsFree_ || !std::isfinite(max_m_)) return count(counts_.unbounded);
    // Any length will do: divided by the largest part first, so that no square is too small or too large.
    selected.freeRays_map.push_back((direction / largest).normalized() * max_m_);
    count(counts_.freeOnly);
  }

  SelectedFan selected;

 private:
  static void count(size_t& counter) { ++counter; }

  double min_m_;
  double max_m_;
  bool noReturnIsFree_;
  RayCounts& counts_;
};

}  // namespace

void RangeLimits::validate() const
{
  requireLegal(min_m >= 0 && std::isfinite(min_m), "minRange", min_m, "a finite number >= 0");
  requireLegal(max_m >= 0 && std::isfinite(max_m), "maxRange", max_m, "a finite number >= 0");
  requireLegal(max_m == 0 || max_m > min_m, "maxRange", max_m,
               "0, or more than minRange, " + shortText(min_m));
  requireLegal(decimation >= 1, "rayDecimation", decimation, "a whole number >= 1");
}

RayCounts& RayCounts::operator+=(const RayCounts& other)
{
  hits += other.hits;
  freeOnly += other.freeOnly;
  decimated += other.decimated;
  notFinite += other.notFinite;
  tooNear += other.tooNear;
  unbounded += other.unbounded;
  outside += other.outside;
  return *this;
}

SelectedRays selectRays(const Scan& scan, const RangeLimits& limits)
{
  limits.validate();

  SelectedRays rays;
  uint32_t untilNext = 0;
  const auto decimated = [&]
  {
    const bool skip = untilNext != 0;
    untilNext = skip ? untilNext - 1 : limits.decimation - 1;
    if (skip) ++rays.counts.decimated;
    return skip;
  };
  for (const RayFan& fan : scan.fans)
  {
    FanSelector selector(fan, limits, rays.counts);
    const bool usable = isPlace(fan.origin_map);
    size_t& lost = fan.origin_map.allFinite() ? rays.counts.outside : rays.counts.notFinite;
    selector.selected.hitEnds_map.reserve(fan.returns_map.size() / limits.decimation + 1);
    for (const Eigen::Vector3d& end : fan.returns_map)
    {
      if (decimated()) continue;
      if (usable)
        selector.addReturn(end);
      else
        ++lost;
    }
    for (const Eigen::Vector3d& direction : fan.noReturnDirections_map)
    {
      if (decimated()) continue;
      if (usable)
        selector.addNoReturn(direction);
      else
        ++lost;
    }
    rays.fans.push_back(std::move(selector.selected));
  }
  return rays;
}

CellIndex anchorOf(const SelectedRays& rays, double resolution_m)
{
  for (const SelectedFan& fan : rays.fans)
  {
    if (!fan.origin_map.allFinite()) continue;
    if (const auto cell = cellAt(fan.origin_map, resolution_m)) return *cell;
  }
  return {};
}

}  // namespace lamap
