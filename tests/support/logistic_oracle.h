#pragma once

#include <lamap_core/learning/logistic_problem.h>
#include <lamap_core/math/portable_math.h>
#include <lamap_core/math/workers.h>

#include <cmath>
#include <vector>

namespace lamap::test
{
/// log(1 + e^f): the loss of saying f where the truth is free; log(1 + e^−f) where it is occupied.
inline double softplus(double f)
{
  return (f > 0 ? f : 0.0) + std::log1p(std::exp(-std::abs(f)));
}

/// φ(u) of a logistic problem, in double.
inline double objectiveOf(const LogisticProblem& problem, const std::vector<float>& u)
{
  std::vector<float> f(problem.rows.points());
  problem.rows.multiply(u.data(), f.data(), Workers(1));
  double sum = 0;
  for (size_t i = 0; i < f.size(); ++i)
    sum += static_cast<double>(problem.weights[i]) *
           softplus(problem.labels[i] > 0.5f ? -double{f[i]} : double{f[i]});
  for (size_t j = 0; j < u.size(); ++j)
  {
    const double difference = static_cast<double>(u[j]) - problem.mean[j];
    sum += 0.5 * static_cast<double>(problem.precision[j]) * difference * difference;
  }
  return sum;
}

/// ∂φ/∂u, 0 where rows have no feature.
inline std::vector<float> gradientOf(const LogisticProblem& problem, const std::vector<float>& u)
{
  std::vector<float> r(problem.rows.points()), g(problem.rows.weights());
  problem.rows.multiply(u.data(), r.data(), Workers(1));
  for (size_t i = 0; i < r.size(); ++i) r[i] = problem.weights[i] * (logistic(r[i]) - problem.labels[i]);
  problem.rows.multiplyTransposed(r.data(), g.data(), Workers(1));
  for (size_t j = 0; j < u.size(); ++j) g[j] += problem.precision[j] * (u[j] - problem.mean[j]);
  return g;
}

/// Diagonal of the Hessian, Λⱼ + Σᵢ wᵢ·pᵢ(1 − pᵢ)·F_ij².
inline std::vector<float> curvatureOf(const LogisticProblem& problem, const std::vector<float>& u)
{
  std::vector<float> c(problem.rows.points()), diagonal(problem.rows.weights());
  problem.rows.multiply(u.data(), c.data(), Workers(1));
  for (size_t i = 0; i < c.size(); ++i) c[i] = problem.weights[i] * logistic(c[i]) * (1.0f - logistic(c[i]));
  problem.rows.addSquares(c.data(), diagonal.data(), Workers(1));
  for (size_t j = 0; j < diagonal.size(); ++j) diagonal[j] += problem.precision[j];
  return diagonal;
}

}  // namespace lamap::test
