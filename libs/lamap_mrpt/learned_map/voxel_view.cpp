// Learned maps as COctoMapVoxels, which every MRPT viewer can draw without this library.
#include <lamap_core/grid/evidence.h>
#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <lamap_mrpt/learned_map/cell_hash.h>
#include <lamap_mrpt/learned_map/occupied_cells.h>
#include <lamap_mrpt/learned_map/scene_anchor.h>
#include <mrpt/img/color_maps.h>
#include <mrpt/opengl/CSetOfObjects.h>
#include <tsl/robin_map.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace lamap
{
namespace
{
using mrpt::opengl::COctoMapVoxels;

using CellEstimates = tsl::robin_map<CellIndex, CellEstimate, CellIndexHash>;

/// A cell with no visible side: all of its neighbours along the axes are in `cells`.
bool isBuried(const CellIndex& cell, const CellEstimates& cells)
{
  const auto has = [&](int dx, int dy, int dz) {
    return cells.count(CellIndex{cell.x + dx, cell.y + dy, cell.z + dz}) != 0;
  };
  return has(1, 0, 0) && has(-1, 0, 0) && has(0, 1, 0) && has(0, -1, 0) && has(0, 0, 1) && has(0, 0, -1);
}

/// Maps the range of the offered numbers to 0 to 1; gives 0.5 if all were equal.
class Scale
{
 public:
  void offer(double number)
  {
    low_ = std::min(low_, number);
    high_ = std::max(high_, number);
  }
  [[nodiscard]] float operator()(double number) const
  {
    return high_ > low_ ? static_cast<float>((number - low_) / (high_ - low_)) : 0.5f;
  }

 private:
  double low_ = std::numeric_limits<double>::max();
  double high_ = std::numeric_limits<double>::lowest();
};

/// The lowest corner of a cell [m].
Eigen::Vector3d cornerOf(const CellIndex& cell, double resolution_m)
{
  return resolution_m * Eigen::Vector3d(cell.x, cell.y, cell.z);
}

double coloured(CLearnedMap::ColourBy by, const CellIndex& cell, const CellEstimate& estimate)
{
  if (by == CLearnedMap::ColourBy::Probability) return estimate.prob;
  if (by == CLearnedMap::ColourBy::Variance) return estimate.variance.value_or(0.0);
  return cell.z;
}

class VoxelView
{
 public:
  /// @param anchor_map  what the cubes' coordinates are relative to
  VoxelView(const CLearnedMap& map, const Eigen::Vector3d& anchor_map, COctoMapVoxels& voxels)
      : map_(map), anchor_map_(anchor_map), voxels_(voxels)
  {
    const auto& options = map.renderingOptions;
    map.visitCells(
        [&](const CellIndex& cell, const CellEstimate& estimate)
        {
          if (estimate.state == CellState::Occupied && options.generateOccupiedVoxels)
            occupied_.emplace(cell, estimate);
          else if (estimate.state == CellState::Free && options.generateFreeVoxels)
            free_.emplace(cell, estimate);
        });
    // Heights are scaled over the occupied cells, the other two over all cells drawn.
    for (const auto& [cell, estimate] : occupied_) scale_.offer(coloured(options.colourBy, cell, estimate));
    if (options.colourBy == CLearnedMap::ColourBy::Height && !occupied_.empty()) return;
    for (const auto& [cell, estimate] : free_) scale_.offer(coloured(options.colourBy, cell, estimate));
  }

  void fill()
  {
    const auto& options = map_.renderingOptions;
    voxels_.clear();
    voxels_.resizeVoxelSets(2);
    voxels_.showVoxels(mrpt::opengl::VOXEL_SET_OCCUPIED, options.visibleOccupiedVoxels);
    voxels_.showVoxels(mrpt::opengl::VOXEL_SET_FREESPACE, options.visibleFreeVoxels);
    voxels_.setVisualizationMode(COctoMapVoxels::FIXED);  // each cube has its own colour
    voxels_.enableLights(true);
    voxels_.reserveVoxels(mrpt::opengl::VOXEL_SET_OCCUPIED, occupied_.size());
    for (const auto& [cell, estimate] : occupied_)
      if (!options.hideBuriedVoxels || !isBuried(cell, occupied_))
        add(mrpt::opengl::VOXEL_SET_OCCUPIED, cell, estimate, 1.0);
    voxels_.reserveVoxels(mrpt::opengl::VOXEL_SET_FREESPACE, free_.size());
    for (const auto& [cell, estimate] : free_)
      add(mrpt::opengl::VOXEL_SET_FREESPACE, cell, estimate, options.freeOpacity);
    voxels_.sort_voxels_by_z();
  }

 private:
  void add(mrpt::opengl::predefined_voxel_sets_t set, const CellIndex& cell, const CellEstimate& estimate,
           double opacity)
  {
    const Eigen::Vector3d halfCell = Eigen::Vector3d::Constant(0.5 * map_.resolution());
    const Eigen::Vector3f centre = (cornerOf(cell, map_.resolution()) + halfCell - anchor_map_).cast<float>();
    const float place = scale_(coloured(map_.renderingOptions.colourBy, cell, estimate));
    // Without the dark ends of the colour map, which lighting would turn black.
    constexpr float kBlue = 0.125f;
    constexpr float kRed = 0.875f;
    mrpt::img::TColor colour =
        mrpt::img::colormap(mrpt::img::cmJET, kBlue + (kRed - kBlue) * std::clamp(place, 0.0f, 1.0f));
    colour.A = static_cast<uint8_t>(255 * opacity);
    voxels_.push_back_Voxel(set, {{centre.x(), centre.y(), centre.z()}, map_.resolution(), colour});
  }

  const CLearnedMap& map_;
  Eigen::Vector3d anchor_map_;
  COctoMapVoxels& voxels_;
  CellEstimates occupied_;
  CellEstimates free_;
  Scale scale_;
};

/** The origin, unless floats do not tell the cells of the box apart from there: then a place near its lowest
 * corner. */
Eigen::Vector3d anchorOf(const ObservedBox& box, double resolution_m)
{
  if (!box.any) return Eigen::Vector3d::Zero();
  double farthest = 0;  // in cells
  for (const CellIndex& cell : {box.low, box.high})
    for (const int index : {cell.x, cell.y, cell.z}) farthest = std::max(farthest, std::abs(index + 0.5));
  constexpr double kMaxError = 0.05;  // of a cell
  const bool isFar = farthest * static_cast<double>(std::numeric_limits<float>::epsilon()) / 2 > kMaxError;
  if (!isFar) return Eigen::Vector3d::Zero();
  return sceneAnchorNear(cornerOf(box.low, resolution_m));
}
}  // namespace

void CLearnedMap::getAsOctoMapVoxels(COctoMapVoxels& voxels) const
{
  renderingOptions.validate();
  const auto observed = observedBox();
  const Eigen::Vector3d anchor_map = anchorOf(*observed, resolution());
  VoxelView(*this, anchor_map, voxels).fill();
  auto box = boundingBox();
  if (!anchor_map.isZero(0))
  {
    const Eigen::Vector3d edges = Eigen::Vector3d::Constant(resolution());
    const Eigen::Vector3f low = (cornerOf(observed->low, resolution()) - anchor_map).cast<float>();
    const Eigen::Vector3f high = (cornerOf(observed->high, resolution()) + edges - anchor_map).cast<float>();
    box = {{low.x(), low.y(), low.z()}, {high.x(), high.y(), high.z()}};
    voxels.setLocation(anchor_map.x(), anchor_map.y(), anchor_map.z());
  }
  voxels.setBoundingBox(mrpt::math::TPoint3D(box.min), mrpt::math::TPoint3D(box.max));
  voxels.showGridLines(renderingOptions.generateGridLines);
  if (renderingOptions.generateGridLines) voxels.push_back_GridCube({box.min, box.max});
}

void CLearnedMap::getVisualizationInto(mrpt::opengl::CSetOfObjects& scene) const
{
  if (!genericMapParams.enableSaveAs3DObject) return;
  const auto voxels = COctoMapVoxels::Create();
  getAsOctoMapVoxels(*voxels);
  scene.insert(voxels);
}

}  // namespace lamap
