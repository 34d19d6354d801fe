#pragma once

#include <lamap_core/grid/evidence_block.h>
#include <lamap_core/grid/scan_blocks.h>

#include <array>
#include <cstdint>

namespace lamap
{
/** Kernel weights as whole numbers of a small unit: their sums depend on no order.
 *
 * A positive weight is at least one unit, so that a sum is positive exactly where a point lies within the
 * support. */
class WeightScale
{
 public:
  /// @param largest weight of one point, > 0; @param points that may add up in one cell, ≥ 1
  WeightScale(double largest, double points)
  {
    // 62 bits hold the largest sum; 40 fractional bits are more than any use needs.
    int fractionBits = 40;
    while (fractionBits > kEvidenceFractionBits &&
           largest * points * static_cast<double>(int64_t{1} << fractionBits) > 0x1p62)
      --fractionBits;
    unitsPerOne_ = static_cast<double>(int64_t{1} << fractionBits);
    shift_ = fractionBits - kEvidenceFractionBits;
    half_ = shift_ > 0 ? int64_t{1} << (shift_ - 1) : 0;
  }

  [[nodiscard]] int64_t quantized(double weight) const
  {
    const auto units = static_cast<int64_t>(weight * unitsPerOne_ + 0.5);
    return units > 0 ? units : 1;
  }
  /// A sum of weights in units of cell evidence, rounded once, at least one unit if it is positive.
  [[nodiscard]] uint64_t evidence(int64_t sum) const
  {
    const auto rounded = static_cast<uint64_t>((sum + half_) >> shift_);
    return rounded > 0 || sum == 0 ? rounded : 1;
  }
  /// A sum that is this evidence.
  [[nodiscard]] int64_t sumOf(uint64_t evidence) const { return static_cast<int64_t>(evidence << shift_); }

 private:
  double unitsPerOne_;
  int shift_;
  int64_t half_;
};

/// A sum for each cell of a scan block, in the weights' unit: index (z·8 + y)·8 + x.
using BlockSums = std::array<int64_t, kScanBlockCells>;

/// Layers [begin, end) of a scan block, e.g. those in which a sum may be positive.
struct Layers
{
  int begin = kScanBlockEdge;
  int end = 0;

  [[nodiscard]] bool any() const { return begin < end; }
  void include(const Layers& other)
  {
    begin = begin < other.begin ? begin : other.begin;
    end = end > other.end ? end : other.end;
  }
};

}  // namespace lamap
