#pragma once

#include <cmath>
#include <vector>

namespace lamap
{
/// The compactly supported kernels for BGK inference, as functions of r = distance / support.
enum class KernelShape
{
  /// Melkumyan and Ramos (2009), thesis eq. (4.10): (2 + cos 2πr)(1 − r)/3 + sin 2πr / 2π.
  Sparse,
  /// The sparse kernel times a Matérn-3/2 kernel whose length scale is the support (thesis 5.1; Kim and Kim
  /// 2013): sparse(r)·(1 + √3 r)·exp(−√3 r).
  SparseMatern32,
  /// Wendland's C² function: (1 − r)⁴(4r + 1).
  WendlandC2
};

/** A compactly supported kernel: k(0) = scale, exactly 0 at and beyond the support.
 *
 * Evaluated by series whose coefficients need only multiplications and divisions, without functions of the C
 * library, whose last bit differs between processors: within 1e-12 · scale of the formulas above. With
 * s = 1 − r, the sparse kernel is s⁵ times an even power series in s.
 *
 * Invariants: k(0) = scale; never negative; never increases.
 * The sparse kernel is not positive definite in 2D and 3D: use it as a weight for BGK, never as a covariance.
 * Immutable: may be shared between threads.
 */
class Kernel
{
 public:
  /** @param shape    which of the kernels
   *  @param support  radius of the support, in the unit of the distances; finite, > 0 (l in the thesis)
   *  @param scale    weight at distance zero [-], finite, > 0 (σ₀ in the thesis)
   *  @throws std::invalid_argument naming the parameter, its value and the legal range */
  Kernel(KernelShape shape, double support, double scale);

  /// @param squaredDistance in the square of the support's unit, ≥ 0. @return weight [-], in [0, scale].
  [[nodiscard]] double atSquaredDistance(double squaredDistance) const noexcept
  {
    if (squaredDistance >= squaredSupport_) return 0.0;
    const double r = std::sqrt(squaredDistance) * inverseSupport_;
    const double s = 1.0 - r;
    if (!(s > 0.0)) return 0.0;
    const double s2 = s * s;
    double weight = s2 * s2 * (fifthPower_ ? s : 1.0) * horner(inSquaredS_, s2);
    if (!inR_.empty()) weight *= horner(inR_, r);
    return weight < 1.0 ? weight * scale_ : scale_;
  }

  [[nodiscard]] double operator()(double distance) const noexcept
  {
    return atSquaredDistance(distance * distance);
  }

  [[nodiscard]] double support() const noexcept { return support_; }
  [[nodiscard]] double scale() const noexcept { return scale_; }

 private:
  friend class KernelQueue;  // evaluates the same series for many distances at once

  /// @param coefficients highest power first
  [[nodiscard]] static double horner(const std::vector<double>& coefficients, double x) noexcept
  {
    double sum = 0.0;
    for (const double coefficient : coefficients) sum = sum * x + coefficient;
    return sum;
  }

  double support_;
  double squaredSupport_;
  double inverseSupport_;
  double scale_;
  bool fifthPower_;                 ///< of s before the series; else the fourth
  std::vector<double> inSquaredS_;  ///< series in s², highest power first
  std::vector<double> inR_;         ///< series in r, highest power first; empty: 1
};

}  // namespace lamap
