#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace lamap
{
/** The features of a few points at a time, φ = L⁻¹·k: the inner loops of NystroemFeatures, with as many lanes
 * as the processor has, which changes no bit. */
class NystroemRows
{
 public:
  static constexpr size_t kAtOnce = 4;  ///< points

  /** @param inducing [m] by axis, equally many; @param inverse L⁻¹, lower triangle by rows of m numbers
   *  @param gamma [m⁻²] */
  NystroemRows(const std::array<std::vector<float>, 3>& inducing, const std::vector<double>& inverse,
               double gamma);

  /// Numbers a point in the arrays below: a feature each, then 0.
  [[nodiscard]] size_t stride() const { return stride_; }

  /// The kernel between a point [m] and each inducing point. @param kernels stride() numbers
  void kernelsOf(const std::array<float, 3>& point, float* kernels, bool wide) const;
  /// @param kernels, features: kAtOnce × stride() numbers. @param wide as hasAvx2()
  void featuresOf(const float* kernels, float* features, bool wide) const;

  [[nodiscard]] size_t memoryBytes() const
  {
    return inducing_[0].size() * inducing_.size() * sizeof(float) + inverse_.size() * sizeof(Line);
  }

 private:
  /// Sixteen neighbouring rows of a column of L⁻¹, a line of the processor's cache.
  struct alignas(64) Line
  {
    std::array<float, 16> rows{};
  };
  struct Tables;
  [[nodiscard]] Tables tables() const;

  size_t components_;
  size_t stride_;
  float exponent_;                              ///< −γ
  std::array<std::vector<float>, 3> inducing_;  ///< stride_ numbers each
  /// L⁻¹ by sixteen rows: of these the columns, as far as the diagonal. What lies beyond is 0.
  std::vector<Line> inverse_;
};

}  // namespace lamap
