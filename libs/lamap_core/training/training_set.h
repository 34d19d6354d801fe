#pragma once

#include <lamap_core/grid/cell.h>
#include <lamap_core/grid/scan_blocks.h>
#include <lamap_core/scan/ray_selection.h>
#include <lamap_core/scan/scan_frame.h>
#include <lamap_core/training/point_width.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <vector>

namespace lamap
{
/// A bit for each cell of a scan block: 64-bit word z, bit y·8 + x.
using CellMask = std::array<uint64_t, kScanBlockEdge>;

/// Cells of one scan block, by what the scan says of them.
struct BlockMasks
{
  CellMask hit{};             ///< holds a hit
  CellMask free{};            ///< holds a free sample
  CellMask freeWithoutHit{};  ///< holds a free sample of a ray without a hit; counts where no ray ended
  CellMask silent{};          ///< no such sample, but one of a wide beam without an echo, which weighs less
  CellMask protectedHit{};    ///< takes no free evidence from this scan: has enough hits, or is in a cap
  CellMask ended{};           ///< a ray ended here with a hit, whatever the training points are
  bool anyHit = false;
  bool anyFree = false;
  bool anySilent = false;
};

/// Cells of one scan block whose points have one width, none of them in the block's BlockMasks or sharper
/// too.
struct WideMasks
{
  CellMask hit{};
  CellMask free{};
  CellMask freeWithoutHit{};  ///< as in BlockMasks
  bool anyHit = false;
  bool anyFree = false;
};

/// A ray's free part, in the scan's frame [cells].
struct FreeSegment
{
  Eigen::Vector3d begin;
  Eigen::Vector3d end;
  RayWidth width;  ///< of its points, by their distance from begin [cells²]
  double weight;   ///< as of a PlacedPoint
  bool hasHit;     ///< behind its end; else it says nothing of cells in which other rays of the scan ended
};

/// Cell relative to the anchor → cell relative to the first cell of the scan block that the anchor is in.
struct BlockOffset
{
  /// Scan blocks begin at the anchor.
  BlockOffset() = default;
  /// Scan blocks lie where blocks of 8 cells of the map lie.
  explicit BlockOffset(const CellIndex& anchor)
      : x(anchor.x & (kScanBlockEdge - 1)),
        y(anchor.y & (kScanBlockEdge - 1)),
        z(anchor.z & (kScanBlockEdge - 1))
  {
  }
  int32_t x = 0, y = 0, z = 0;
};

/// What a scan teaches of one place.
struct TrainingPoint
{
  Eigen::Vector3d place;
  bool occupied = false;  ///< the label
  double weight = 1;
  double width = 0;  ///< root mean square, over the axes, of its standard deviation; 0: it is exactly there
};

/// A training point by itself, in the scan's frame [cells].
struct PlacedPoint
{
  Eigen::Vector3d place;
  double width = 0;   ///< as of a TrainingPoint
  double weight = 1;  ///< as a share of that of its kind
};

/** What a scan teaches (thesis 4.2.1 and 4.4): points with label 1 and 0, in the scan's frame [cells].
 *
 * Which members are filled follows the rules: cells in `masks` and `wideMasks`; hits of `Centroids`, and all
 * that share the echo of a wide beam, in hitPoints; free points of `Centroids` in freePoints; rays of `Line`
 * in freeSegments. `masks` always has the cells in which rays ended and the protected ones. */
struct TrainingSet
{
  BlockOffset offset;             ///< of the scan blocks
  ScanBlocks blocks;              ///< relative to the block of the anchor
  std::vector<BlockMasks> masks;  ///< by block number; of points that are exactly where they are
  std::array<std::vector<WideMasks>, kWideLevels> wideMasks;  ///< of kWidthLevels[i + 1], by block number
  double widthUnit = 1;                                       ///< of kWidthLevels [cells]
  std::vector<PlacedPoint> hitPoints;
  std::vector<PlacedPoint> freePoints;
  std::vector<FreeSegment> freeSegments;
  double hitWeight = 1;
  double freeWeight = 1;
  double silentWeight = 1;  ///< of silent cells, as a share of freeWeight
  RayCounts counts;         ///< what became of the scan's rays

  /// @param cell relative to the anchor
  [[nodiscard]] bool isIn(CellMask BlockMasks::*mask, const CellIndex& cell) const;
  /// Cells in a layer of a block that hold a free sample, of any width, silent ones aside: bits as of a
  /// CellMask.
  [[nodiscard]] uint64_t freeInLayer(size_t block, size_t z) const;
  /// @param cell relative to the anchor
  [[nodiscard]] bool holdsFree(const CellIndex& cell) const;
  /// Forgets that the cell holds free samples, of any width.
  void removeFree(const CellIndex& cell);

  /// Calls visit(cell relative to the anchor) for each cell of a mask.
  template <typename Visit>
  void forEachCell(CellMask BlockMasks::*mask, Visit&& visit) const;

  /** Calls visit(TrainingPoint) for each point: cells by block (sorted), width, z, y, x, silent ones after
   * the others without a width; then the hits, then the free points where they are. Free points in protected
   * cells are left out; segments are no points. */
  template <typename Visit>
  void forEachPoint(Visit&& visit) const;

