#include <lamap_core/learning/logistic_problem.h>

#include <lamap_core/math/portable_math.h>

namespace lamap
{
double LogisticProblem::objective(const std::vector<float>& u, const Workers& workers) const
{
  std::vector<float> f(rows.points());
  rows.multiply(u.data(), f.data(), workers);
  double sum = 0;
  for (size_t i = 0; i < f.size(); ++i)
    sum += static_cast<double>(weights[i]) * softplus(labels[i] > 0.5f ? -double{f[i]} : double{f[i]});
  for (size_t j = 0; j < u.size(); ++j)
  {
    const double difference = static_cast<double>(u[j]) - mean[j];
    sum += 0.5 * static_cast<double>(precision[j]) * difference * difference;
  }
  return sum;
}

void LogisticProblem::gradient(const std::vector<float>& u, std::vector<float>& g,
                               const Workers& workers) const
{
  std::vector<float> r(rows.points());
  rows.multiply(u.data(), r.data(), workers);
  for (size_t i = 0; i < r.size(); ++i) r[i] = weights[i] * (logistic(r[i]) - labels[i]);
  g.resize(rows.weights());
  rows.multiplyTransposed(r.data(), g.data(), workers);
  addPriorGradient(u, g);
}

void LogisticProblem::addPriorGradient(const std::vector<float>& u, std::vector<float>& g) const
{
  for (size_t j = 0; j < u.size(); ++j) g[j] += precision[j] * (u[j] - mean[j]);
}

void LogisticProblem::curvature(const std::vector<float>& u, std::vector<float>& diagonal,
                                const Workers& workers) const
{
  std::vector<float> c(rows.points());
  rows.multiply(u.data(), c.data(), workers);
  for (size_t i = 0; i < c.size(); ++i)
  {
    const float p = logistic(c[i]);
    c[i] = weights[i] * p * (1.0f - p);
  }
  diagonal.resize(rows.weights());
  rows.addSquares(c.data(), diagonal.data(), workers);
  for (size_t j = 0; j < diagonal.size(); ++j) diagonal[j] += precision[j];
}

}  // namespace lamap
