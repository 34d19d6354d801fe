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
    for (const Ray& ray : fan.rays)
    {
      if (ray.meaning == RayEnd::Return && !ray.end.allFinite())
      {
        ++look.notFinite;
        continue;
      }
      ++look.rays[static_cast<size_t>(ray.meaning)];
      if (ray.meaning == RayEnd::Return) ranges_m.push_back((ray.end - fan.centre).norm());
    }
  }
  if (ranges_m.empty()) return look;
  const auto [shortest, longest] = std::minmax_element(ranges_m.begin(), ranges_m.end());
  look.ranges = LengthSpan{*shortest, *longest};
  constexpr double kSame = 0.999;
  look.farthestReturns = static_cast<uint64_t>(std::count_if(
      ranges_m.begin(), ranges_m.end(), [&](double range_m) { return range_m >= kSame * *longest; }));
  return look;
}

}  // namespace lamap::tools
