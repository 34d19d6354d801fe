#pragma once

#include <lamap_core/bgk/kernel.h>
#include <lamap_core/grid/weight_scale.h>
#include <lamap_core/training/training_set.h>

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace lamap
{
/// Masks of a block and of the blocks around it, (2·n + 1)³ in total, x fastest; nullptr for missing blocks.
struct MaskNeighbourhood
{
  int blocksEachWay = 1;
  std::vector<const CellMask*> masks;
  std::vector<uint64_t> counts;  ///< working memory of the stencil

  [[nodiscard]] const CellMask* at(int dx, int dy, int dz) const { return rowOf(dy, dz)[dx + 1]; }
  /// Those at dx = −1, 0 and 1.
  [[nodiscard]] const CellMask* const* rowOf(int dy, int dz) const
  {
    const int edge = 2 * blocksEachWay + 1;
    return &masks[static_cast<size_t>(((dz + blocksEachWay) * edge + dy + blocksEachWay) * edge +
                                      blocksEachWay - 1)];
  }
};

/// Eight bits as the bytes of a word.
[[nodiscard]] inline uint64_t bytesOfBits(uint32_t bits)
{
  return ((bits & 0x7Fu) * uint64_t{0x0002040810204081} & 0x0101010101010101) | uint64_t{bits & 0x80u} << 49;
}

/** Sums the kernel weights of training points at cell centres.
 *
 * Immutable: may be shared between threads. */
class CellStencil
{
 public:
  /// @param kernel with its support in cells; @param factor on its weights, > 0; @param planar whether
  /// weights are limited to the layer
  /// @param scale of the sums; nothing: one that fits them
  CellStencil(const Kernel& kernel, double factor, bool planar,
              const std::optional<WeightScale>& scale = std::nullopt);

  /// Largest offset along an axis with a positive weight [cells].
  [[nodiscard]] int reach() const { return reach_; }
  [[nodiscard]] int blocksEachWay() const { return (reach_ + kScanBlockEdge - 1) / kScanBlockEdge; }
  [[nodiscard]] const WeightScale& scale() const { return scale_; }
  /// By squared distance [cells²], in units of the scale.
  [[nodiscard]] const std::vector<int64_t>& weights() const { return weights_; }
  /// How many offsets have each squared distance.
  [[nodiscard]] const std::vector<uint32_t>& classSizes() const { return classSizes_; }
  /// The sum if all cells around are marked.
  [[nodiscard]] int64_t fullSum() const { return fullSum_; }
  /// The sum if all cells on one side of the cell are marked, which is all that lies before a flat surface.
  [[nodiscard]] int64_t sumBesidePlane() const;

  /// Adds the sums for the central block. @return the layers that marked cells reach; the others are
  /// unchanged.
  Layers addUp(MaskNeighbourhood& neighbourhood, BlockSums& sums) const;

 private:
  /// The row of cells with these offsets, as far as |dx| ≤ extent.
  struct Row
  {
    int dy;
    int dz;
    int extent;
  };
  [[nodiscard]] Layers addByCounting(MaskNeighbourhood& neighbourhood, BlockSums& sums) const;
  [[nodiscard]] Layers addByCell(MaskNeighbourhood& neighbourhood, BlockSums& sums) const;
  void addWeighted(const uint64_t* counts, size_t stride, int64_t* sums) const;
  [[nodiscard]] int64_t weight(int dx, int dy, int dz) const
  {
    return weights_[static_cast<size_t>(dx * dx + dy * dy + dz * dz)];
  }

  int reach_ = 0;
  int reachZ_ = 0;  ///< 0 in a planar map
  WeightScale scale_;
  std::vector<Row> rows_;
  std::vector<int64_t> weights_;      ///< by squared distance [cells²]
  std::vector<uint32_t> classSizes_;  ///< number of offsets with that squared distance
  std::vector<uint64_t> fullLanes_;   ///< classSizes_ in each byte: the counts if all cells around are marked
  int64_t fullSum_ = 0;               ///< the sum in that case
  bool countable_ = false;  ///< counts of every class fit in a byte, and the reach in a neighbour block
};

}  // namespace lamap
