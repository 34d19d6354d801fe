#pragma once

#include <lamap_core/grid/block_grid.h>
#include <lamap_core/grid/octant_rule.h>
#include <lamap_core/grid/scan_blocks.h>
#include <lamap_core/math/workers.h>
#include <lamap_core/overlapping/model.h>

#include <array>
#include <cstdint>
#include <vector>

namespace lamap
{
/** Adds what a model says to the cells of a grid (Algorithm 1, lines 3 to 9); keeps its working memory.
 *
 * The model's kernels are turned into the grid's axes, where each is a product of three factors along the
 * axes whatever the model's own axes are. Tiles of 8³ cells sum what reaches them in the order of the
 * kernels, so neither blocks nor threads can change a bit. */
class ModelFusion
{
 public:
  /// @param layer of the cells of a planar map
  ModelFusion(const ModelShape& shape, int32_t layer) : shape_(shape), layer_(layer) {}

  /** Chooses the model that blocks() and addTo() speak of; it must outlive them.
   * @throws std::length_error if the model's box has too many cells */
  void choose(const HilbertModel& model, const ModelPose& pose, const BlockShape& blockShape,
              const Workers& workers);

  /// Blocks of the map in which the model may have evidence, sorted.
  [[nodiscard]] const std::vector<BlockIndex>& blocks() const { return mapBlocks_; }

  /** Adds the model's evidence to the grid.
   * @param wanted sorted blocks; others are left alone. Null: all.
   * @throws std::overflow_error if a sum would pass its limit */
  void addTo(BlockGrid& grid, const RuleForBlock& ruleFor, const std::vector<BlockIndex>* wanted,
             const Workers& workers);

 private:
  /// A kernel in the grid's axes.
  struct Source
  {
    Eigen::Vector3d centre_cells;  ///< from the anchor's lowest corner
    float weight;
    BlockIndex firstTile;  ///< of those that it reaches
    BlockIndex lastTile;
    std::array<size_t, 3> factors;  ///< where factors_ of its tiles' cells along each axis begin
  };
  /// Tiles that lie in one block of the map, or hold several.
  struct Group
  {
    BlockIndex place;
    uint32_t begin;
    uint32_t end;
  };
  class Tile;
  struct Worker;

  void findWindow();
  void listSources();
  void findFactors(Source& source);
  void listTiles();
  void listGroups(const BlockShape& blockShape);
  [[nodiscard]] CellIndex firstCellOf(const BlockIndex& tile) const;
  void addGroup(const Group& group, Worker& worker, BlockGrid& grid, const RuleForBlock& ruleFor,
                const std::vector<BlockIndex>* wanted) const;

  ModelShape shape_;
  int32_t layer_;
  const HilbertModel* model_ = nullptr;
  ModelPose pose_;
  BlockIndex low_;  ///< first and last tile that the model's box may touch
  BlockIndex high_;
  std::vector<Source> sources_;
  std::vector<float> factors_;
  ScanBlocks tiles_;
  std::vector<uint32_t> sourceEnds_;  ///< of each tile's part of tileSources_
  std::vector<uint32_t> tileSources_;
  std::vector<uint32_t> order_;  ///< of the tiles, by groups
  std::vector<Group> groups_;
  std::vector<BlockIndex> mapBlocks_;
};

}  // namespace lamap
