#include <lamap_core/bgk/point_sums.h>

#include <algorithm>
#include <cmath>

namespace lamap
{
namespace
{
constexpr int kEdge = kScanBlockEdge;

/// Cells of a block, by their number along each axis; empty if any first > last.
struct CellBox
{
  std::array<int, 3> first{};
  std::array<int, 3> last{};
};

/// Cells of the block whose centres lie in [low, high].
CellBox cellsBetween(const Eigen::Vector3d& low, const Eigen::Vector3d& high, const BlockPlace& block)
{
  CellBox box;
  for (int axis = 0; axis < 3; ++axis)
  {
    const auto a = static_cast<size_t>(axis);
    const double from = std::ceil(low[axis] - block.firstCell[axis] - 0.5);
    const double to = std::floor(high[axis] - block.firstCell[axis] - 0.5);
    box.first[a] = static_cast<int>(std::clamp(from, 0.0, static_cast<double>(kEdge)));
    box.last[a] = static_cast<int>(std::clamp(to, -1.0, static_cast<double>(kEdge - 1)));
  }
  if (block.planar)
  {
    box.first[2] = block.layer;
    box.last[2] = block.layer;
  }
  return box;
}

/// Adds the weights of the squared distances to the cells' centres.
template <typename SquaredDistance>
bool addBox(const WeightedKernel& weights, const CellBox& box, const BlockPlace& block,
            const SquaredDistance& squaredDistance, BlockSums& sums)
{
  const double squaredSupport = weights.kernel.support() * weights.kernel.support();
  bool any = false;
  for (int z = box.first[2]; z <= box.last[2]; ++z)
  {
    for (int y = box.first[1]; y <= box.last[1]; ++y)
    {
      for (int x = box.first[0]; x <= box.last[0]; ++x)
      {
        const Eigen::Vector3d centre = block.firstCell + Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5);
        const double squared = squaredDistance(centre);
        if (!(squared < squaredSupport)) continue;
        sums[static_cast<size_t>((z * kEdge + y) * kEdge + x)] +=
            weights.scale.quantized(weights.factor * weights.kernel.atSquaredDistance(squared));
        any = true;
      }
    }
  }
  return any;
}

}  // namespace

bool addPoint(const WeightedKernel& weights, const Eigen::Vector3d& point, const BlockPlace& block,
              BlockSums& sums)
{
  const Eigen::Vector3d support = Eigen::Vector3d::Constant(weights.kernel.support());
  return addBox(
      weights, cellsBetween(point - support, point + support, block), block,
      [&](const Eigen::Vector3d& centre) { return (centre - point).squaredNorm(); }, sums);
}

bool addSegment(const WeightedKernel& weights, const FreeSegment& segment, const BlockPlace& block,
                BlockSums& sums)
{
  const Eigen::Vector3d ray = segment.end - segment.begin;
  const double squaredLength = ray.squaredNorm();
  const auto squaredDistance = [&](const Eigen::Vector3d& centre)
  {
    const double along =
        squaredLength > 0 ? (centre - segment.begin).dot(ray) / squaredLength : 0.0;      // Eq. (4.31)
    return (centre - (segment.begin + std::clamp(along, 0.0, 1.0) * ray)).squaredNorm();  // Eq. (4.30)
  };

  // Slab by slab across the ray's longest axis, only the cells around the part of the ray that can reach the
  // slab.
  Eigen::Index major = 0;
  ray.cwiseAbs().maxCoeff(&major);
  const auto m = static_cast<size_t>(major);
  const double support = weights.kernel.support();
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(support);
  const CellBox whole = cellsBetween(segment.begin.cwiseMin(segment.end) - margin,
                                     segment.begin.cwiseMax(segment.end) + margin, block);
  bool any = false;
  for (int slab = whole.first[m]; slab <= whole.last[m]; ++slab)
  {
    double from = 0.0;
    double to = 1.0;
    if (squaredLength > 0)
    {
      const double centre = block.firstCell[major] + slab + 0.5;
      const double a = (centre - support - segment.begin[major]) / ray[major];
      const double b = (centre + support - segment.begin[major]) / ray[major];
      from = std::clamp(std::min(a, b), 0.0, 1.0);
      to = std::clamp(std::max(a, b), 0.0, 1.0);
    }
    const Eigen::Vector3d p = segment.begin + from * ray;
    const Eigen::Vector3d q = segment.begin + to * ray;
    // A little wider than the support, for the rounding of the two ends.
    const Eigen::Vector3d wider = margin.array() + 1e-6;
    CellBox box = cellsBetween(p.cwiseMin(q) - wider, p.cwiseMax(q) + wider, block);
    box.first[m] = slab;
    box.last[m] = slab;
    any |= addBox(weights, box, block, squaredDistance, sums);
  }
  return any;
}

}  // namespace lamap
