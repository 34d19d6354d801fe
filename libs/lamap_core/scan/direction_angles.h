#pragma once

#include <Eigen/Core>

namespace lamap
{
/** Angles of four vectors (x, y) from the x axis [rad], in [−π, π], error below 1e-5; 0 for the origin.
 *
 * Uses only additions, multiplications and divisions, each rounded separately: the same on every
 * processor. */
[[nodiscard]] Eigen::Array4f anglesOf(const Eigen::Array4f& y, const Eigen::Array4f& x);

}  // namespace lamap
