#pragma once

#include <lamap_core/options/legal_range.h>

#include <Eigen/Eigenvalues>
#include <cmath>

namespace lamap
{
/// @param name of what is wrong. @throws std::invalid_argument unless it is finite, symmetric and positive
/// semidefinite, but for rounding.
template <typename Matrix>
void requireCovariance(const Matrix& covariance, const char* name)
{
  const double rounding = 1e-12 * covariance.diagonal().maxCoeff();
  for (int row = 0; row < covariance.rows(); ++row)
  {
    constexpr double kMost = 1e24;  // of a place anywhere on a map
    requireLegal(covariance(row, row) >= 0 && covariance(row, row) <= kMost, name, covariance(row, row),
                 "a covariance: finite, with variances from 0 to 1e24");
    for (int column = 0; column < row; ++column)
    {
      const double one = covariance(row, column);
      const double other = covariance(column, row);
      const double largest = std::sqrt(covariance(row, row)) * std::sqrt(covariance(column, column));
      requireLegal(std::isfinite(one) && std::abs(one - other) <= 1e-6 * largest + rounding &&
                       std::abs(one) <= largest * (1 + 1e-6) + rounding,
                   name, one, "a covariance: symmetric, no larger than its variances allow");
    }
  }
  const double least = covariance.template selfadjointView<Eigen::Lower>().eigenvalues().minCoeff();
  requireLegal(least >= -1e-9 * covariance.diagonal().maxCoeff(), name, least,
               "a covariance: no eigenvalue below 0");
}

}  // namespace lamap
