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
/// Fewer inducing points are not worth more than a thread.
constexpr size_t kWorthThreads = 512;

/// Four sums of products by k modulo 4: an order that neither a processor nor the size of the cache decides.
using FourSums = Eigen::Array4d;

inline FourSums four(const double* from)
{
  return Eigen::Map<const FourSums>(from);
}

/// Adds a[k]·b[k] for k from begin, a multiple of 4, to end.
inline void addProducts(const double* a, const double* b, size_t begin, size_t end, FourSums& sums)
{
  FourSums own = sums;
  size_t k = begin;
  for (; k + 4 <= end; k += 4)
  {
    const FourSums products = four(a + k) * four(b + k);
    own += products;
  }
  for (; k < end; ++k) own[static_cast<int>(k % 4)] += a[k] * b[k];
  sums = own;
}

/// The same for two rows at once, so that the processor need not wait for each sum; to a multiple of 4.
inline void addProducts(const double* a0, const double* a1, const double* b, size_t begin, size_t end,
                        FourSums& sums0, FourSums& sums1)
{
  FourSums own0 = sums0;
  FourSums own1 = sums1;
  for (size_t k = begin; k < end; k += 4)
  {
    const FourSums factors = four(b + k);
    const FourSums products0 = four(a0 + k) * factors;
    const FourSums products1 = four(a1 + k) * factors;
    own0 += products0;
    own1 += products1;
  }
  sums0 = own0;
  sums1 = own1;
}

/// The Cholesky factorization of the lower triangle of a matrix, some columns at a time; rows are dealt to
/// threads.
class Factorization
{
 public:
  Factorization(std::vector<double>& matrix, size_t n) : matrix_(matrix), n_(n) {}

  void run(const Workers& workers)
  {
    for (size_t first = 0; first < n_; first += kColumns)
    {
      finishRows(first, first, std::min(n_, first + kColumns));
      const size_t below = std::min(n_, first + kColumns);
      workers.forEach((n_ - below + kRows - 1) / kRows,
                      [&](size_t part)
                      {
                        const size_t begin = below + part * kRows;
                        finishRows(first, begin, std::min(n_, begin + kRows));
                      });
    }
  }

 private:
  static constexpr size_t kColumns = 64;
  static constexpr size_t kRows = 16;
  static constexpr size_t kDepth = 512;  ///< so many numbers of each row stay in the cache

  [[nodiscard]] double* rowOf(size_t i) { return matrix_.data() + i * n_; }

  /// Of rows [begin, end) the columns [first, first + kColumns), as far as they are below the diagonal.
  void finishRows(size_t first, size_t begin, size_t end)
  {
    const size_t last = std::min(n_, first + kColumns);
    std::vector<FourSums> sums((end - begin) * kColumns, FourSums::Zero());
    const auto sumOf = [&](size_t i, size_t j) -> FourSums&
    { return sums[(i - begin) * kColumns + (j - first)]; };
    for (size_t from = 0; from < first; from += kDepth)
    {
      const size_t to = std::min(first, from + kDepth);
      for (size_t j = first; j < last; ++j)
      {
        const double* column = rowOf(j);
        size_t i = std::max(begin, j);
        for (; i + 2 <= end; i += 2)
          addProducts(rowOf(i), rowOf(i + 1), column, from, to, sumOf(i, j), sumOf(i + 1, j));
        if (i < end) addProducts(rowOf(i), column, from, to, sumOf(i, j));
      }
    }
    for (size_t i = begin; i < end; ++i)
      for (size_t j = first; j < std::min(last, i + 1); ++j)
      {
        FourSums& sum = sumOf(i, j);
        addProducts(rowOf(i), rowOf(j), first, j, sum);
        double& entry = rowOf(i)[j];
        const double rest = entry - ((sum[0] + sum[1]) + (sum[2] + sum[3]));
        entry = i == j ? std::sqrt(rest) : rest / rowOf(j)[j];
      }
  }

  std::vector<double>& matrix_;
  size_t n_;
};

/// The inverse of a lower triangle: of each column the rows from the top down; columns are dealt to threads.
std::vector<double> invertedLower(const std::vector<double>& lower, size_t n, const Workers& workers)
{
  std::vector<double> inverse(n * n, 0.0);
  constexpr size_t kColumns = 128;
  constexpr size_t kRows = 32;
  const auto invertColumns = [&](size_t first, size_t last)
  {
    // Takes off row i what rows [k, end) above it say, one after the other.
    const auto take = [&](size_t i, size_t k, size_t end)
    {
      double* row = inverse.data() + i * n;
      const double* factors = lower.data() + i * n;
      for (; k + 4 <= end && k + 1 >= last; k += 4)
      {
        const double* above = inverse.data() + k * n;
        for (size_t j = first; j < last; ++j)
          row[j] = (((row[j] - factors[k] * above[j]) - factors[k + 1] * above[j + n]) -
                    factors[k + 2] * above[j + 2 * n]) -
                   factors[k + 3] * above[j + 3 * n];
      }
      for (; k < end; ++k)
      {
        const double* above = inverse.data() + k * n;
        for (size_t j = first; j < std::min(k + 1, last); ++j) row[j] -= factors[k] * above[j];
      }
    };
    for (size_t top = first; top < n; top += kRows)
    {
      const size_t bottom = std::min(n, top + kRows);
      constexpr size_t kAbove = 32;
      for (size_t k = first; k < top; k += kAbove)
        for (size_t i = top; i < bottom; ++i) take(i, k, std::min(top, k + kAbove));
      for (size_t i = top; i < bottom; ++i)
      {
        take(i, top, i);
        double* row = inverse.data() + i * n;
        if (i < last) row[i] = 1.0;
        for (size_t j = first; j < std::min(i + 1, last); ++j) row[j] /= lower[i * n + i];
      }
    }
  };
  workers.forEach((n + kColumns - 1) / kColumns,
                  [&](size_t part) { invertColumns(part * kColumns, std::min(n, (part + 1) * kColumns)); });
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
  const Workers workers(m < kWorthThreads ? 1 : 0);
  Factorization(matrix, m).run(workers);
  inverse_ = invertedLower(matrix, m, workers);
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
