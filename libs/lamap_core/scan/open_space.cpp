#include <lamap_core/scan/open_space.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace lamap
{
namespace
{
constexpr int kColumns = DirectionBin::kColumns;
constexpr int kAllRows = DirectionBin::kRows - 1;
constexpr int kGap = 30;  ///< this many bins without any ray end a run
constexpr float kNone = std::numeric_limits<float>::infinity();
constexpr float kUnasked = 0;  ///< of a bin without any ray

bool contains(const RayFan& fan, RayEnd meaning)
{
  return std::any_of(fan.rays.begin(), fan.rays.end(),
                     [&](const Ray& ray) { return ray.meaning == meaning; });
}

}  // namespace

OpenSpace::OpenSpace(const RayFan& fan, double rangeMin_m)
{
  if (!fan.centre.allFinite() || !contains(fan, RayEnd::NoReturn) || !contains(fan, RayEnd::Return)) return;
  std::vector<DirectionBin> bins;
  DirectionBin::ofAll(fan, bins);
  std::vector<Seen> seen;
  seen.reserve(bins.size());
  for (size_t i = 0; i < bins.size(); ++i)
  {
    if (!bins[i].isSomewhere()) continue;
    const Ray& ray = fan.rays[i];
    const double range_m = ray.meaning == RayEnd::Return ? fan.directionOf(ray).norm() : 0;
    const bool isBound = range_m > 0 && range_m >= rangeMin_m;
    seen.push_back({bins[i], isBound ? static_cast<float>(range_m) : kNone});
  }
  fill(seen);
}

OpenSpace OpenSpace::between(const std::vector<Eigen::Vector3d>& ends)
{
  std::vector<DirectionBin> bins;
  DirectionBin::ofAll(
      ends.size(), [&](size_t i) { return ends[i]; }, bins);
  std::vector<Seen> seen;
  seen.reserve(ends.size());
  for (size_t i = 0; i < ends.size(); ++i)
    if (bins[i].isSomewhere()) seen.push_back({bins[i], static_cast<float>(ends[i].norm())});
  OpenSpace space;
  space.fill(seen);
  return space;
}

void OpenSpace::fill(const std::vector<Seen>& seen)
{
  if (seen.empty()) return;
  int lowRow = kAllRows;
  int highRow = 0;
  for (const Seen& one : seen)
  {
    lowRow = std::min(lowRow, one.bin.row);
    highRow = std::max(highRow, one.bin.row);
  }
  // An empty row below and one above stand for all directions beyond.
  firstRow_ = lowRow - 1;
  rows_ = highRow - lowRow + 3;
  std::vector<float> returns_m(static_cast<size_t>(rows_) * kColumns, kUnasked);
  for (const Seen& one : seen)
  {
    float& nearest = returns_m[placeOf(one.bin)];
    nearest = nearest == kUnasked ? one.range_m : std::min(nearest, one.range_m);
  }
  findReaches(returns_m);
}

/// In each bin the first return on the way from it, bin by bin against the step.
std::vector<float> OpenSpace::firstReturns(const std::vector<float>& returns_m, int rowStep,
                                           int columnStep) const
{
  std::vector<float> found_m(returns_m.size(), kNone);
  const bool alongRows = columnStep != 0;
  const int lines = alongRows ? rows_ : kColumns;
  const int count = alongRows ? 2 * kColumns : rows_;  // twice round, so that the way goes on where it began
  for (int line = 0; line < lines; ++line)
  {
    float nearest = kNone;
    int gap = 0;
    for (int i = 0; i < count; ++i)
    {
      const int forward = alongRows ? i % kColumns : i;
      const int last = (alongRows ? kColumns : rows_) - 1;
      const int at = rowStep + columnStep > 0 ? last - forward : forward;
      const size_t place =
          static_cast<size_t>(alongRows ? line : at) * kColumns + static_cast<size_t>(alongRows ? at : line);
      if (gap > kGap) nearest = kNone;
      found_m[place] = nearest;
      const float range_m = returns_m[place];
      if (range_m > kUnasked && range_m < kNone) nearest = range_m;
      gap = range_m == kUnasked ? gap + 1 : 0;
    }
  }
  return found_m;
}

void OpenSpace::findReaches(const std::vector<float>& returns_m)
{
  const auto least = [](std::vector<float> one, const std::vector<float>& other)
  {
    std::transform(one.begin(), one.end(), other.begin(), one.begin(),
                   [](float a, float b) { return std::min(a, b); });
    return one;
  };
  const std::vector<float> upright = least(firstReturns(returns_m, 1, 0), firstReturns(returns_m, -1, 0));
  reaches_m_ = least(least(firstReturns(returns_m, 0, 1), firstReturns(returns_m, 0, -1)), upright);
  for (size_t i = 0; i < reaches_m_.size(); ++i)
    if (returns_m[i] > kUnasked && returns_m[i] < kNone) reaches_m_[i] = returns_m[i];
  // Where nothing lies in the bin's row and column: above and below the row, in the first columns beside it.
  const std::vector<float> around_m = reaches_m_;
  for (int row = 0; row < rows_; ++row)
    for (const bool rightwards : {true, false})
    {
      float nearest = kNone;
      for (int i = 0; i < 2 * kColumns; ++i)
      {
        const int column = rightwards ? i % kColumns : kColumns - 1 - i % kColumns;
        const size_t place = static_cast<size_t>(row) * kColumns + static_cast<size_t>(column);
        if (upright[place] < kNone)
          nearest = upright[place];
        else if (i >= kColumns && around_m[place] == kNone)
          reaches_m_[place] = std::min(reaches_m_[place], nearest);
      }
    }
}

size_t OpenSpace::placeOf(const DirectionBin& bin) const
{
  const int row = std::clamp(bin.row - firstRow_, 0, rows_ - 1);
  return static_cast<size_t>(row) * kColumns + static_cast<size_t>(bin.column);
}

double OpenSpace::reach_m(const Eigen::Vector3d& direction) const
{
  return rows_ == 0 ? kNone : reaches_m_[placeOf(DirectionBin::of(direction))];
}

bool OpenSpace::reaches(const Eigen::Vector3d& place) const
{
  if (rows_ == 0) return false;
  return !DirectionBin::hasOne(place) || place.norm() <= reach_m(place);
}

}  // namespace lamap
