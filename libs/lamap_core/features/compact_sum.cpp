#include <lamap_core/features/compact_sum.h>

#include <algorithm>
#include <cmath>

namespace lamap
{
namespace
{
using Four = Eigen::Array4f;
constexpr int kTileEdge = 8;  ///< points along each axis that share one box of weights

CellIndex plus(const CellIndex& a, const CellIndex& b)
{
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}

/// The sum at regular points, tile by tile.
class RegularSum
{
 public:
  RegularSum(const SiteWeights& weights, const CompactKernel& kernel, double spacing_m, bool planar)
      : weights_(weights), kernel_(kernel), planar_(planar), reaches_(kernel, spacing_m)
  {
  }
  void at(const CellIndex& anchorSite, const RegularPoints& points, std::vector<ReachedLogodds>& out);

 private:
  struct Row
  {
    float yz;      ///< factor of the kernel
    size_t begin;  ///< of the row in the box
  };

  void windowsOf(const Eigen::Vector3d& first, double step, const std::array<int, 3>& counts);
  void listRows(const AxisWindow& y, const AxisWindow& z, float largestX);
  [[nodiscard]] ReachedLogodds sumRows(const AxisWindow& x) const;
  [[nodiscard]] bool reaches(const AxisWindow& x) const;
  void tileAt(const CellIndex& anchorSite, const RegularPoints& points, const std::array<int, 3>& from,
              const std::array<int, 3>& counts, std::vector<ReachedLogodds>& out);

