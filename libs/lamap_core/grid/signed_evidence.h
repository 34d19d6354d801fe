#pragma once

#include <lamap_core/grid/octant_rule.h>

#include <cstdint>
#include <optional>
#include <vector>

namespace lamap
{
// Blocks hold evidence as two unsigned numbers. Here these stand for two signed sums in units of 2^-20, each
// of which may be missing: 0 where a sum is missing, else one more than the sum with its sign in the lowest
// bit. So blocks, octants and files are those of all maps.

/// Signed sums must stay within ±kMostSignedSum.
constexpr int64_t kMostSignedSum = int64_t{1} << 61;

[[nodiscard]] inline uint64_t encodedSum(std::optional<int64_t> sum)
{
  if (!sum) return 0;
  return (static_cast<uint64_t>(*sum) << 1 ^ (*sum < 0 ? ~uint64_t{0} : 0)) + 1;
}

[[nodiscard]] inline std::optional<int64_t> decodedSum(uint64_t code)
{
  if (code == 0) return std::nullopt;
  const uint64_t folded = code - 1;
  return static_cast<int64_t>(folded >> 1 ^ ((folded & 1) != 0 ? ~uint64_t{0} : 0));
}

/// Adds the sums of the second to those of the first.
/// @throws std::overflow_error if one would pass ±kMostSignedSum.
[[nodiscard]] Evidence addSigned(const Evidence& to, const Evidence& added);

/// Mean sums of the cells of an octant, rounded half up, a missing one counting as 0 unless all are missing.
[[nodiscard]] Evidence meanSigned(const DenseBlock& block, uint32_t first, uint32_t count);

/// Adds signed sums to the cells of a map block.
class SignedAdder
{
 public:
  explicit SignedAdder(const BlockShape& shape);

  /// Starts a new block: nothing to add.
  void clear();
  void set(uint32_t offset, const Evidence& evidence)
  {
    added_[offset] = evidence;
    touched_[offset >> 6] |= uint64_t{1} << (offset & 63);
  }
  [[nodiscard]] bool any() const;
  /// @throws std::overflow_error as addSigned(); the block is unchanged then.
  void addTo(EvidenceBlock& block, const OctantRule& rule);

 private:
  BlockShape shape_;
  DenseBlock dense_;
  std::vector<Evidence> added_;
  std::vector<uint64_t> touched_;
};

}  // namespace lamap
