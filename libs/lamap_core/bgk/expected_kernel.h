#pragma once

#include <lamap_core/bgk/kernel.h>

#include <array>
#include <cstddef>
#include <vector>

namespace lamap
{
/** The expected kernel E[k(|x − q|)] of a training point that is uncertain, x ~ N(place, width² I)
 * (thesis 5.1).
 *
 * The sum of a point's weights over all cells does not depend on its width: sharp points outweigh wide ones.
 *
 * Each compactly supported kernel is written as a sum of one or two Gaussians, whose expectation is again a
 * Gaussian, and separable: Σ cᵢ (τᵢ²/(τᵢ² + s²))^(D/2) exp(−d²/2(τᵢ² + s²)). They were fitted to the exact
 * expectation, and are within 0.002 of its largest value for widths of at least a quarter of the support. Cut
 * where a coordinate is farther than the support and three widths. Immutable: may be shared between threads.
 */
class ExpectedKernel
{
 public:
  /// A Gaussian along one axis, of weights for whole cells.
  struct Term
  {
    double factor;               ///< of the product over the axes
    double inverseSquare;        ///< 1/(τ² + s²)
    std::vector<float> weights;  ///< at −reach … reach cells
  };

  /** @param shape, support, scale as of Kernel; the support in cells
   *  @param width s [cells], at least a quarter of the support
   *  @param planar whether points move in the plane only */
  ExpectedKernel(KernelShape shape, double support, double scale, double width, bool planar);

  /// Cells farther than this along an axis have no weight.
  [[nodiscard]] int reach() const { return reach_; }
  [[nodiscard]] double support() const { return support_; }
  [[nodiscard]] const std::vector<Term>& terms() const { return terms_; }

  /// @param squaredDistance [cells²]. @return weight [-]; 0 from the support on.
  [[nodiscard]] double atSquaredDistance(double squaredDistance) const;

 private:
  double support_;
  int reach_;
  std::vector<Term> terms_;
};

}  // namespace lamap