  const SiteWeights& weights_;
  const CompactKernel& kernel_;
  bool planar_;
  AxisReaches reaches_;
  SiteBox box_;
  std::vector<Row> rows_;
  std::array<std::vector<AxisWindow>, 3> windows_;
  std::array<std::vector<AxisReach>, 3> held_;  ///< what windows_ point at
};

void RegularSum::windowsOf(const Eigen::Vector3d& first, double step, const std::array<int, 3>& counts)
{
  for (int axis = 0; axis < 3; ++axis)
  {
    const auto a = static_cast<size_t>(axis);
    windows_[a].clear();
    held_[a].resize(static_cast<size_t>(counts[a]));
    for (size_t i = 0; i < held_[a].size(); ++i)
    {
      const AxisWindow window = planar_ && axis == 2
                                    ? AxisReaches::flat()
                                    : reaches_.of(first[axis] + static_cast<double>(i) * step);
      held_[a][i] = *window.reach;
      windows_[a].push_back({window.first, &held_[a][i]});
    }
  }
}

void RegularSum::listRows(const AxisWindow& y, const AxisWindow& z, float largestX)
{
  rows_.clear();
  for (int32_t k = 0; k < z.count(); ++k)
    for (int32_t j = 0; j < y.count(); ++j)
    {
      const float yz = y.factor(j) * z.factor(k);
      if (kernel_.fromFactors(yz, largestX) > 0) rows_.push_back({yz, box_.rowOf(y.first + j, z.first + k)});
    }
}

ReachedLogodds RegularSum::sumRows(const AxisWindow& x) const
{
  const Four cutoff = Four::Constant(kernel_.cutoffF());
  const Four zero = Four::Zero();
  const float* factors = x.reach->factors.data();
  const float* weights = box_.weights.data() + (x.first - box_.low.x);
  Four sum = zero;
  for (const Row& row : rows_)
    for (int32_t i = 0; i < x.count(); i += 4)
    {
      const Four product = row.yz * Eigen::Map<const Four>(factors + i);
      const Four kernel = (product - cutoff).max(zero);
      const Four term = kernel * Eigen::Map<const Four>(weights + row.begin + i);
      sum += term;
    }
  ReachedLogodds result;
  result.logodds = (sum[0] + sum[1]) + (sum[2] + sum[3]);
  // Weights may cancel or all be zero; check whether any site is within reach.
  result.reached = result.logodds != 0.0f || (box_.anySite && reaches(x));
  return result;
}

bool RegularSum::reaches(const AxisWindow& x) const
{
  const uint8_t* isSite = box_.isSite.data() + (x.first - box_.low.x);
  return std::any_of(
      rows_.begin(), rows_.end(),
      [&](const Row& row)
      {
        for (int32_t i = 0; i < x.count(); ++i)
          if (isSite[row.begin + static_cast<size_t>(i)] != 0 && kernel_.fromFactors(row.yz, x.factor(i)) > 0)
            return true;
        return false;
      });
}

void RegularSum::tileAt(const CellIndex& anchorSite, const RegularPoints& points,
                        const std::array<int, 3>& from, const std::array<int, 3>& counts,
                        std::vector<ReachedLogodds>& out)
{
  windowsOf(points.first + points.step_m * Eigen::Vector3d(from[0], from[1], from[2]), points.step_m, counts);
  CellIndex low;
  CellIndex high;
  const auto bounds = [&](size_t axis, int32_t& first, int32_t& last)
  {
    first = windows_[axis].front().first;
    last = windows_[axis].back().last();
    for (const AxisWindow& window : windows_[axis]) last = std::max(last, window.last());
  };
  bounds(0, low.x, high.x);
  bounds(1, low.y, high.y);
  bounds(2, low.z, high.z);
  weights_.copyInto(plus(low, anchorSite), plus(high, anchorSite), box_);
  box_.low = low;
  const auto stepY = static_cast<size_t>(points.counts[0]);
  const size_t stepZ = stepY * static_cast<size_t>(points.counts[1]);
  const auto origin = static_cast<size_t>(from[0]) + static_cast<size_t>(from[1]) * stepY +
                      static_cast<size_t>(from[2]) * stepZ;
  if (!box_.anySite) return;
  for (size_t z = 0; z < windows_[2].size(); ++z)
    for (size_t y = 0; y < windows_[1].size(); ++y)
    {
      listRows(windows_[1][y], windows_[2][z], 1.0f);
      if (rows_.empty()) continue;
      ReachedLogodds* line = out.data() + origin + y * stepY + z * stepZ;
      for (const AxisWindow& x : windows_[0]) *line++ = sumRows(x);
    }
}

void RegularSum::at(const CellIndex& anchorSite, const RegularPoints& points,
                    std::vector<ReachedLogodds>& out)
{
  out.assign(points.size(), {});
  // Where points are far apart, a tile of many would span a large box.
  const double perTile = std::max(1.0, 4.0 * kernel_.support_m() / points.step_m);
  const int edge = static_cast<int>(std::min<double>(kTileEdge, perTile));
  std::array<int, 3> from{};
  for (from[2] = 0; from[2] < points.counts[2]; from[2] += edge)
    for (from[1] = 0; from[1] < points.counts[1]; from[1] += edge)
      for (from[0] = 0; from[0] < points.counts[0]; from[0] += edge)
      {
        std::array<int, 3> counts{};
        for (size_t axis = 0; axis < 3; ++axis)
          counts[axis] = std::min(edge, points.counts[axis] - from[axis]);
        tileAt(anchorSite, points, from, counts, out);
      }
}

}  // namespace

void SiteBox::reset(const CellIndex& first, const CellIndex& last)
{
  // Runs of a kernel's reach may be read beyond the last site of a row.
  low = first;
  counts = {last.x - first.x + 1, last.y - first.y + 1, last.z - first.z + 1};
  stride = counts[0] + AxisReach::kMaxSites;
  const size_t size =
      static_cast<size_t>(stride) * static_cast<size_t>(counts[1]) * static_cast<size_t>(counts[2]);
  weights.assign(size, 0.0f);
  isSite.assign(size, 0);
  anySite = false;
}

CompactSum::CompactSum(const CompactKernel& kernel, double spacing_m, bool planar)
    : kernel_(kernel), spacing_m_(spacing_m), planar_(planar)
{
  AxisReaches::requireReach(kernel, spacing_m);
}

ReachedLogodds CompactSum::at(const SiteWeights& sites, const CellIndex& anchorSite,
                              const Eigen::Vector3d& point, const Eigen::Matrix3d& covariance) const
{
  const GaussianBlur blur(covariance, kernel_.gamma());
  const Eigen::Vector3d reach = kernel_.reach_m(blur);
  ReachedLogodds result;
  if (!(reach.maxCoeff() > 0)) return result;
  CellIndex low;
  CellIndex high;
  const auto bounds = [&](int axis, int32_t& first, int32_t& last)
  {
    first = static_cast<int32_t>(std::ceil((point[axis] - reach[axis]) / spacing_m_ - 0.5));
    last = static_cast<int32_t>(std::floor((point[axis] + reach[axis]) / spacing_m_ - 0.5));
  };
  bounds(0, low.x, high.x);
  bounds(1, low.y, high.y);
  if (!planar_) bounds(2, low.z, high.z);
  SiteBox box;
  sites.copyInto(plus(low, anchorSite), plus(high, anchorSite), box);
  box.low = low;
  double sum = 0;
  for (int32_t z = low.z; z <= high.z; ++z)
    for (int32_t y = low.y; y <= high.y; ++y)
      for (int32_t x = low.x; x <= high.x; ++x)
      {
        const size_t at = box.rowOf(y, z) + static_cast<size_t>(x - low.x);
        if (box.isSite[at] == 0) continue;
        Eigen::Vector3d difference = point - spacing_m_ * Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5);
        if (planar_) difference.z() = 0;
        const float kernel = kernel_.at(difference, blur);
        sum += static_cast<double>(kernel) * box.weights[at];
        result.reached = result.reached || kernel > 0;
      }
  result.logodds = static_cast<float>(sum);
  return result;
}

void CompactSum::atRegular(const SiteWeights& sites, const CellIndex& anchorSite, const RegularPoints& points,
                           std::vector<ReachedLogodds>& out) const
{
  RegularSum(sites, kernel_, spacing_m_, planar_).at(anchorSite, points, out);
}

}  // namespace lamap
