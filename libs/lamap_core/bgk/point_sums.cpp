#include <lamap_core/bgk/point_sums.h>

#include <algorithm>
#include <cmath>
#include <utility>

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

/// Adds the weights of cells by their centre. @param place of a cell's centre: level of the width, and the
/// squared distance
template <typename Place>
bool addBox(const WeightedKernels& weights, const CellBox& box, const BlockPlace& block, const Place& placeOf,
            BlockSums& sums)
{
  bool any = false;
  for (int z = box.first[2]; z <= box.last[2]; ++z)
  {
    for (int y = box.first[1]; y <= box.last[1]; ++y)
    {
      for (int x = box.first[0]; x <= box.last[0]; ++x)
      {
        const auto [level, squared] =
            placeOf(Eigen::Vector3d(block.firstCell + Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5)));
        const double support = weights.kernels.supportOf(level);
        if (!(squared < support * support)) continue;
        sums[static_cast<size_t>((z * kEdge + y) * kEdge + x)] +=
            weights.scale.quantized(weights.factor * weights.kernels.at(level, squared));
        any = true;
      }
    }
  }
  return any;
}

}  // namespace

bool addPoint(const WeightedKernels& weights, const PlacedPoint& point, const BlockPlace& block,
              BlockSums& sums)
{
  const size_t level = weights.kernels.levelOf(point.width * point.width);
  const Eigen::Vector3d support = Eigen::Vector3d::Constant(weights.kernels.supportOf(level));
  return addBox(
      {weights.kernels, weights.factor * point.weight, weights.scale},
      cellsBetween(point.place - support, point.place + support, block), block,
      [&](const Eigen::Vector3d& centre)
      { return std::make_pair(level, (centre - point.place).squaredNorm()); },
      sums);
}

double supportOf(const KernelsByWidth& kernels, const FreeSegment& segment)
{
  // Variances are convex along a ray: the widest point stands at an end.
  const double widest =
      std::max(segment.width.constant, segment.width.variance((segment.end - segment.begin).norm()));
  return kernels.supportOf(kernels.levelOf(widest));
}

bool addSegment(const WeightedKernels& weights, const FreeSegment& segment, const BlockPlace& block,
                BlockSums& sums)
{
  const Eigen::Vector3d ray = segment.end - segment.begin;
  const double squaredLength = ray.squaredNorm();
  const double length = std::sqrt(squaredLength);
  const bool hasWidth = segment.width.any();
  const auto placeOf = [&](const Eigen::Vector3d& centre)
  {
    const double along =
        squaredLength > 0 ? (centre - segment.begin).dot(ray) / squaredLength : 0.0;  // Eq. (4.31)
    const double clamped = std::clamp(along, 0.0, 1.0);
    const size_t level = hasWidth ? weights.kernels.levelOf(segment.width.variance(clamped * length)) : 0;
    return std::make_pair(level, (centre - (segment.begin + clamped * ray)).squaredNorm());  // Eq. (4.30)
  };

  // Slab by slab across the ray's longest axis, only the cells around the part of the ray that can reach the
  // slab.
  Eigen::Index major = 0;
  ray.cwiseAbs().maxCoeff(&major);
  const auto m = static_cast<size_t>(major);
  const double support = supportOf(weights.kernels, segment);
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
    any |=
        addBox({weights.kernels, weights.factor * segment.weight, weights.scale}, box, block, placeOf, sums);
  }
  return any;
}

}  // namespace lamap
