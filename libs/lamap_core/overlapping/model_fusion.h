#pragma once

#include <lamap_core/grid/block_lists.h>
#include <lamap_core/grid/evidence.h>
#include <lamap_core/grid/scan_blocks.h>
#include <lamap_core/math/workers.h>
#include <lamap_core/overlapping/model.h>

#include <array>
#include <cstdint>
#include <vector>

namespace lamap
{
/** What a model says of the cells of a map (Algorithm 1, lines 3 to 9); keeps its working memory.
 *
 * The model's kernels are turned into the map's axes, where each is a product of three factors along the
 * axes whatever the model's own axes are. Tiles of 8³ cells sum what reaches them in the order of the
 * kernels, so neither blocks nor threads can change a bit. */
class ModelFusion
{
 public:
  /// Of a kernel and a tile that it reaches: their list takes 2 GiB then.
  static constexpr double kMostPairs = 0x1p29;

  /// @param layer of the cells of a planar map
  ModelFusion(const ModelShape& shape, int32_t layer) : certain_(shape), shape_(shape), layer_(layer) {}

  /** Chooses the model that blocks() and infer() speak of; it must outlive them.
   * @throws std::length_error if the model's box has too many cells, or its kernels reach too many */
  void choose(const HilbertModel& model, const ModelPose& pose, const BlockShape& blockShape,
              const Workers& workers);

  /// Blocks of the map in which the model may have evidence, sorted.
  [[nodiscard]] const std::vector<BlockIndex>& blocks() const { return mapBlocks_; }

  /// The model's evidence. @param wanted sorted blocks, to leave out all others; null: all are wanted
  [[nodiscard]] Evidence infer(const std::vector<BlockIndex>* wanted, const Workers& workers);

  /// After infer() of all blocks: for the first hit of the model in each cell, log-odds of the cell by the
  /// weights alone; infinite for the others.
  [[nodiscard]] const std::vector<float>& hitLogodds() const { return hitLogodds_; }

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
  /// A hit of the model.
  struct Hit
  {
    uint32_t tile;
    uint32_t cell;    ///< in the tile
    uint32_t number;  ///< among the model's hits
  };
  class Tile;
  struct Worker;

  void findWindow();
  void requireFewTiles() const;
  void listSources();
  void findFactors(Source& source);
  void listTiles();
  void listHits();
  void listGroups();
  [[nodiscard]] CellIndex firstCellOf(const BlockIndex& tile) const;
  void inferGroup(const BlockGroups::Group& group, Worker& worker, const std::vector<BlockIndex>* wanted);

  ModelShape certain_;  ///< of the map
  ModelShape shape_;    ///< as the model is asked
  int32_t layer_;
  BlockShape blockShape_{1, false};  ///< of the map
  const HilbertModel* model_ = nullptr;
  ModelPose pose_;
  BlockIndex low_;  ///< first and last tile that the model's box may touch
  BlockIndex high_;
  std::vector<Source> sources_;
  std::vector<float> factors_;
  ScanBlocks tiles_;
  std::vector<uint32_t> sourceEnds_;  ///< of each tile's part of tileSources_
  std::vector<uint32_t> tileSources_;
  std::vector<Hit> hits_;  ///< by tile, then by cell
  std::vector<float> hitLogodds_;
  BlockGroups groups_;  ///< of tiles
  std::vector<BlockIndex> mapBlocks_;
};

}  // namespace lamap
