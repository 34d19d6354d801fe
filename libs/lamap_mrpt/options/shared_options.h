#pragma once

#include <lamap_mrpt/options/option_table.h>

#include <limits>
#include <string>

// Options that several maps have, in the order in which their files hold them.
namespace lamap
{
/// Lengths beyond this are a mistake in the unit [m].
inline constexpr double kMetresMost = 1e6;

/// resolution. @tparam Self a group with this member
template <typename Self>
OptionTable& addResolutionOption(OptionTable& table)
{
  return table.add<Self>("resolution", &Self::resolution, {"m", {1e-4, 1e4}}, "edge of a finest cell");
}

/// blockDepth, pruning, of maps that hold their cells in blocks. @tparam Self a group with these members
template <typename Self>
OptionTable& addBlockOptions(OptionTable& table)
{
  return table
      .add<Self>("blockDepth", &Self::blockDepth, {"", {2, 6}}, "a block is 2^(blockDepth-1) cells wide")
      .template add<Self>("pruning", &Self::pruning,
                          OptionTable::Traits::oneOf({"none", "lossless", "state"}),
                          "when the cells of an octant are held once");
}

/// planar, planarHeight. @tparam Self a group with these members
template <typename Self>
OptionTable& addPlanarOptions(OptionTable& table)
{
  return table
      .add<Self>("planar", &Self::planar, {}, "one layer of cells, distances in the plane: for 2D sensors")
      .template add<Self>("planarHeight", &Self::planarHeight, {"m", {-1e13, 1e13}},
                          "height in the layer of a planar map")
      .onlyWhere({"planarHeight"}, {{"planar", {"true"}}});
}

/** freeResolution, freeMargin. @tparam Self a group with these members, both std::optional
 * @param usualResolution what freeResolution is while it is left empty, e.g. "1 cell" */
template <typename Self>
OptionTable& addFreeSampleOptions(OptionTable& table, const std::string& usualResolution)
{
  return table
      .add<Self>("freeResolution", &Self::freeResolution, {"m", {0, kMetresMost, false}, usualResolution},
                 "distance between free points on a ray")
      .template add<Self>("freeMargin", &Self::freeMargin, {"m", {0, kMetresMost}, "1 cell"},
                          "no free point is nearer to its ray's hit");
}

/// freeDownsampling, trainingPoints, hitDownsampling. @tparam Self a group with these members
template <typename Self>
OptionTable& addTrainingPointOptions(OptionTable& table)
{
  const LegalRange fromZero{0, kMetresMost};
  return table
      .add<Self>("freeDownsampling", &Self::freeDownsampling, {"m", fromZero},
                 "edge of the voxels in which free points are averaged (centroids); 0: they are not")
      .template add<Self>("trainingPoints", &Self::trainingPoints,
                          OptionTable::Traits::oneOf({"cells", "centroids"}),
                          "hit and free cells of a scan once each, or the mean points of voxels")
      .template add<Self>("hitDownsampling", &Self::hitDownsampling, {"m", fromZero, "1 cell"},
                          "edge of the voxels in which hits are averaged (centroids); 0: they are not")
      .onlyWhere({"freeDownsampling", "hitDownsampling"}, {{"trainingPoints", {"centroids"}}});
}

/// minRange, maxRange, considerInvalidRangesAsFreeSpace, rayDecimation. @tparam Self a group with these
/// members
template <typename Self>
OptionTable& addRangeOptions(OptionTable& table)
{
  const LegalRange fromZero{0, kMetresMost};
  return table.add<Self>("minRange", &Self::minRange, {"m", fromZero}, "nearer returns are left out")
      .template add<Self>("maxRange", &Self::maxRange, {"m", fromZero},
                          "free space and hits end here; 0: what the observation states")
      .template add<Self>("considerInvalidRangesAsFreeSpace", &Self::considerInvalidRangesAsFreeSpace, {},
                          "rays without a return are free up to the maximum range")
      .template add<Self>("rayDecimation", &Self::rayDecimation, {"", {1, 4294967295.0}},
                          "only every so many-th ray is used");
}

/// freeThreshold, occupiedThreshold. @tparam Self a group with a StateThresholds member `thresholds`
template <typename Self>
OptionTable& addThresholdOptions(OptionTable& table)
{
  const LegalRange fraction{0, 1};
  return table
      .add<Self>(
          "freeThreshold", [](Self& self) -> double& { return self.thresholds.free; }, {"", fraction},
          "a cell is free below this P(occupied)")
      .template add<Self>(
          "occupiedThreshold", [](Self& self) -> double& { return self.thresholds.occupied; }, {"", fraction},
          "a cell is occupied above this P(occupied)");
}

/// varianceThreshold, for maps that give a variance. @tparam Self as for addThresholdOptions()
template <typename Self>
OptionTable& addVarianceThresholdOption(OptionTable& table)
{
  return table.add<Self>(
      "varianceThreshold", [](Self& self) -> double& { return self.thresholds.variance; }, {"", {0, 1}},
      "cells whose variance is not below are unknown; 0: not looked at");
}

}  // namespace lamap
