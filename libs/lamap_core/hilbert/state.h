#pragma once

#include <lamap_core/features/lattice.h>
#include <lamap_core/grid/cell.h>

#include <Eigen/Core>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace lamap
{
/// All that a HilbertMap has learned, in vectors that are sorted where they have an order: for files.
struct HilbertState
{
  struct Block
  {
    BlockIndex index;
    SiteSet::Bits bits{};                ///< which sites of the block there are
    std::vector<SitePosterior> weights;  ///< of those sites, in the order of bits
  };
  /// Weights of the hits and of the free points at a cell's centre.
  struct CellPoints
  {
    CellIndex cell;
    float hits = 0;
    float frees = 0;
  };
  /// A training point that stands by itself, [m] in the map.
  struct Point
  {
    Eigen::Vector3d place = Eigen::Vector3d::Zero();
    float label = 0;
    float weight = 1;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    double variance = 0;  ///< [m²] of its errors, see HilbertTrainingSet
  };

  /// Cells that rays saw, in a block of 8³, see SeenCells.
  struct SeenBlock
  {
    BlockIndex index;
    SiteSet::Bits bits{};
    std::vector<uint8_t> hits;    ///< of those cells, in the order of bits, in eighths of a scan
    std::vector<uint8_t> passes;  ///< likewise; one of both is > 0
  };

  /// How uncertain the training points in sites were, in a block of 8³, see PointWidths.
  struct WidthBlock
  {
    BlockIndex index;
    SiteSet::Bits bits{};
    std::vector<float> weights;    ///< of those sites, in the order of bits
    std::vector<float> variances;  ///< likewise, weighted [m²]
  };

  std::vector<Block> blocks;              ///< by z, y, x; weights are 0 where features are Nyström's
  uint64_t sgdSteps = 0;                  ///< done so far
  std::vector<Eigen::Vector3d> inducing;  ///< of Nyström's features [m]
  std::vector<float> classifier;          ///< their weights, then the bias
  std::vector<SeenBlock> seen;            ///< by z, y, x
  std::vector<WidthBlock> widths;         ///< by z, y, x
  std::vector<CellPoints> cells;          ///< `Batch`: by z, y, x
  std::vector<Point> points;              ///< `Batch`: in the order they came

  /// @throws std::invalid_argument saying what is wrong with a state, unless the condition holds.
  static void require(bool legal, const char* what)
  {
    if (!legal) throw std::invalid_argument(std::string("state of a Hilbert map: ") + what);
  }
};

}  // namespace lamap
