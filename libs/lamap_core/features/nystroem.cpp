#include <lamap_core/features/nystroem.h>

#include <lamap_core/math/portable_math.h>
#include <lamap_core/math/wide_floats.h>
#include <lamap_core/options/legal_range.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace lamap
{
namespace
{
/// In place: the lower triangle of a symmetric positive definite matrix becomes its Cholesky factor L.
void cholesky(std::vector<double>& matrix, size_t n)
{
  for (size_t i = 0; i < n; ++i)
  {
    double* row = matrix.data() + i * n;
    for (size_t j = 0; j <= i; ++j)
    {
      const double* other = matrix.data() + j * n;
      std::array<double, 4> sums{};
      for (size_t k = 0; k < j; ++k) sums[k % 4] += row[k] * other[k];
      const double rest = row[j] - ((sums[0] + sums[1]) + (sums[2] + sums[3]));
      row[j] = i == j ? std::sqrt(rest) : rest / other[j];
    }
  }
}

/// The inverse of a lower triangle, by columns of the identity, row by row.
std::vector<double> invertedLower(const std::vector<double>& lower, size_t n)
{
  std::vector<double> inverse(n * n, 0.0);
  for (size_t i = 0; i < n; ++i)
  {
    double* row = inverse.data() + i * n;
    for (size_t k = 0; k < i; ++k)
    {
      const double factor = lower[i * n + k];
      const double* above = inverse.data() + k * n;
      for (size_t j = 0; j <= k; ++j) row[j] -= factor * above[j];
    }
    const double diagonal = lower[i * n + i];
    row[i] = 1.0;
    for (size_t j = 0; j <= i; ++j) row[j] /= diagonal;
  }
  return inverse;
}

}  // namespace

NystroemFeatures::NystroemFeatures(const std::vector<Eigen::Vector3d>& points, size_t components,
                                   double gamma, uint64_t seed)
    : gamma_(gamma)
{
  requireLegal(components >= 1, "components", static_cast<double>(components), "a whole number >= 1");
  std::vector<uint32_t> order(points.size());
  for (size_t i = 0; i < order.size(); ++i) order[i] = static_cast<uint32_t>(i);
  const size_t count = std::min(components, points.size());
  std::mt19937_64 generator(seed);
  if (count < points.size())
    for (size_t i = 0; i < count; ++i) std::swap(order[i], order[i + generator() % (order.size() - i)]);
  for (size_t i = 0; i < count; ++i) inducing_.push_back(points[order[i]]);
  factorize();
}

NystroemFeatures::NystroemFeatures(std::vector<Eigen::Vector3d> inducing, double gamma)
    : gamma_(gamma), inducing_(std::move(inducing))
{
  factorize();
}

void NystroemFeatures::factorize()
{
  requireLegal(gamma_ > 0 && std::isfinite(gamma_), "gamma", gamma_, "a finite number > 0");
  requireLegal(!inducing_.empty(), "inducing points", 0, "at least one");
  const size_t m = inducing_.size();
  std::vector<double> matrix(m * m, 0.0);
  for (size_t i = 0; i < m; ++i)
    for (size_t j = 0; j <= i; ++j)
      matrix[i * m + j] =
          portableExp(-gamma_ * (inducing_[i] - inducing_[j]).squaredNorm()) + (i == j ? kJitter : 0.0);
  cholesky(matrix, m);
  inverse_ = invertedLower(matrix, m);
  std::array<std::vector<float>, 3> fromFirst;
  for (int axis = 0; axis < 3; ++axis)
    for (const Eigen::Vector3d& point : inducing_)
      fromFirst[static_cast<size_t>(axis)].push_back(static_cast<float>(point[axis] - inducing_[0][axis]));
  rows_.emplace(fromFirst, inverse_, gamma_);
}

void NystroemFeatures::kernelsOf(const HilbertTrainingSet& set, size_t i, bool wide, float* kernels) const
{
  if (set.covariances.empty())
  {
    const Eigen::Vector3f place = (set.points[i] - inducing_[0]).cast<float>();
    rows_->kernelsOf({place.x(), place.y(), place.z()}, kernels, wide);
    return;
  }
  const GaussianBlur blur(set.covariances[i], gamma_);
  for (size_t k = 0; k < components(); ++k)
    kernels[k] = static_cast<float>(
        blur.factor * portableExp(-gamma_ * blur.squaredDistance(set.points[i] - inducing_[k])));
}

void NystroemFeatures::rowsOf(const HilbertTrainingSet& set, FeatureRows& rows, const Workers& workers) const
{
  const size_t m = components();
  std::vector<uint32_t> used(m + 1);
  for (size_t j = 0; j <= m; ++j) used[j] = static_cast<uint32_t>(j);
  rows.reset(static_cast<int>(weightCount()), set.size(), weightCount(), std::move(used));
  rows.setBias(static_cast<uint32_t>(m));
  const bool wide = hasAvx2();
  const auto fill = [&](size_t chunk)
  {
    constexpr size_t kAtOnce = NystroemRows::kAtOnce;
    const size_t stride = rows_->stride();
    std::vector<float> kernels(kAtOnce * stride, 0.0f);
    std::vector<float> features(kernels);
    const size_t end = rows.endPointOf(chunk);
    for (size_t begin = rows.firstPointOf(chunk); begin < end; begin += kAtOnce)
    {
      const size_t count = std::min(kAtOnce, end - begin);
      for (size_t p = 0; p < count; ++p) kernelsOf(set, begin + p, wide, kernels.data() + p * stride);
      rows_->featuresOf(kernels.data(), features.data(), wide);
      for (size_t p = 0; p < count; ++p)
      {
        float* values = rows.addRun(chunk, 0);
        std::copy_n(features.data() + p * stride, m, values);
        std::fill(values + m, values + weightCount(), 0.0f);
        values[m] = 1.0f;
        rows.endPoint(chunk);
      }
    }
  };
  workers.forEach(rows.chunkCount(), fill);
}

NystroemFeatures::Folded NystroemFeatures::fold(const std::vector<float>& u) const
{
  const size_t m = components();
  std::vector<double> sums(m, 0.0);
  for (size_t j = 0; j < m; ++j)
    for (size_t k = 0; k <= j; ++k) sums[k] += inverse_[j * m + k] * u[j];
  Folded folded;
  folded.kernelWeights.assign(sums.begin(), sums.end());
  folded.bias = u[m];
  return folded;
}

double NystroemFeatures::logoddsAt(const Folded& classifier, const Eigen::Vector3d& point) const
{
  double sum = classifier.bias;
  for (size_t k = 0; k < components(); ++k)
    sum += classifier.kernelWeights[k] * portableExp(-gamma_ * (point - inducing_[k]).squaredNorm());
  return sum;
}

double NystroemFeatures::logoddsAt(const Folded& classifier, const Eigen::Vector3d& point,
                                   const Eigen::Matrix3d& covariance) const
{
  const GaussianBlur blur(covariance, gamma_);
  double sum = 0;
  for (size_t k = 0; k < components(); ++k)
    sum += classifier.kernelWeights[k] * portableExp(-gamma_ * blur.squaredDistance(point - inducing_[k]));
  return blur.factor * sum + classifier.bias;
}

void NystroemFeatures::logoddsAt(const Folded& classifier, const RegularPoints& points,
                                 std::vector<float>& logodds, const Workers& workers) const
{
  const size_t m = components();
  const auto countX = static_cast<size_t>(points.counts[0]);
  const auto countY = static_cast<size_t>(points.counts[1]);
  const auto countZ = static_cast<size_t>(points.counts[2]);
  logodds.resize(points.size());
  if (logodds.empty()) return;
  // exp(−γ d²) is a product over the axes; of each, its factors for every coordinate and inducing point.
  constexpr size_t kAtOnce = 16;
  using Sixteen = Eigen::Array<float, kAtOnce, 1>;
  const size_t paddedX = (countX + kAtOnce - 1) / kAtOnce * kAtOnce;
  const auto factor = [&](int axis, size_t i, size_t k)
  {
    const double d = points.first[axis] + static_cast<double>(i) * points.step_m - inducing_[k][axis];
    return static_cast<float>(portableExp(-gamma_ * d * d));
  };
  std::vector<float> alongX(m * paddedX, 0.0f);
  std::vector<float> alongY(m * countY);
  for (size_t k = 0; k < m; ++k)
  {
    for (size_t i = 0; i < countX; ++i) alongX[k * paddedX + i] = factor(0, i, k);
    for (size_t j = 0; j < countY; ++j) alongY[j * m + k] = factor(1, j, k);
  }
  workers.forEach(countZ,
                  [&](size_t z)
                  {
                    std::vector<float> weightsZ(m);
                    for (size_t k = 0; k < m; ++k) weightsZ[k] = factor(2, z, k);
                    std::vector<std::pair<float, const float*>> near;  // weight and factors along x
                    for (size_t y = 0; y < countY; ++y)
                    {
                      constexpr float kNothing = 1e-9f;
                      near.clear();
                      for (size_t k = 0; k < m; ++k)
                      {
                        const float yz = weightsZ[k] * alongY[y * m + k];
                        if (yz > kNothing)
                          near.emplace_back(yz * classifier.kernelWeights[k], alongX.data() + k * paddedX);
                      }
                      float* line = logodds.data() + (z * countY + y) * countX;
                      for (size_t x = 0; x < countX; x += kAtOnce)
                      {
                        Sixteen sum = Sixteen::Constant(classifier.bias);
                        for (const auto& [weight, factors] : near)
                        {
                          const Sixteen product = weight * Eigen::Map<const Sixteen>(factors + x);
                          sum += product;
                        }
                        for (size_t i = x; i < std::min(x + kAtOnce, countX); ++i)
                          line[i] = sum[static_cast<int>(i - x)];
                      }
                    }
                  });
}

}  // namespace lamap
