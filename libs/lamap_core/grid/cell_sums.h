#pragma once

#include <cstdint>
#include <optional>

namespace lamap
{
/// Fractional bits of the fixed-point sums that cells hold.
constexpr int kEvidenceFractionBits = 20;
constexpr double kEvidenceUnit = 1.0 / (1 << kEvidenceFractionBits);

/** The evidence of a cell: two sums in units of 2^-20, without any prior. What they mean is the learner's
 * business; how they are coded is their SumKind. */
struct CellSums
{
  uint64_t first = 0;
  uint64_t second = 0;

  [[nodiscard]] bool any() const { return (first | second) != 0; }
  friend bool operator==(const CellSums& a, const CellSums& b)
  {
    return a.first == b.first && a.second == b.second;
  }
};

/// What the sums of a map are: this alone decides how they add.
enum class SumKind : uint8_t
{
  Counts,  ///< below 2^63, each as it is
  Signed   ///< within ±kMostSignedSum, each of which may be missing: coded as SignedSums says
};

/// Signed sums must stay within ±kMostSignedSum.
constexpr int64_t kMostSignedSum = int64_t{1} << 61;

/** Two signed sums, each of which may be missing.
 *
 * Blocks and files hold each as an unsigned number: 0 where the sum is missing, else one more than the sum
 * with its sign in the lowest bit. */
struct SignedSums
{
  std::optional<int64_t> first;
  std::optional<int64_t> second;

  [[nodiscard]] static SignedSums of(const CellSums& sums)
  {
    return {decoded(sums.first), decoded(sums.second)};
  }
  [[nodiscard]] CellSums coded() const { return {encoded(first), encoded(second)}; }

  [[nodiscard]] static uint64_t encoded(std::optional<int64_t> sum)
  {
    if (!sum) return 0;
    return (static_cast<uint64_t>(*sum) << 1 ^ (*sum < 0 ? ~uint64_t{0} : 0)) + 1;
  }
  [[nodiscard]] static std::optional<int64_t> decoded(uint64_t code)
  {
    if (code == 0) return std::nullopt;
    const uint64_t folded = code - 1;
    return static_cast<int64_t>(folded >> 1 ^ ((folded & 1) != 0 ? ~uint64_t{0} : 0));
  }
};

/// The largest number by which a cell holds a sum.
[[nodiscard]] constexpr uint64_t mostCode(SumKind kind)
{
  constexpr uint64_t kMostCount = ~uint64_t{0} >> 1;
  return kind == SumKind::Counts ? kMostCount : 2 * static_cast<uint64_t>(kMostSignedSum) + 1;
}

/// A number in units of 2^-20, rounded half up and held to ±kMostSignedSum. @param number not NaN
[[nodiscard]] int64_t inEvidenceUnits(double number);

/// Adds the sums of the second to those of the first. @throws std::overflow_error if one would pass its
/// limit.
[[nodiscard]] CellSums addSums(SumKind kind, const CellSums& to, const CellSums& added);

/** Mean sums of some cells, rounded half up. Of `Signed` sums a missing one counts as 0 unless all are
 * missing; of `Counts` at least one is positive. @param count ≥ 1 */
[[nodiscard]] CellSums meanSums(SumKind kind, const CellSums* cells, uint32_t count);

}  // namespace lamap
