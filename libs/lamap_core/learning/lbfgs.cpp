#include <lamap_core/learning/lbfgs.h>

#include <lamap_core/math/portable_math_four.h>

#include <algorithm>
#include <cmath>

namespace lamap
{
namespace
{
/// Items whose sum is formed at once: sums of such blocks are added in their order.
constexpr size_t kBlock = 4096;

size_t blocksOf(size_t items)
{
  return (items + kBlock - 1) / kBlock;
}

using Four = Eigen::Array4f;
/// Numbers that are summed in single precision before their sum is added in double.
constexpr size_t kShort = 256;

Four load(const std::vector<float>& from, size_t at)
{
  return Eigen::Map<const Four>(from.data() + at);
}
double total(const Four& sum)
{
  return (static_cast<double>(sum[0]) + sum[1]) + (static_cast<double>(sum[2]) + sum[3]);
}

double dot(const std::vector<float>& a, const std::vector<float>& b)
{
  double result = 0;
  size_t i = 0;
  while (i + 4 <= a.size())
  {
    const size_t end = std::min(a.size() / 4 * 4, i + kShort);
    Four sum = Four::Zero();
    for (; i < end; i += 4)
    {
      const Four product = load(a, i) * load(b, i);
      sum += product;
    }
    result += total(sum);
  }
  for (; i < a.size(); ++i) result += static_cast<double>(a[i]) * b[i];
  return result;
}

/// p = 1/(1 + e^−(f + step·change))
void probabilities(const float* f, const float* change, float step, size_t count, float* p)
{
  size_t i = 0;
  for (; i + 4 <= count; i += 4)
  {
    const Four moved = step * Eigen::Map<const Four>(change + i);
    const Four sum = Eigen::Map<const Four>(f + i) + moved;
    Eigen::Map<Four>{p + i} = logistic(sum);
  }
  for (; i < count; ++i) p[i] = logistic(f[i] + step * change[i]);
}

/// y += factor · x
void add(float factor, const std::vector<float>& x, std::vector<float>& y)
{
  for (size_t i = 0; i < y.size(); ++i) y[i] += factor * x[i];
}

/// The prior's part of the gradient, Λ(u − μ), is added to g.
void addPriorGradient(const LogisticProblem& problem, const std::vector<float>& u, std::vector<float>& g)
{
  for (size_t j = 0; j < u.size(); ++j) g[j] += problem.precision[j] * (u[j] - problem.mean[j]);
}

}  // namespace

void Lbfgs::residualsOf(const LogisticProblem& problem)
{
  for (size_t i = 0; i < residual_.size(); ++i)
    residual_[i] = problem.weights[i] * (prob_[i] - problem.labels[i]);
}

void Lbfgs::finalCurvature(const LogisticProblem& problem, std::vector<float>& diagonal,
                           const Workers& workers)
{
  for (size_t i = 0; i < residual_.size(); ++i)
    residual_[i] = problem.weights[i] * prob_[i] * (1.0f - prob_[i]);
  diagonal.resize(problem.rows.weights());
  problem.rows.addSquares(residual_.data(), diagonal.data(), workers);
  for (size_t j = 0; j < diagonal.size(); ++j) diagonal[j] += problem.precision[j];
}

void Lbfgs::chooseDirection(size_t pairs, size_t newest)
{
  // The two loops of Nocedal (1980), with the preconditioner as the first guess of the inverse Hessian.
  std::vector<double> factors(pairs);
  direction_ = gradient_;
  for (size_t k = 0; k < pairs; ++k)
  {
    const Pair& pair = pairs_[(newest + kMemory - k) % kMemory];
    factors[k] = dot(pair.step, direction_) * pair.inverseProduct;
    add(static_cast<float>(-factors[k]), pair.change, direction_);
  }
  double scale = 1.0;
  if (pairs > 0)
  {
    const Pair& pair = pairs_[newest];
    double product = 0;
    for (size_t j = 0; j < direction_.size(); ++j)
      product += static_cast<double>(pair.change[j]) * pair.change[j] * inverseDiagonal_[j];
    scale = 1.0 / (pair.inverseProduct * product);
  }
  const auto scaleF = static_cast<float>(scale);
  for (size_t j = 0; j < direction_.size(); ++j) direction_[j] *= inverseDiagonal_[j] * scaleF;
  for (size_t k = pairs; k-- > 0;)
  {
    const Pair& pair = pairs_[(newest + kMemory - k) % kMemory];
    const double back = dot(pair.change, direction_) * pair.inverseProduct;
    add(static_cast<float>(factors[k] - back), pair.step, direction_);
  }
  for (float& component : direction_) component = -component;
}

void Lbfgs::probabilitiesAt(float step, const Workers& workers)
{
  workers.forEach(blocksOf(prob_.size()),
                  [&](size_t block)
                  {
                    const size_t begin = block * kBlock;
                    probabilities(logodds_.data() + begin, logoddsStep_.data() + begin, step,
                                  std::min(kBlock, prob_.size() - begin), prob_.data() + begin);
                  });
}

/// The slope along the direction where prob_ says that one is.
Lbfgs::Slope Lbfgs::slopeNow(const LogisticProblem& problem, const Slope& prior, const Workers& workers)
{
  const size_t points = prob_.size();
  slopes_.resize(blocksOf(points));
  workers.forEach(slopes_.size(),
                  [&](size_t block)
                  {
                    const size_t begin = block * kBlock;
                    const size_t end = std::min(points, begin + kBlock);
                    Slope& sum = slopes_[block] = {};
                    size_t i = begin;
                    // Short sums in single precision, their sum in double.
                    for (; i + kShort <= end; i += kShort)
                    {
                      Four first = Four::Zero();
                      Four second = Four::Zero();
                      for (size_t k = i; k < i + kShort; k += 4)
                      {
                        const Four step = load(logoddsStep_, k);
                        const Four prob = load(prob_, k);
                        const Four weighted = load(problem.weights, k) * step;
                        const Four slope = weighted * (prob - load(problem.labels, k));
                        const Four bend = weighted * step * prob * (1.0f - prob);
                        first += slope;
                        second += bend;
                      }
                      sum.first += total(first);
                      sum.second += total(second);
                    }
                    for (; i < end; ++i)
                    {
                      const float weighted = problem.weights[i] * logoddsStep_[i];
                      sum.first += static_cast<double>(weighted * (prob_[i] - problem.labels[i]));
                      sum.second +=
                          static_cast<double>(weighted * logoddsStep_[i] * prob_[i] * (1.0f - prob_[i]));
                    }
                  });
  Slope slope = prior;
  for (const Slope& part : slopes_)
  {
    slope.first += part.first;
    slope.second += part.second;
  }
  return slope;
}

bool Lbfgs::searchLine(const LogisticProblem& problem, const std::vector<float>& u, const Workers& workers,
                       float& step)
{
  Slope prior;
  for (size_t j = 0; j < u.size(); ++j)
  {
    const double weighted = static_cast<double>(problem.precision[j]) * direction_[j];
    prior.first += weighted * (static_cast<double>(u[j]) - problem.mean[j]);
    prior.second += weighted * direction_[j];
  }
  Slope slope = slopeNow(problem, prior, workers);
  const double start = slope.first;
  if (!(start < 0) || !(slope.second > 0)) return false;
  // φ is convex along the line: its minimum lies between a step with a falling and one with a rising slope.
  constexpr int kMaxTrials = 30;
  constexpr double kFlatEnough = 0.1;
  double low = 0;
  double high = 0;  // 0: none found yet
  double at = -start / slope.second;
  for (int trial = 0; trial < kMaxTrials; ++trial)
  {
    probabilitiesAt(static_cast<float>(at), workers);
    slope = slopeNow(problem, {prior.first + at * prior.second, prior.second}, workers);
    if (std::abs(slope.first) <= -kFlatEnough * start) break;
    (slope.first < 0 ? low : high) = at;
    double next = slope.second > 0 ? at - slope.first / slope.second : 2 * at;
    if (high > 0 && !(next > low && next < high)) next = 0.5 * (low + high);
    if (high == 0) next = std::min(next, 10 * at);
    at = next;
  }
  step = static_cast<float>(at);
  return step > 0 && std::isfinite(step);
}

void Lbfgs::minimize(const LogisticProblem& problem, int iterations, std::vector<float>& u,
                     const Workers& workers)
{
  FeatureRows& rows = problem.rows;
  const size_t points = rows.points();
  const size_t weights = rows.weights();
  for (std::vector<float>* ofPoints : {&logodds_, &logoddsStep_, &prob_, &residual_})
    ofPoints->resize(points);
  for (std::vector<float>* ofWeights : {&gradient_, &lastGradient_, &inverseDiagonal_, &direction_})
    ofWeights->resize(weights);

  rows.multiply(u.data(), logodds_.data(), workers);
  for (size_t i = 0; i < points; ++i) prob_[i] = logistic(logodds_[i]);
  finalCurvature(problem, inverseDiagonal_, workers);
  for (float& entry : inverseDiagonal_) entry = entry > 1e-20f ? 1.0f / entry : 0.0f;

  size_t pairs = 0;
  size_t newest = kMemory - 1;
  residualsOf(problem);
  rows.multiplyTransposed(residual_.data(), gradient_.data(), workers);
  addPriorGradient(problem, u, gradient_);
  for (int done = 0; done < iterations; ++done)
  {
    chooseDirection(pairs, newest);
    rows.multiply(direction_.data(), logoddsStep_.data(), workers);
    float step = 0;
    if (!searchLine(problem, u, workers, step)) break;
    add(step, direction_, u);
    for (size_t i = 0; i < points; ++i) logodds_[i] += step * logoddsStep_[i];

    if (done + 1 == iterations) continue;  // the last gradient would serve nothing
    gradient_.swap(lastGradient_);
    residualsOf(problem);
    rows.multiplyTransposed(residual_.data(), gradient_.data(), workers);
    addPriorGradient(problem, u, gradient_);
    const size_t slot = (newest + 1) % kMemory;
    Pair& pair = pairs_[slot];
    pair.step.resize(weights);
    pair.change.resize(weights);
    for (size_t j = 0; j < weights; ++j)
    {
      pair.step[j] = step * direction_[j];
      pair.change[j] = gradient_[j] - lastGradient_[j];
    }
    const double product = dot(pair.step, pair.change);
    if (!(product > 1e-30)) break;  // no change that single precision could show
    pair.inverseProduct = 1.0 / product;
    newest = slot;
    pairs = std::min(pairs + 1, kMemory);
  }
  // Where the search gave up, the probabilities are of a step not taken.
  for (size_t i = 0; i < points; ++i) prob_[i] = logistic(logodds_[i]);
}

}  // namespace lamap
