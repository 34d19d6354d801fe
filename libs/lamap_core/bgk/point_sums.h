#pragma once

#include <lamap_core/bgk/kernels_by_width.h>
#include <lamap_core/grid/weight_scale.h>
#include <lamap_core/training/training_set.h>

#include <Eigen/Core>
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

/// Adds k(|x − point|), or what is expected of it, for the cells of the block within the support.
/// @return false if there are none.
bool addPoint(const WeightedKernels& weights, const PlacedPoint& point, const BlockPlace& block,
              BlockSums& sums);

/// Adds k of the distance to the segment (thesis eq. 4.30; 4.31 with the parameter divided by |PQ|²), once
/// per cell, as wide as the point that is nearest to the cell.
bool addSegment(const WeightedKernels& weights, const FreeSegment& segment, const BlockPlace& block,
                BlockSums& sums);

/// How far from a segment cells have a weight [cells].
[[nodiscard]] double supportOf(const KernelsByWidth& kernels, const FreeSegment& segment);

}  // namespace lamap