 private:
  /// Where a cell is in the masks.
  struct Place
  {
    int32_t block;  ///< −1: in none
    size_t word;
    uint64_t bit;
  };
  [[nodiscard]] Place placeOf(const CellIndex& cell) const;
};

inline TrainingSet::Place TrainingSet::placeOf(const CellIndex& cell) const
{
  const CellIndex inBlocks{cell.x + offset.x, cell.y + offset.y, cell.z + offset.z};
  const int32_t number = blocks.find(
      {inBlocks.x >> kScanBlockLog2Edge, inBlocks.y >> kScanBlockLog2Edge, inBlocks.z >> kScanBlockLog2Edge});
  constexpr int32_t kLow = kScanBlockEdge - 1;
  return {number, static_cast<size_t>(inBlocks.z & kLow),
          uint64_t{1} << ((inBlocks.y & kLow) * kScanBlockEdge + (inBlocks.x & kLow))};
}

inline bool TrainingSet::isIn(CellMask BlockMasks::*mask, const CellIndex& cell) const
{
  const Place place = placeOf(cell);
  const auto number = static_cast<size_t>(place.block);
  return place.block >= 0 && number < masks.size() && ((masks[number].*mask)[place.word] & place.bit) != 0;
}

inline uint64_t TrainingSet::freeInLayer(size_t block, size_t z) const
{
  uint64_t free = block < masks.size() ? masks[block].free[z] : 0;
  for (const std::vector<WideMasks>& level : wideMasks)
    if (block < level.size()) free |= level[block].free[z];
  return free;
}

inline bool TrainingSet::holdsFree(const CellIndex& cell) const
{
  const Place place = placeOf(cell);
  if (place.block < 0) return false;
  const auto number = static_cast<size_t>(place.block);
  const uint64_t silent = number < masks.size() ? masks[number].silent[place.word] : 0;
  return ((freeInLayer(number, place.word) | silent) & place.bit) != 0;
}

inline void TrainingSet::removeFree(const CellIndex& cell)
{
  const Place place = placeOf(cell);
  if (place.block < 0) return;
  const auto number = static_cast<size_t>(place.block);
  const auto removeFrom = [&](auto& cells)
  {
    cells.free[place.word] &= ~place.bit;
    cells.freeWithoutHit[place.word] &= ~place.bit;
  };
  if (number < masks.size())
  {
    removeFrom(masks[number]);
    masks[number].silent[place.word] &= ~place.bit;
  }
  for (std::vector<WideMasks>& level : wideMasks)
    if (number < level.size()) removeFrom(level[number]);
}

template <typename Visit>
void TrainingSet::forEachCell(CellMask BlockMasks::*mask, Visit&& visit) const
{
  for (size_t number = 0; number < masks.size(); ++number)
  {
    const BlockIndex& block = blocks.blocks()[number];
    const CellMask& cells = masks[number].*mask;
    for (int32_t z = 0; z < kScanBlockEdge; ++z)
      for (uint64_t rest = cells[static_cast<size_t>(z)]; rest != 0; rest &= rest - 1)
      {
        const int bit = __builtin_ctzll(rest);
        visit(CellIndex{block.x * kScanBlockEdge - offset.x + bit % kScanBlockEdge,
                        block.y * kScanBlockEdge - offset.y + bit / kScanBlockEdge,
                        block.z * kScanBlockEdge - offset.z + z});
      }
  }
}

template <typename Visit>
void TrainingSet::forEachPoint(Visit&& visit) const
{
  std::vector<uint32_t> order(masks.size());
  std::iota(order.begin(), order.end(), uint32_t{0});
  std::sort(order.begin(), order.end(),
            [&](uint32_t a, uint32_t b) { return blocks.blocks()[a] < blocks.blocks()[b]; });
  for (const uint32_t number : order)
  {
    const auto visitCells = [&](const CellMask& hits, const CellMask& frees, double weight, double width)
    {
      const BlockIndex& block = blocks.blocks()[number];
      for (size_t z = 0; z < kScanBlockEdge; ++z)
      {
        const uint64_t free = frees[z] & ~masks[number].protectedHit[z];
        for (uint64_t rest = hits[z] | free; rest != 0; rest &= rest - 1)
        {
          const int bit = __builtin_ctzll(rest);
          const int row = bit / kScanBlockEdge;
          const Eigen::Vector3d centre(block.x * kScanBlockEdge - offset.x + bit % kScanBlockEdge + 0.5,
                                       block.y * kScanBlockEdge - offset.y + row + 0.5,
                                       block.z * kScanBlockEdge - offset.z + static_cast<int>(z) + 0.5);
          if ((hits[z] >> bit & 1) != 0) visit(TrainingPoint{centre, true, hitWeight, width});
          if ((free >> bit & 1) != 0) visit(TrainingPoint{centre, false, weight, width});
        }
      }
    };
    visitCells(masks[number].hit, masks[number].free, freeWeight, 0.0);
    if (masks[number].anySilent) visitCells({}, masks[number].silent, freeWeight * silentWeight, 0.0);
    for (size_t level = 0; level < kWideLevels; ++level)
    {
      if (number >= wideMasks[level].size()) continue;
      const WideMasks& wide = wideMasks[level][number];
      visitCells(wide.hit, wide.free, freeWeight, kWidthLevels[level + 1] * widthUnit);
    }
  }
  for (const PlacedPoint& hit : hitPoints)
    visit(TrainingPoint{hit.place, true, hitWeight * hit.weight, hit.width});
  for (const PlacedPoint& free : freePoints)
    if (!isIn(&BlockMasks::protectedHit, cellOfLocal(free.place)))
      visit(TrainingPoint{free.place, false, freeWeight * free.weight, free.width});
}

}  // namespace lamap
