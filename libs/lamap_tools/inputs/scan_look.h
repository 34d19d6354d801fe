#pragma once

#include <lamap_core/scan/scan.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace lamap::tools
{
/// Shortest and longest of some lengths [m].
struct LengthSpan
{
  double shortest_m = 0;
  double longest_m = 0;

  void include(const LengthSpan& other);
};

/// What the rays of one scan are.
struct ScanLook
{
  /// How many of each RayEnd, in its order; of the returns, those that are finite.
  std::array<uint64_t, 5> rays{};
  uint64_t notFinite = 0;            ///< returns at NaN or infinity
  std::optional<LengthSpan> ranges;  ///< of the finite returns, from the centre of their fan
  /// What the observation states; a maximum of 0: unlimited. Nothing: it states no range.
  std::optional<LengthSpan> statedRanges;
  /// Finite returns whose range is the longest one to 0.1 %.
  uint64_t farthestReturns = 0;

  [[nodiscard]] uint64_t count(RayEnd end) const { return rays[static_cast<size_t>(end)]; }
  [[nodiscard]] uint64_t rayCount() const;

  /** Whether it looks as if a driver wrote what lies beyond the useful range as returns at one constant
   * distance: a twentieth of at least 100 returns are at the longest range, and no maximum is stated. */
  [[nodiscard]] bool hasPhantomShell() const;
};

[[nodiscard]] ScanLook lookAt(const Scan& scan);

}  // namespace lamap::tools
