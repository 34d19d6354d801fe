#pragma once

#include <lamap_core/grid/signed_evidence.h>

#include <cstdint>
#include <optional>

namespace lamap
{
/** Two sums of log-odds of a cell in units of 2^-20, each of which may be missing: what the cell's field of
 * view saw, and what was said of it from outside of it.
 * Coded as signed_evidence.h says. */
struct LogoddsSums
{
  std::optional<int64_t> inField;
  std::optional<int64_t> outOfField;

  /// Sums must stay within ±kLimit.
  static constexpr int64_t kLimit = kMostSignedSum;

  [[nodiscard]] static LogoddsSums of(const Evidence& evidence)
  {
    return {decoded(evidence.occupied), decoded(evidence.free)};
  }
  [[nodiscard]] Evidence evidence() const { return {encoded(inField), encoded(outOfField)}; }

  [[nodiscard]] static uint64_t encoded(std::optional<int64_t> sum) { return encodedSum(sum); }
  [[nodiscard]] static std::optional<int64_t> decoded(uint64_t code) { return decodedSum(code); }
};

/// Log-odds, weighted, in units of 2^-20; those beyond ±1000 are held to that.
[[nodiscard]] int64_t logoddsUnits(float logodds, double weight);

/// Adds the second to the first. @throws std::overflow_error as addSigned().
[[nodiscard]] inline Evidence addLogodds(const Evidence& to, const Evidence& added)
{
  return addSigned(to, added);
}

/// Log-odds of a cell: the sum of what was seen in the field, else what was said from outside, held to a
/// limit.
[[nodiscard]] double logoddsOf(const Evidence& evidence, double outOfFieldLimit);

/// Mean evidence of the cells of an octant; false where only some of them were in a field.
[[nodiscard]] bool meanLogodds(const DenseBlock& block, uint32_t first, uint32_t count, Evidence& mean);

/// Adds log-odds to the cells of a map block.
using LogoddsAdder = SignedAdder;

}  // namespace lamap
