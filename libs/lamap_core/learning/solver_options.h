#pragma once

namespace lamap
{
class OptionTable;

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

  /// Describes them, once.
  [[nodiscard]] static const OptionTable& optionTable();
};

}  // namespace lamap
