#pragma once

#include <lamap_core/options/option_table.h>

#include <string>

// Options that several maps have, each group in the order in which files hold it.
// @tparam Self the struct of options, which has members of these names
namespace lamap
{
/// Lengths beyond this are a mistake in the unit [m].
inline constexpr double kMetresMost = 1e6;
inline constexpr double kWholeMost = 4294967295.0;

/// resolution
template <typename Self>
OptionTableOf<Self>& addResolutionOption(OptionTableOf<Self>& table)
{
  return table.add("resolution", &Self::resolution, metres().from(1e-4).to(1e4), "edge of a finest cell");
}

/// blockDepth, pruning, of maps that hold their cells in blocks
template <typename Self>
OptionTableOf<Self>& addBlockOptions(OptionTableOf<Self>& table)
{
  return table
      .add("blockDepth", &Self::blockDepth, plain().from(2).to(6), "a block is 2^(blockDepth-1) cells wide")
      .add("pruning", &Self::pruning, oneOf({"none", "lossless", "state"}),
           "when the cells of an octant are stored once; state discards how their evidence differed, so that "
           "results depend slightly on the order of scans");
}

/// planar, planarHeight
template <typename Self>
OptionTableOf<Self>& addPlanarOptions(OptionTableOf<Self>& table)
{
  constexpr double kCellsMost = 1e9;  // that indices can address, with room for neighbours
  constexpr double kHeightMost_m = kCellsMost * 1e4;
  return table
      .add("planar", &Self::planar, plain(), "one layer of cells, distances in the plane: for 2D sensors")
      .add("planarHeight", &Self::planarHeight,
           metres().from(-kHeightMost_m).to(kHeightMost_m).atLeastCells(-kCellsMost).atMostCells(kCellsMost),
           "height within the layer of a planar map")
      .onlyWhere({"planarHeight"}, {{"planar", {"true"}}});
}

/// freeResolution, freeMargin. @param usualCells, usualMargin_cells what they are while they are left empty
template <typename Self>
OptionTableOf<Self>& addFreeSampleOptions(OptionTableOf<Self>& table, double usualCells,
                                          double usualMargin_cells)
{
  // A point every thousandth of a cell is a mistake in the unit, and would not end.
  return table
      .add("freeResolution", &Self::freeResolution,
           metres().above(0).to(kMetresMost).atLeastCells(1e-3).usuallyCells(usualCells),
           "distance between free points on a ray")
      .add("freeMargin", &Self::freeMargin, metres().from(0).to(kMetresMost).usuallyCells(usualMargin_cells),
           "no free point is closer than this to its ray's hit");
}

/// freeDownsampling, trainingPoints, hitDownsampling
template <typename Self>
OptionTableOf<Self>& addTrainingPointOptions(OptionTableOf<Self>& table)
{
  // Smaller voxels hold one point each, which 0 says too, and their indices would overflow.
  const OptionTraits voxelEdge = metres().from(0).to(kMetresMost).atLeastCells(0.01).orZero();
  return table
      .add("freeDownsampling", &Self::freeDownsampling, voxelEdge,
           "edge of the voxels in which free points are averaged (centroids); 0: not averaged")
      .add("trainingPoints", &Self::trainingPoints, oneOf({"cells", "centroids"}),
           "hit and free cells of a scan once each, or the mean points of voxels")
      .add("hitDownsampling", &Self::hitDownsampling, OptionTraits(voxelEdge).usuallyCells(1),
           "edge of the voxels in which hits are averaged (centroids); 0: not averaged")
      .onlyWhere({"freeDownsampling", "hitDownsampling"}, {{"trainingPoints", {"centroids"}}});
}

/// beamWidth, echoWeight, noEchoWeight, usePoseCovariance
template <typename Self>
OptionTableOf<Self>& addWidthOptions(OptionTableOf<Self>& table)
{
  return table
      .add("beamWidth", &Self::beamWidth, oneOf({"none", "observation", "spacing"}),
           "what is taken into account of how wide beams are: nothing; the cones and the errors of ranges "
           "that the observation states; or that and the distance to the neighbouring beams")
      .add("echoWeight", &Self::echoWeight, plain().above(0).to(1e3),
           "most that the echo of a beam wider than a cell weighs, in hits; its cap's cells share it")
      .add("noEchoWeight", &Self::noEchoWeight, plain().from(0).to(1),
           "weight of the free space of beams wider than a cell that have no return, as a share of "
           "freeWeight; 0: it says nothing")
      .add("usePoseCovariance", &Self::usePoseCovariance, plain(),
           "points are as uncertain as the pose that their observation comes with")
      .onlyWhere({"echoWeight", "noEchoWeight"}, {{"beamWidth", {"observation", "spacing"}}});
}

/// freeThreshold, occupiedThreshold, of a StateThresholds member `thresholds`
template <typename Self>
OptionTableOf<Self>& addThresholdOptions(OptionTableOf<Self>& table)
{
  return table
      .add(
          "freeThreshold", [](Self& self) -> double& { return self.thresholds.free; }, plain().from(0).to(1),
          "a cell is free below this P(occupied)")
      .add(
          "occupiedThreshold", [](Self& self) -> double& { return self.thresholds.occupied; },
          plain().from(0).to(1).notBelow("freeThreshold"), "a cell is occupied above this P(occupied)");
}

/// varianceThreshold, for maps that give a variance. @param most largest variance that makes sense
template <typename Self>
OptionTableOf<Self>& addVarianceThresholdOption(OptionTableOf<Self>& table, double most)
{
  return table.add(
      "varianceThreshold", [](Self& self) -> double& { return self.thresholds.variance; },
      plain().from(0).to(most), "cells whose variance is not below this are unknown; 0: off");
}

}  // namespace lamap
