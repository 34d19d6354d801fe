#include <lamap_tools/inputs/scan_look.h>

#include <algorithm>
#include <numeric>
#include <vector>

namespace lamap::tools
{
namespace
{
void extend(std::optional<LengthSpan>& span, const LengthSpan& other)
{
  if (span)
    span->include(other);
  else
    span = other;
}

/// What a ray counts as. @param range_m  from the centre of its fan
RayEnd meaningOf(const Ray& ray, double range_m, const RayFan& fan)
{
  if (ray.meaning != RayEnd::Return) return ray.meaning;
  if (!(range_m > 0) || range_m < fan.statedRangeMin_m) return RayEnd::TooNear;
  const bool isBeyond = fan.statedRangeMax_m > 0 && range_m > fan.statedRangeMax_m;
  return isBeyond ? RayEnd::Cut : RayEnd::Return;
}
}  // namespace

void LengthSpan::include(const LengthSpan& other)
{
  shortest_m = std::min(shortest_m, other.shortest_m);
  longest_m = std::max(longest_m, other.longest_m);
}

uint64_t ScanLook::rayCount() const
{
  return std::accumulate(rays.begin(), rays.end(), notFinite);
}

bool ScanLook::hasPhantomShell() const
{
  constexpr uint64_t kFewestReturns = 100;
  constexpr uint64_t kTwentieth = 20;
  const bool isLimited = statedRanges && statedRanges->longest_m > 0;
  return !isLimited && count(RayEnd::Return) >= kFewestReturns &&
         farthestReturns * kTwentieth >= count(RayEnd::Return);
}

ScanLook lookAt(const Scan& scan)
{
  ScanLook look;
  std::vector<double> ranges_m;
  for (const RayFan& fan : scan.fans)
  {
    if (fan.statedRangeMin_m > 0 || fan.statedRangeMax_m > 0)
      extend(look.statedRanges, {fan.statedRangeMin_m, fan.statedRangeMax_m});
    look.beamWidth_rad = std::max(look.beamWidth_rad, 2 * fan.beam.halfWidth_rad);
    look.beamHeight_rad = std::max(look.beamHeight_rad, 2 * fan.beam.halfHeight_rad);
    for (const Ray& ray : fan.rays)
    {
      if (ray.meaning == RayEnd::Return && !ray.end.allFinite())
      {
        ++look.notFinite;
        continue;
      }
      const double range_m = (ray.end - fan.centre).norm();
      const RayEnd meaning = meaningOf(ray, range_m, fan);
      ++look.rays[static_cast<size_t>(meaning)];
      if (meaning == RayEnd::Return) ranges_m.push_back(range_m);
    }
  }
  if (ranges_m.empty()) return look;
  const auto [shortest, longest] = std::minmax_element(ranges_m.begin(), ranges_m.end());
  look.ranges = LengthSpan{*shortest, *longest};
  const double alike_m = 0.999 * look.ranges->longest_m;
  look.farthestReturns = static_cast<uint64_t>(
      std::count_if(ranges_m.begin(), ranges_m.end(), [&](double range_m) { return range_m >= alike_m; }));
  return look;
}

bool isWorthALook(size_t number)
{
  constexpr size_t kFirst = 10;
  constexpr size_t kEvery = 20;
  return number < kFirst || number % kEvery == 0;
}

void PhantomShells::add(const ScanLook& look)
{
  if (!look.ranges) return;
  ++scans_;
  if (look.hasPhantomShell()) ranges_m_.push_back(look.ranges->longest_m);
}

std::optional<double> PhantomShells::nearest_m() const
{
  std::vector<double> sorted_m = ranges_m_;
  std::sort(sorted_m.begin(), sorted_m.end());
  constexpr double kSame = 1.005;
  for (auto first = sorted_m.begin(); first != sorted_m.end(); ++first)
  {
    const auto last = std::upper_bound(first, sorted_m.end(), kSame * *first);
    if (4 * static_cast<size_t>(last - first) >= scans_) return *first;
  }
  return std::nullopt;
}

void EmptyScans::add(uint64_t returns, uint64_t missing)
{
  constexpr uint64_t kForEachReturn = 9;
  ++scans;
  if (missing == 0 || missing < kForEachReturn * returns) return;
  ++(returns == 0 ? empty : nearlyEmpty);
}

}  // namespace lamap::tools
