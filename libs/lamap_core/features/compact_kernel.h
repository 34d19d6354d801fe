#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace lamap
{
/** A Gaussian covariance as the expected kernel needs it.
 *
 * For x ~ N(m, Σ), E[exp(−γ|x − c|²)] = factor · exp(−γ (m − c)ᵀ A (m − c)) with A = (I + 2γΣ)⁻¹ and
 * factor = |I + 2γΣ|^(−1/2): the closed form of the reproducing kernel method of Ramos and Ott (2015). */
struct GaussianBlur
{
  /// @param covariance [m²], symmetric, positive semidefinite; @param gamma [m⁻²]
  GaussianBlur(const Eigen::Matrix3d& covariance, double gamma);

  double factor;
  Eigen::Matrix3d inverse;   ///< A
  Eigen::Vector3d widening;  ///< sqrt of the diagonal of I + 2γΣ

  /// @return dᵀ A d
  [[nodiscard]] double squaredDistance(const Eigen::Vector3d& d) const;
};

/** The radial basis function cut off: k(d) = max(0, exp(−γ d²) − cutoff), exactly 0 at and beyond the support
 * sqrt(ln(1/cutoff)/γ).
 *
 * For an uncertain point the expectation of the radial basis function stands in the place of exp(−γ d²): with
 * cutoff 0 exactly the expected kernel, else less than it by no more than the cutoff.
 * Immutable: may be shared between threads.
 */
class CompactKernel
{
 public:
  static constexpr double kDefaultGamma = 14.0;  ///< [m⁻²]
  static constexpr double kDefaultCutoff = 0.03;

  /// @param gamma [m⁻²] finite, > 0; @param cutoff in (0, 1)
  /// @throws std::invalid_argument naming the parameter, its value and the legal range
  explicit CompactKernel(double gamma = kDefaultGamma, double cutoff = kDefaultCutoff);

  [[nodiscard]] double gamma() const { return gamma_; }
  [[nodiscard]] double cutoff() const { return cutoff_; }
  [[nodiscard]] double support_m() const { return support_m_; }

  /// One factor of exp(−γ d²) = Π exp(−γ dₐ²); 0 at and beyond the support.
  [[nodiscard]] float alongAxis(double distance_m) const;

  /// k from its factors along the axes.
  [[nodiscard]] float fromFactors(float yz, float x) const { return std::max(yz * x - cutoffF_, 0.0f); }
  [[nodiscard]] float cutoffF() const { return cutoffF_; }

  /// @param d point less centre [m]
  [[nodiscard]] float at(const Eigen::Vector3d& d) const;
  [[nodiscard]] float at(const Eigen::Vector3d& d, const GaussianBlur& blur) const;

  /// Largest distance along each axis at which an uncertain point reaches [m]; 0 where it reaches nothing.
  [[nodiscard]] Eigen::Vector3d reach_m(const GaussianBlur& blur) const;

 private:
  double gamma_;
  double cutoff_;
  double support_m_;
  float cutoffF_;
};

/// The sites along one axis that a coordinate reaches, and the kernel's factor of each; 0 beyond `count`.
struct AxisReach
{
  static constexpr int kMaxSites = 16;
  int32_t first = 0;  ///< from the site that holds the coordinate
  int32_t count = 0;
  float largest = 0;  ///< of the factors
  std::array<float, kMaxSites> factors{};
};

/// The same, for a coordinate on the axis.
struct AxisWindow
{
  int32_t first = 0;  ///< site
  const AxisReach* reach = nullptr;

  [[nodiscard]] int32_t count() const { return reach->count; }
  [[nodiscard]] int32_t last() const { return first + reach->count - 1; }
  [[nodiscard]] float factor(int32_t i) const { return reach->factors[static_cast<size_t>(i)]; }
};

/** A kernel of hundreds of cells is a mistake in the unit; to list its cells would not end.
 * @throws std::invalid_argument naming gamma and what is legal */
void requireSupport(const CompactKernel& kernel, double resolution_m);

/** Finds the sites of a lattice that a coordinate reaches, with its factors of the kernel.
 *
 * They depend on where in its site the coordinate is, to 2^-24 m, and not on where the site is: wherever on a
 * map something was measured, the numbers are the same. Cells repeat a few such places, which are remembered.
 * Not to be shared between threads. */
class AxisReaches
{
 public:
  /** @param spacing_m of the lattice
   *  @throws std::invalid_argument as requireReach() */
  AxisReaches(const CompactKernel& kernel, double spacing_m);

  /// @throws std::invalid_argument if the kernel reaches more than AxisReach::kMaxSites sites of a lattice,
  /// or leaves places between the sites that none of them reaches.
  static void requireReach(const CompactKernel& kernel, double spacing_m);

  /// @param coordinate [m] from the corner of site 0, below 1e6. Valid until the next call.
  [[nodiscard]] AxisWindow of(double coordinate);
  /** The same without a memory, for any thread, in two steps: first which sites are reached,
   *  @param reach receives first and count; @param place_m receives where in its site the coordinate is
   *  @return the site that holds the coordinate */
  static int32_t findRange(const CompactKernel& kernel, double spacing_m, double coordinate, AxisReach& reach,
                           double& place_m);
  /// then the factors of these.
  static void findFactors(const CompactKernel& kernel, double spacing_m, double place_m, AxisReach& reach);
  /// The one site along an axis that a planar map has not.
  [[nodiscard]] static AxisWindow flat();

  /// The site that holds a coordinate; one within a millionth of the upper face belongs to the next.
  [[nodiscard]] static int32_t siteOf(double coordinate, double spacing_m)
  {
    return static_cast<int32_t>(std::floor(coordinate / spacing_m + 1e-6));
  }

 private:
  struct Entry
  {
    int64_t place = INT64_MIN;  ///< in the site [2^-24 m]
    AxisReach reach;
  };
  static constexpr size_t kRemembered = 256;
  CompactKernel kernel_;
  double spacing_m_;
  std::vector<Entry> remembered_;
};

}  // namespace lamap
