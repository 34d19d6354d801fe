#pragma once

#include <lamap_core/features/compact_kernel.h>

#include <cstdint>
#include <optional>

namespace lamap
{
/// How a point becomes a vector of features.
enum class HilbertFeatures
{
  Compact,  ///< CompactKernel, centred on the sites of a lattice that held a training point
  Nystroem  ///< NystroemFeatures (thesis 2.4.2)
};

/// The features of a Hilbert map, and what is expected of their weights; fixed for its life.
struct FeatureOptions
{
  HilbertFeatures features = HilbertFeatures::Compact;
  std::optional<double> gamma;  ///< γ of the kernel [m⁻²]; empty: 14 (`Compact`), 3 (`Nystroem`)
  double cutoff = CompactKernel::kDefaultCutoff;  ///< taken off the compact kernel so that it ends
  double latticeSpacing = 0.25;                   ///< h of the compact kernel's lattice [m]
  uint32_t components = 100;    ///< m of `Nystroem`; with as many points or fewer, all of them
  uint32_t seed = 1;            ///< of the inducing points, and of the order in SGD
  double priorPrecision = 0.1;  ///< λ of each weight before any data, > 0

  /// γ, filled in.
  [[nodiscard]] double resolvedGamma() const;
  [[nodiscard]] CompactKernel kernel() const { return CompactKernel(resolvedGamma(), cutoff); }

  /// Whether the kernel suits the lattice and the cells. @throws std::invalid_argument naming the option that
  /// does not, its value and what is legal.
  void validateLattice(double resolution_m) const;
};

}  // namespace lamap
