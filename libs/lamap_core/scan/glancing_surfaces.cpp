#include <lamap_core/scan/glancing_surfaces.h>

#include <algorithm>
#include <limits>
#include <tuple>

namespace lamap
{
namespace
{
constexpr float kNoReturn = std::numeric_limits<float>::infinity();

bool isBefore(const Eigen::Vector3d& a, const Eigen::Vector3d& b)
{
  return std::make_tuple(a.x(), a.y(), a.z()) < std::make_tuple(b.x(), b.y(), b.z());
}

bool isGlancing(const Eigen::Vector3d& a, const Eigen::Vector3d& b)
{
  const Eigen::Vector3d& farther = a.squaredNorm() > b.squaredNorm() ? a : b;
  const Eigen::Vector3d along = b - a;
  const double squaredSine = farther.cross(along).squaredNorm();
  const double squares = farther.squaredNorm() * along.squaredNorm();
  constexpr double kLeast = GlancingSurfaces::kLeastSine * GlancingSurfaces::kLeastSine;
  constexpr double kMost = GlancingSurfaces::kMostSine * GlancingSurfaces::kMostSine;
  return squaredSine >= kLeast * squares && squaredSine <= kMost * squares;
}

bool isStraight(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c)
{
  const Eigen::Vector3d one = b - a;
  const Eigen::Vector3d other = c - b;
  const double product = one.dot(other);
  constexpr double kLeast = GlancingSurfaces::kStraightCosine * GlancingSurfaces::kStraightCosine;
  return product > 0 && product * product >= kLeast * (one.squaredNorm() * other.squaredNorm());
}

}  // namespace

const std::vector<GlancingSurfaces::Piece>& GlancingSurfaces::of(const RayFan& fan)
{
  pieces_.clear();
  if (!fan.centre.allFinite()) return pieces_;
  sortIntoBins(fan);
  constexpr int kColumns = DirectionBin::kColumns;
  for (int row = 0; row < rows_; ++row)
    joinAlong(fan, static_cast<size_t>(row) * kColumns, 1, kColumns, 2 * kMostApart);
  if (rows_ > 1)
    for (size_t column = 0; column < kColumns; ++column) joinAlong(fan, column, kColumns, rows_, 0);
  return pieces_;
}

void GlancingSurfaces::sortIntoBins(const RayFan& fan)
{
  DirectionBin::ofAll(fan, bins_);
  int lowRow = DirectionBin::kRows;
  int highRow = -1;
  for (const DirectionBin& bin : bins_)
  {
    if (!bin.isSomewhere()) continue;
    lowRow = std::min(lowRow, bin.row);
    highRow = std::max(highRow, bin.row);
  }
  firstRow_ = lowRow;
  rows_ = std::max(highRow - lowRow + 1, 0);
  nearest_.assign(static_cast<size_t>(rows_) * DirectionBin::kColumns, {});
  for (uint32_t i = 0; i < bins_.size(); ++i)
  {
    if (!bins_[i].isSomewhere()) continue;
    Nearest& nearest = nearest_[static_cast<size_t>(bins_[i].row - firstRow_) * DirectionBin::kColumns +
                                static_cast<size_t>(bins_[i].column)];
    const bool hasReturn = fan.rays[i].meaning == RayEnd::Return;
    const float squaredRange =
        hasReturn ? static_cast<float>((fan.rays[i].end - fan.centre).squaredNorm()) : kNoReturn;
    const bool isNearer = nearest.squaredRange == 0 || squaredRange < nearest.squaredRange ||
                          (squaredRange == nearest.squaredRange && hasReturn &&
                           isBefore(fan.rays[i].end, fan.rays[nearest.ray].end));
    if (isNearer) nearest = {squaredRange, i};
  }
}

/** Joins the returns along a row or a column.
 * @param overlap bins that are met again before the first and behind the last, where a line goes round */
void GlancingSurfaces::joinAlong(const RayFan& fan, size_t firstBin, size_t step, int count, int overlap)
{
  run_.clear();
  int apart = 0;
  for (int i = -overlap; i < count + overlap; ++i)
  {
    ++apart;
    const Nearest& nearest = nearest_[firstBin + step * static_cast<size_t>((i + count) % count)];
    if (nearest.squaredRange == 0) continue;
    if (apart > kMostApart || nearest.squaredRange == kNoReturn) joinRun(fan.centre);
    apart = 0;
    if (nearest.squaredRange == kNoReturn) continue;
    run_.push_back({fan.rays[nearest.ray].end - fan.centre, i >= 0 && i < count});
  }
  joinRun(fan.centre);
}

/// Joins the returns of the run and forgets it.
void GlancingSurfaces::joinRun(const Eigen::Vector3d& centre)
{
  for (size_t i = 0; i + 1 < run_.size(); ++i)
  {
    const Eigen::Vector3d& begin = run_[i].end;
    const Eigen::Vector3d& end = run_[i + 1].end;
    if (!run_[i].isCounted || !isGlancing(begin, end)) continue;
    const bool goesOn = (i > 0 && isStraight(run_[i - 1].end, begin, end)) ||
                        (i + 2 < run_.size() && isStraight(begin, end, run_[i + 2].end));
    if (goesOn) pieces_.push_back({centre + begin, centre + end});
  }
  run_.clear();
}

}  // namespace lamap
