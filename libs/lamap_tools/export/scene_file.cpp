#include <lamap_mrpt/compat/mrpt_compat.h>
#include <lamap_mrpt/files/atomic_file.h>
#include <lamap_mrpt/files/map_file.h>
#include <lamap_mrpt/learned_map/scene_anchor.h>
#include <lamap_tools/cells/cell_table.h>
#include <lamap_tools/export/export_map.h>
#include <lamap_tools/pictures/palette.h>
#include <lamap_tools/pictures/picture_frame.h>
#include <mrpt/opengl/CGridPlaneXY.h>
#include <mrpt/opengl/COctoMapVoxels.h>
#include <mrpt/opengl/COpenGLScene.h>
#include <mrpt/opengl/stock_objects.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace lamap::tools
{
namespace
{
/// Voxels relative to a place near the first cell of the extent. They are floats, and so is the pose of their
/// object in a file: the place is one whose coordinates are floats.
mrpt::opengl::COctoMapVoxels::Ptr voxelsOf(const CellMap& map, const StateSet& states,
                                           const CellExtent& extent)
{
  const double r = map.resolution();
  const Eigen::AlignedBox3d box_m = extent.box_m(r);
  const Eigen::Vector3d anchor_map = sceneAnchorNear(box_m.min());
  const double span = std::max(1.0, static_cast<double>(extent.last.z) - extent.first.z);
  auto voxels = mrpt::opengl::COctoMapVoxels::Create();
  voxels->setVisualizationMode(mrpt::opengl::COctoMapVoxels::FIXED);
  voxels->enableLights(true);
  voxels->resizeVoxelSets(2);  // opaque ones first, so that the others blend over them
  map.visitCells(
      [&](const CellIndex& cell, const CellEstimate& estimate)
      {
        if (!states.has(estimate.state)) return;
        const double up = static_cast<double>(cell.z) - extent.first.z;
        auto color = paletteColor(Palette::Height, up / span);
        const bool occupied = estimate.state == CellState::Occupied;
        constexpr uint8_t kFaint = 20;
        if (!occupied) color.A = kFaint;
        const Eigen::Vector3d half(0.5, 0.5, 0.5);
        const Eigen::Vector3f centre =
            (r * (Eigen::Vector3d(cell.x, cell.y, cell.z) + half) - anchor_map).cast<float>();
        voxels->push_back_Voxel(occupied ? 0 : 1, {{centre.x(), centre.y(), centre.z()}, r, color});
      });
  voxels->enableCubeTransparency(voxels->getVoxelCount(1) > 0);
  const Eigen::Vector3d low = box_m.min() - anchor_map;
  const Eigen::Vector3d high = box_m.max() - anchor_map;
  voxels->setBoundingBox({low.x(), low.y(), low.z()}, {high.x(), high.y(), high.z()});
  voxels->setLocation(anchor_map.x(), anchor_map.y(), anchor_map.z());
  voxels->setName("cells");
  return voxels;
}
}  // namespace

void writeScene(const CellMap& map, const std::string& path, const StateSet& states)
{
  const auto extent = cellExtent(
      map, [&](const CellIndex&, const CellEstimate& estimate) { return states.has(estimate.state); });
  if (!extent) throw std::runtime_error(path + ": the map has no cell of the states asked for");
  const double r = map.resolution();
  const Eigen::AlignedBox3d box_m = extent->box_m(r);
  const Eigen::Vector3d& from = box_m.min();
  const Eigen::Vector3d& to = box_m.max();
  const double size_m = box_m.sizes().maxCoeff();
  const double step_m = roundStep(size_m / 20);

  mrpt::opengl::COpenGLScene scene;
  const auto down = [&](double x) { return static_cast<float>(std::floor(x / step_m) * step_m); };
  const auto up = [&](double x) { return static_cast<float>(std::ceil(x / step_m) * step_m); };
  auto ground = mrpt::opengl::CGridPlaneXY::Create(down(from.x()), up(to.x()), down(from.y()), up(to.y()),
                                                   static_cast<float>(from.z()), static_cast<float>(step_m));
  ground->setColor_u8(150, 150, 150);
  scene.insert(ground);
  auto axes = mrpt::opengl::stock_objects::CornerXYZSimple(static_cast<float>(step_m));
  axes->setLocation(down(from.x()), down(from.y()), from.z());
  scene.insert(axes);
  scene.insert(voxelsOf(map, states, *extent));

  auto& camera = scene.getViewport()->getCamera();
  const Eigen::Vector3d middle = (from + to) / 2;
  camera.setPointingAt(static_cast<float>(middle.x()), static_cast<float>(middle.y()),
                       static_cast<float>(middle.z()));
  camera.setZoomDistance(static_cast<float>(1.6 * size_m));
  camera.setAzimuthDegrees(-60);
  camera.setElevationDegrees(40);

  AtomicFile file(path);
  try
  {
    writeCompressed(scene, file.temporaryPath());
  }
  catch (const std::exception& error)
  {
    throw std::runtime_error(path + ": cannot be written: " + compat::messageOf(error));
  }
  file.commit();
}

}  // namespace lamap::tools
