#pragma once

#include <lamap_core/bgk/kernel_queue.h>
#include <lamap_core/bgk/kernels_by_width.h>
#include <lamap_core/grid/weight_scale.h>
#include <lamap_core/training/training_set.h>

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace lamap
{
/// A scan block in the scan's frame: what kernel sums over free-standing points need to know of it.
struct BlockPlace
{
  Eigen::Vector3d firstCell;  ///< lowest corner of the block's first cell [cells]
  bool planar = false;
  int layer = 0;  ///< of a planar map, in the block
};

/// Kernel weights with their factor, for training points that stand anywhere.
struct WeightedKernels
{
  const KernelsByWidth& kernels;
  double factor;
  WeightScale scale;
};

/** Adds up k of the distance to points and segments, or what is expected of it, for the cells of a block
 * within the support. All is added when this ends. */
class PointSums
{
 public:
  PointSums(const WeightedKernels& weights, const BlockPlace& block, BlockSums& sums)
      : weights_(weights), block_(block), sums_(sums), sharp_(weights.kernels.sharp(), weights.scale, sums)
  {
  }

  void addPoint(const PlacedPoint& point);
  /** By the distance to the segment (thesis eq. 4.30; 4.31 with the parameter divided by |PQ|²), once per
   * cell, as wide as the point that is nearest to the cell.
   * @param leftOut cells that it says nothing of; null: none */
  void addSegment(const FreeSegment& segment, const CellMask* leftOut);

  /// Whether any cell was within a support.
  [[nodiscard]] bool any() const { return any_ || sharp_.any(); }

 private:
  template <typename Visit>
  void forEachBoxAlong(const FreeSegment& segment, double support, const Visit& visit) const;
  /// Numbers for the cells of a block's row along x.
  using Row = std::array<double, kScanBlockEdge>;
  struct RowOfBox
  {
    size_t first;  ///< number of the row's first cell in the block
    int firstX;
    int lastX;
    uint64_t leftOut;  ///< a bit for each cell of which nothing is said
  };

  void addSharpRow(const FreeSegment& segment, const RowOfBox& cells, const Row& squared);
  void addRow(const FreeSegment& segment, double length, const RowOfBox& cells, const Row& along,
              const Row& squared);
  void addWide(size_t level, double squared, double factor, size_t cell);

  WeightedKernels weights_;
  BlockPlace block_;
  BlockSums& sums_;
  bool any_ = false;
  KernelQueue sharp_;  ///< of points without a width
};

/// How far from a segment cells have a weight [cells].
[[nodiscard]] double supportOf(const KernelsByWidth& kernels, const FreeSegment& segment);

}  // namespace lamap
