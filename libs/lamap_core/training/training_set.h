#pragma once

#include <lamap_core/grid/cell.h>
#include <lamap_core/grid/scan_blocks.h>

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace lamap
{
/// A bit for each cell of a scan block: 64-bit word z, bit y·8 + x.
using CellMask = std::array<uint64_t, kScanBlockEdge>;

/// Cells of one scan block, by what the scan says of them.
struct BlockMasks
{
  CellMask hit{};           ///< holds a hit
  CellMask free{};          ///< holds a free sample
  CellMask protectedHit{};  ///< holds so many hits that it takes no free evidence from this scan
  bool anyHit = false;
  bool anyFree = false;
};

/// A ray's free part, in the scan's frame [cells].
struct FreeSegment
{
  Eigen::Vector3d begin;
  Eigen::Vector3d end;
};

/** What a scan teaches (thesis 4.2.1 and 4.4): points with label 1 and 0, in the scan's frame.
 *
 * Which members are filled follows the options: cells in `masks`; hits of `Centroids` in hitPoints; free
 * points of `Centroids` in freePoints; rays of `Line` in freeSegments. `masks` is always there for the
 * protected cells. */
struct TrainingSet
{
  ScanBlocks blocks;              ///< in blocks of the scan, relative to the anchor's block
  std::vector<BlockMasks> masks;  ///< by block number
  std::vector<Eigen::Vector3d> hitPoints;
  std::vector<Eigen::Vector3d> freePoints;
  std::vector<FreeSegment> freeSegments;
};

/// Cell relative to the anchor → cell relative to the first cell of the anchor's scan block.
struct BlockOffset
{
  explicit BlockOffset(const CellIndex& anchor)
      : x(anchor.x & (kScanBlockEdge - 1)),
        y(anchor.y & (kScanBlockEdge - 1)),
        z(anchor.z & (kScanBlockEdge - 1))
  {
  }
  int32_t x, y, z;
};

}  // namespace lamap
