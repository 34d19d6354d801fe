#pragma once

#include <lamap_core/bgk/expected_kernel.h>
#include <lamap_core/math/workers.h>
#include <lamap_core/training/training_set.h>

#include <array>
#include <cstdint>
#include <vector>

namespace lamap
{
/** Sums the expected kernels of a scan's wide cells at cell centres; keeps its working memory from scan to
 * scan.
 *
 * Gaussians are separable: three passes along the axes over the blocks of a scan cost less than wide stencils
 * for each point. Each sum is taken over cells in their order along the axis, so that neither threads nor the
 * place on the map change a bit. */
class WideCells
{
 public:
  /// A sum for each cell of a scan block: index (z·8 + y)·8 + x.
  using Sums = std::array<float, kScanBlockCells>;

  /** @param kernels of kWidthLevels[1] and so on
   *  @param mask and any of WideMasks: the cells that count
   *  @param planar whether weights are limited to the layer
   *  @return false, before anything is summed, if the cells reach more than kMaxBlocks */
  [[nodiscard]] bool compute(const TrainingSet& training, const std::vector<ExpectedKernel>& kernels,
                             CellMask WideMasks::*mask, bool WideMasks::*any, bool planar,
                             const Workers& workers);

  /// Sums of more blocks would take gigabytes: such a scan is in the wrong unit, or has no maximum range.
  static constexpr size_t kMaxBlocks = size_t{1} << 17;

  /// Blocks that the cells reach.
  [[nodiscard]] const std::vector<BlockIndex>& blocks() const { return total_.blocks.blocks(); }
  /// @return nullptr for a block that none reaches
  [[nodiscard]] const Sums* at(const BlockIndex& block) const { return total_.find(block); }

 private:
  struct Field
  {
    ScanBlocks blocks;
    std::vector<Sums> sums;  ///< by block number

    [[nodiscard]] const Sums* find(const BlockIndex& block) const
    {
      const int32_t number = blocks.find(block);
      return number < 0 ? nullptr : &sums[static_cast<size_t>(number)];
    }
  };

  /** Finds the blocks that the cells of a level reach along X, along X and Y, and in total, where those of
   * other levels stay. @return whether there is room for them */
  [[nodiscard]] bool findBlocks(const TrainingSet& training, const std::vector<WideMasks>& level,
                                CellMask WideMasks::*mask, const ExpectedKernel& kernel, bool planar);
  void sumAlongX(const TrainingSet& training, const std::vector<WideMasks>& level, CellMask WideMasks::*mask,
                 const ExpectedKernel::Term& term, const Workers& workers);
  void sumAlongY(const ExpectedKernel::Term& term, const Workers& workers);
  void addAlongZ(const ExpectedKernel::Term& term, const Workers& workers);
  void addLayers(double factor);

  BlockIndex low_;
  BlockIndex high_;
  Field alongX_;
  Field alongXy_;
  Field total_;
};

}  // namespace lamap
