#include <lamap_core/scan/direction_angles.h>
#include <lamap_core/scan/open_space.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace lamap
{
namespace
{
constexpr int kColumns = 360;
constexpr int kAllRows = 180;
constexpr int kGap = 30;  ///< this many bins without any ray end a run
constexpr float kNone = std::numeric_limits<float>::infinity();

bool isDirection(const Eigen::Vector3d& v)
{
  return v.allFinite() && !v.isZero(0);
}

bool contains(const RayFan& fan, RayEnd meaning)
{
  return std::any_of(fan.rays.begin(), fan.rays.end(),
                     [&](const Ray& ray) { return ray.meaning == meaning; });
}

}  // namespace

OpenSpace::OpenSpace(const RayFan& fan, double rangeMin_m)
{
  if (!fan.centre.allFinite() || !contains(fan, RayEnd::NoReturn) || !contains(fan, RayEnd::Return)) return;
  std::vector<Seen> seen;
  seen.reserve(fan.rays.size());
  for (const Ray& ray : fan.rays)
  {
    const bool hasReturn = ray.meaning == RayEnd::Return;
    const Eigen::Vector3d direction = hasReturn ? Eigen::Vector3d(ray.end - fan.centre) : ray.end;
    if (!isDirection(direction)) continue;
    const double range_m = hasReturn ? direction.norm() : 0;
    const bool isBound = range_m > 0 && range_m >= rangeMin_m;
    seen.push_back({binOf(direction), isBound ? static_cast<float>(range_m) : kNone});
  }
  fill(seen);
}

OpenSpace OpenSpace::between(const std::vector<Eigen::Vector3d>& ends)
{
  std::vector<Seen> seen;
  seen.reserve(ends.size());
  for (const Eigen::Vector3d& end : ends)
    if (isDirection(end)) seen.push_back({binOf(end), static_cast<float>(end.norm())});
  OpenSpace space;
  space.fill(seen);
  for (int row = 0; row < space.rows_; ++row)
    for (int column = 0; column < kColumns; ++column)
    {
      const Bin bin{space.firstRow_ + row, column};
      space.reaches_m_[space.placeOf(bin)] = space.findReach(bin);
    }
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
  firstRow_ = lowRow;
  rows_ = highRow - lowRow + 1;
  returns_m_.assign(static_cast<size_t>(rows_) * kColumns, 0);
  reaches_m_ = returns_m_;
  for (const Seen& one : seen)
  {
    float& nearest = returns_m_[placeOf(one.bin)];
    nearest = nearest == 0 ? one.range_m : std::min(nearest, one.range_m);
  }
}

OpenSpace::Bin OpenSpace::binOf(const Eigen::Vector3d& direction)
{
  // Scaled, so that no square is too small or too large.
  const Eigen::Vector3f v = (direction / direction.cwiseAbs().maxCoeff()).cast<float>();
  const float xx = v.x() * v.x();
  const float yy = v.y() * v.y();
  const Eigen::Array4f angles = anglesOf({v.y(), v.z(), 0, 0}, {v.x(), std::sqrt(xx + yy), 0, 0});
  constexpr auto kDegree = static_cast<float>(3.141592653589793 / 180);
  // Whole degrees stand in the middle of a bin: sensors like them.
  const auto binAlong = [&](int angle, float lowest_deg, int count)
  { return std::clamp(static_cast<int>(std::floor(angles[angle] / kDegree - lowest_deg + 0.5F)), 0, count); };
  return {binAlong(1, -90, kAllRows), binAlong(0, -180, kColumns) % kColumns};
}

size_t OpenSpace::placeOf(const Bin& bin) const
{
  return static_cast<size_t>(bin.row - firstRow_) * kColumns + static_cast<size_t>(bin.column);
}

bool OpenSpace::isInside(const Bin& bin) const
{
  return bin.row >= firstRow_ && bin.row < firstRow_ + rows_;
}

bool OpenSpace::hasReturn(const Bin& bin) const
{
  const float range_m = returns_m_[placeOf(bin)];
  return range_m > 0 && range_m < kNone;
}

/// Range of the first return on the way in steps of one bin.
float OpenSpace::firstReturn(Bin bin, int rowStep, int columnStep) const
{
  bin.row =
      std::clamp(bin.row, firstRow_ - 1, firstRow_ + rows_);  // just outside, from where a step leads in
  int gap = 0;
  for (int i = 1; i < kColumns && gap <= kGap; ++i)
  {
    bin = {bin.row + rowStep, (bin.column + columnStep + kColumns) % kColumns};
    if (!isInside(bin)) break;
    if (hasReturn(bin)) return returns_m_[placeOf(bin)];
    gap = returns_m_[placeOf(bin)] == 0 ? gap + 1 : 0;
  }
  return kNone;
}

float OpenSpace::aboveOrBelow(const Bin& bin) const
{
  return std::min(firstReturn(bin, 1, 0), firstReturn(bin, -1, 0));
}

/// The returns above and below the row of a bin, in the first column beside it that has any.
float OpenSpace::besideIn(Bin bin, int columnStep) const
{
  float nearest = kNone;
  for (int i = 1; i < kColumns && nearest == kNone; ++i)
  {
    bin.column = (bin.column + columnStep + kColumns) % kColumns;
    nearest = aboveOrBelow(bin);
  }
  return nearest;
}

float OpenSpace::findReach(const Bin& bin) const
{
  if (isInside(bin) && hasReturn(bin)) return returns_m_[placeOf(bin)];
  const float around = std::min({firstReturn(bin, 0, 1), firstReturn(bin, 0, -1), aboveOrBelow(bin)});
  return around < kNone ? around : std::min(besideIn(bin, 1), besideIn(bin, -1));
}

double OpenSpace::reach_m(const Eigen::Vector3d& direction)
{
  if (rows_ == 0) return kNone;
  const Bin bin = binOf(direction);
  if (!isInside(bin)) return findReach(bin);
  float& reach = reaches_m_[placeOf(bin)];
  if (reach == 0) reach = findReach(bin);
  return reach;
}

bool OpenSpace::reaches(const Eigen::Vector3d& place) const
{
  if (rows_ == 0) return false;
  const Bin bin = binOf(place);
  return place.norm() <= static_cast<double>(isInside(bin) ? reaches_m_[placeOf(bin)] : findReach(bin));
}

}  // namespace lamap
