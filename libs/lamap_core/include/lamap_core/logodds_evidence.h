#pragma once

#include <lamap_core/octant_rule.h>

#include <cstdint>
#include <optional>
#include <vector>

namespace lamap
{
/** Two sums of log-odds of a cell in units of 2^-20, each of which may be missing: what the cell's field of
 * view saw, and what was said of it from outside of it.
 *
 * Blocks hold evidence as two unsigned numbers, for which these stand: 0 where a sum is missing, else one
 * more than the sum with its sign in the lowest bit. So blocks, octants and files are those of all maps. */
struct LogoddsSums
{
  std::optional<int64_t> inField;
  std::optional<int64_t> outOfField;

  /// Sums must stay within ±kLimit.
  static constexpr int64_t kLimit = int64_t{1} << 61;

  [[nodiscard]] static LogoddsSums of(const Evidence& evidence)
  {
    return {decoded(evidence.occupied), decoded(evidence.free)};
  }
  [[nodiscard]] Evidence evidence() const { return {encoded(inField), encoded(outOfField)}; }

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

/// Log-odds, weighted, in units of 2^-20; those beyond ±1000 are held to that.
[[nodiscard]] int64_t logoddsUnits(float logodds, double weight);

/// Adds the second to the first. @throws std::overflow_error if a sum would pass ±LogoddsSums::kLimit.
[[nodiscard]] Evidence addLogodds(const Evidence& to, const Evidence& added);

/// Log-odds of a cell: the sum of what was seen in the field, else what was said from outside, held to a
/// limit.
[[nodiscard]] double logoddsOf(const Evidence& evidence, double outOfFieldLimit);

/// Mean evidence of the cells of an octant; false where only some of them were in a field.
[[nodiscard]] bool meanLogodds(const DenseBlock& block, uint32_t first, uint32_t count, Evidence& mean);

/// Adds log-odds to the cells of a map block.
class LogoddsAdder
{
 public:
  explicit LogoddsAdder(const BlockShape& shape);

  /// Starts a new block: nothing to add.
  void clear();
  void set(uint32_t offset, const Evidence& evidence)
  {
    added_[offset] = evidence;
    touched_[offset >> 6] |= uint64_t{1} << (offset & 63);
  }
  [[nodiscard]] bool any() const;
  /// @throws std::overflow_error as addLogodds(); the block is unchanged then.
  void addTo(EvidenceBlock& block, const OctantRule& rule);

 private:
  BlockShape shape_;
  DenseBlock dense_;
  std::vector<Evidence> added_;
  std::vector<uint64_t> touched_;
};

}  // namespace lamap
