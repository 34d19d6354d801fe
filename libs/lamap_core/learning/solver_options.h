#pragma once

#include <cstdint>

namespace lamap
{
/// What minimizes the loss.
enum class HilbertSolver
{
  Lbfgs,
  SgdL1,
  SgdL2
};

/// Stochastic gradient descent (thesis eq. 2.34).
struct DescentOptions
{
  double alpha = 1e-5;  ///< α, weight of the penalty; from 1e-12 to 1e6
  int epochs = 5;       ///< passes over all training points, from 1 to 100,000

  /// @throws std::invalid_argument naming the first illegal option, its value and the legal range.
  void validate() const;

  friend bool operator==(const DescentOptions& a, const DescentOptions& b)
  {
    return a.alpha == b.alpha && a.epochs == b.epochs;
  }
};

/// Refuses a number of iterations of L-BFGS that is not legal. @throws std::invalid_argument
void requireIterations(double iterations);

}  // namespace lamap
