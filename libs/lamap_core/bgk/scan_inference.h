#pragma once

#include <lamap_core/bgk/cell_stencil.h>
#include <lamap_core/bgk/options.h>
#include <lamap_core/bgk/point_sums.h>
#include <lamap_core/grid/block_grid.h>
#include <lamap_core/grid/octant_rule.h>
#include <lamap_core/training/scan_training.h>

#include <memory>
#include <vector>

namespace lamap
{
/** Adds ȳ and k̄ − ȳ of one scan (thesis eq. 4.5, 4.6) to the cells of a grid; keeps its working memory
 * between scans.
 *
 * "All within the support" is the rule: faces, edges and corners of blocks are invisible. Each block sums
 * what reaches it, whole numbers all along, so that neither order nor threads can change a bit. */
class BgkScanInference
{
 public:
  BgkScanInference();
  ~BgkScanInference();

  /** @param scan its rays are counted in the result
   *  @param inference resolved and valid
   *  @param layer of a planar map
   *  @param threads ≥ 1
   *  @throws std::overflow_error if a count would pass 2^63; std::length_error, with nothing changed, if the
   * scan's rays are too long for cells of this size */
  RayCounts addScan(const Scan& scan, const BgkInference& inference, const BgkStructure& structure,
                    int32_t layer, unsigned threads, const RuleForBlock& ruleFor, BlockGrid& grid);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// Adds counts to the cells of a map block; shared by all that adds evidence.
class BlockAdder
{
 public:
  explicit BlockAdder(const BlockShape& shape);

  /// Starts a new block: nothing to add.
  void clear();
  void set(uint32_t offset, const Evidence& evidence)
  {
    added_[offset] = evidence;
    touched_[offset >> 6] |= uint64_t{1} << (offset & 63);
  }
  [[nodiscard]] bool any() const;
  /// @throws std::overflow_error if a count would pass 2^63; the block is unchanged then.
  void addTo(EvidenceBlock& block, const OctantRule& rule);

 private:
  void addToDense();

  BlockShape shape_;
  DenseBlock dense_;
  std::vector<Evidence> added_;
  std::vector<uint64_t> touched_;
};

}  // namespace lamap
