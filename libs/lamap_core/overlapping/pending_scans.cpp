#include <lamap_core/overlapping/model_fusion.h>
#include <lamap_core/overlapping/pending_scans.h>

#include <Eigen/Geometry>
#include <algorithm>

namespace lamap
{
namespace
{
/// What surrounds the rays of waiting scans.
struct Surroundings
{
  Eigen::AlignedBox3d inModel;
  Eigen::AlignedBox3d inMap;  ///< along the axes of the map, from the model's origin
  double length_m = 0;        ///< of all rays
  double rays = 0;
};

Surroundings surroundingsOf(const PendingScans& pending)
{
  Surroundings found;
  const auto include = [&](const Eigen::Vector3d& place)
  {
    found.inModel.extend(place);
    found.inMap.extend(pending.pose.rotation * place);
  };
  for (const ModelScan& scan : pending.scans)
    for (const RayFan& fan : scan.rays.scan.fans)
    {
      if (fan.rays.empty()) continue;
      include(fan.centre);
      for (const Ray& ray : fan.rays)
      {
        const Eigen::Vector3d along = fan.directionOf(ray);
        include(fan.centre + along);
        found.length_m += along.norm();
        ++found.rays;
      }
    }
  return found;
}

/// Blocks with these edges in a box with this margin, at most.
double blocksIn(const Eigen::AlignedBox3d& box, double margin_m, double edge_m, bool planar)
{
  const auto along = [&](int axis) { return (box.sizes()[axis] + 2 * margin_m) / edge_m + 2; };
  return along(0) * along(1) * (planar ? 1 : along(2));
}

bool isWide(const PendingScans& pending)
{
  for (const ModelScan& scan : pending.scans)
    for (const RayFan& fan : scan.rays.scan.fans)
      if (fan.beam.halfWidth_rad > 0 || fan.beam.halfHeight_rad > 0) return true;
  return false;
}
}  // namespace

bool isSurelyTrainable(const PendingScans& pending, const OverlappingStructure& structure,
                       const OverlappingInference& inference)
{
  const Surroundings around = surroundingsOf(pending);
  if (around.inModel.isEmpty()) return true;
  // Cones reach beyond their axes, and are bundles of rays.
  if (inference.beamWidth != BeamWidth::None && isWide(pending)) return false;
  const ModelShape shape(structure);
  const bool planar = shape.planar;
  const double tile_m = kScanBlockEdge * shape.resolution_m;
  const double margin_m = 3 * shape.resolution_m;
  const double reach_m = shape.support_m + 2 * shape.spacing_m + margin_m;
  constexpr auto kMostBlocks = static_cast<double>(ScanBlocks::kMaxBlocks);

  const double samples = around.length_m / inference.freeResolution + 2 * around.rays;
  constexpr double kMostSamples = 5e7;
  if (inference.trainingPoints == HilbertPoints::Points && samples > kMostSamples) return false;
  const double tiles = blocksIn(around.inMap, shape.compact() ? reach_m : margin_m, tile_m, planar);
  if (tiles > kMostBlocks || blocksIn(around.inModel, margin_m, tile_m, planar) > kMostBlocks) return false;

  double kernels = structure.components;
  if (shape.compact())
  {
    if (blocksIn(around.inModel, reach_m, kScanBlockEdge * shape.spacing_m, planar) > kMostBlocks)
      return false;
    kernels = std::min(samples, blocksIn(around.inModel, shape.spacing_m, shape.spacing_m, planar));
  }
  const double along = 2 * shape.support_m / tile_m + 2;
  const double tilesOfKernel = std::min(tiles, along * along * (planar ? 1 : along));
  return kernels * tilesOfKernel <= ModelFusion::kMostPairs;
}

}  // namespace lamap
