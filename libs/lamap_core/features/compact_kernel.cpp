#include <lamap_core/features/compact_kernel.h>

#include <lamap_core/math/portable_math.h>
#include <lamap_core/options/legal_range.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace lamap
{
namespace
{
/// Inverse and determinant of a symmetric positive definite matrix by its cofactors.
double invert(const Eigen::Matrix3d& m, Eigen::Matrix3d& inverse)
{
  const double xx = m(1, 1) * m(2, 2) - m(1, 2) * m(2, 1);
  const double xy = m(0, 2) * m(2, 1) - m(0, 1) * m(2, 2);
  const double xz = m(0, 1) * m(1, 2) - m(0, 2) * m(1, 1);
  const double determinant = m(0, 0) * xx + m(1, 0) * xy + m(2, 0) * xz;
  const double yy = m(0, 0) * m(2, 2) - m(0, 2) * m(2, 0);
  const double yz = m(0, 2) * m(1, 0) - m(0, 0) * m(1, 2);
  const double zz = m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0);
  inverse << xx, xy, xz, xy, yy, yz, xz, yz, zz;
  inverse /= determinant;
  return determinant;
}

}  // namespace

GaussianBlur::GaussianBlur(const Eigen::Matrix3d& covariance, double gamma)
{
  Eigen::Matrix3d widened = 2.0 * gamma * covariance;
  widened.diagonal().array() += 1.0;
  factor = 1.0 / std::sqrt(invert(widened, inverse));
  widening = widened.diagonal().cwiseSqrt();
}

double GaussianBlur::squaredDistance(const Eigen::Vector3d& d) const
{
  double sum = 0;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) sum += d[row] * inverse(row, column) * d[column];
  return sum;
}

CompactKernel::CompactKernel(double gamma, double cutoff) : gamma_(gamma), cutoff_(cutoff)
{
  requireLegal(gamma > 0 && std::isfinite(gamma), "gamma", gamma, "a finite number > 0");
  requireLegal(cutoff > 1e-12 && cutoff < 1, "cutoff", cutoff, "a number between 1e-12 and 1");
  support_m_ = std::sqrt(-portableLog(cutoff) / gamma);
  cutoffF_ = static_cast<float>(cutoff);
}

float CompactKernel::alongAxis(double distance_m) const
{
  if (!(std::abs(distance_m) < support_m_)) return 0.0f;
  return static_cast<float>(portableExp(-gamma_ * distance_m * distance_m));
}

float CompactKernel::at(const Eigen::Vector3d& d) const
{
  return fromFactors(alongAxis(d.y()) * alongAxis(d.z()), alongAxis(d.x()));
}

float CompactKernel::at(const Eigen::Vector3d& d, const GaussianBlur& blur) const
{
  const double expected = blur.factor * portableExp(-gamma_ * blur.squaredDistance(d));
  return static_cast<float>(std::max(expected - cutoff_, 0.0));
}

Eigen::Vector3d CompactKernel::reach_m(const GaussianBlur& blur) const
{
  // factor · exp(−γ dᵀAd) > cutoff is an ellipsoid; its box has the diagonal of A⁻¹.
  if (!(blur.factor > cutoff_)) return Eigen::Vector3d::Zero();
  return blur.widening * std::sqrt(portableLog(blur.factor / cutoff_) / gamma_);
}

AxisReaches::AxisReaches(const CompactKernel& kernel, double spacing_m)
    : kernel_(kernel), spacing_m_(spacing_m), remembered_(kRemembered)
{
  requireReach(kernel, spacing_m);
}

void AxisReaches::requireReach(const CompactKernel& kernel, double spacing_m)
{
  const double least_m = 2 * kernel.support_m() / (AxisReach::kMaxSites - 1);
  // Half a cube's diagonal: every place has a site within the support.
  const double most_m = 2 / std::sqrt(3.0) * kernel.support_m();
  requireLegal(spacing_m > 0 && std::isfinite(spacing_m), "latticeSpacing", spacing_m, "a finite length > 0");
  requireLegal(2 * kernel.support_m() / spacing_m + 1 <= AxisReach::kMaxSites && spacing_m <= most_m,
               "latticeSpacing", spacing_m,
               "from " + shortText(least_m) + " to " + shortText(most_m) +
                   " m, 0.13 to 1.15 times the support for gamma = " + shortText(kernel.gamma()));
}

void requireSupport(const CompactKernel& kernel, double resolution_m)
{
  constexpr double kMaxSupport_cells = 64.0;
  requireLegal(kernel.support_m() <= kMaxSupport_cells * resolution_m, "gamma", kernel.gamma(),
               "so large that the kernel's support, " + shortText(kernel.support_m()) +
                   " m, is at most 64 times the resolution, " + shortText(resolution_m) + " m");
}

namespace
{
/// Where in its site a coordinate is [2^-24 m].
int64_t placeIn(int32_t site, double spacing_m, double coordinate)
{
  return static_cast<int64_t>(std::floor((coordinate - site * spacing_m) * 0x1p24 + 0.5));
}

double inMetres(int64_t place)
{
  return static_cast<double>(place) * 0x1p-24;
}

void findSites(const CompactKernel& kernel, double spacing_m, double place_m, AxisReach& reach)
{
  const double support = kernel.support_m();
  const auto distance = [&](int32_t site) { return place_m - (site + 0.5) * spacing_m; };
  auto site = static_cast<int32_t>(std::floor((place_m - support) / spacing_m - 0.5));
  while (!(distance(site) < support)) ++site;
  reach.first = site;
  reach.count = 0;
  while (reach.count < AxisReach::kMaxSites && distance(site + reach.count) > -support) ++reach.count;
}

}  // namespace

AxisWindow AxisReaches::of(double coordinate)
{
  const int32_t site = siteOf(coordinate, spacing_m_);
  const int64_t place = placeIn(site, spacing_m_, coordinate);
  const uint64_t hash = static_cast<uint64_t>(place) * 0x9E3779B97F4A7C15ULL;
  Entry& entry = remembered_[static_cast<size_t>(hash >> 32) % kRemembered];
  if (entry.place != place)
  {
    entry.place = place;
    entry.reach = {};
    findSites(kernel_, spacing_m_, inMetres(place), entry.reach);
    findFactors(kernel_, spacing_m_, inMetres(place), entry.reach);
  }
  return {site + entry.reach.first, &entry.reach};
}

int32_t AxisReaches::findRange(const CompactKernel& kernel, double spacing_m, double coordinate,
                               AxisReach& reach, double& place_m)
{
  const int32_t site = siteOf(coordinate, spacing_m);
  place_m = inMetres(placeIn(site, spacing_m, coordinate));
  findSites(kernel, spacing_m, place_m, reach);
  return site;
}

void AxisReaches::findFactors(const CompactKernel& kernel, double spacing_m, double place_m, AxisReach& reach)
{
  for (int32_t i = 0; i < reach.count; ++i)
    reach.factors[static_cast<size_t>(i)] = kernel.alongAxis(place_m - (reach.first + i + 0.5) * spacing_m);
  reach.largest = *std::max_element(reach.factors.begin(), reach.factors.end());
}

AxisWindow AxisReaches::flat()
{
  static const AxisReach kFlat = []
  {
    AxisReach reach;
    reach.count = 1;
    reach.largest = 1.0f;
    reach.factors[0] = 1.0f;
    return reach;
  }();
  return {0, &kFlat};
}

}  // namespace lamap
