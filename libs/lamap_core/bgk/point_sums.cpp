#include <lamap_core/bgk/point_sums.h>

#include <lamap_core/math/registers.h>

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

/// The smallest whole number from a number on, held to [0, kEdge]. Not std::ceil(), which is a function call.
int firstFrom(double number)
{
  const double held = std::clamp(number, -1.0, static_cast<double>(kEdge));
  const int towardsZero = static_cast<int>(held);
  return std::max(0, towardsZero + (held > towardsZero ? 1 : 0));
}

/// The largest whole number up to a number, held to [−1, kEdge − 1].
int lastUpTo(double number)
{
  const double held = std::clamp(number, -1.0, static_cast<double>(kEdge));
  const int towardsZero = static_cast<int>(held);
  return std::min(kEdge - 1, towardsZero - (held < towardsZero ? 1 : 0));
}

/// Cells of the block whose centres lie in [low, high].
CellBox cellsBetween(const Eigen::Vector3d& low, const Eigen::Vector3d& high, const BlockPlace& block)
{
  CellBox box;
  for (int axis = 0; axis < 3; ++axis)
  {
    const auto a = static_cast<size_t>(axis);
    box.first[a] = firstFrom(low[axis] - block.firstCell[axis] - 0.5);
    box.last[a] = lastUpTo(high[axis] - block.firstCell[axis] - 0.5);
  }
  if (block.planar)
  {
    box.first[2] = block.layer;
    box.last[2] = block.layer;
  }
  return box;
}

/// A ray's free part, with what distances from it need. Sums are in the order in which Eigen forms them.
struct Line
{
  explicit Line(const FreeSegment& segment)
      : begin(segment.begin), ray(segment.end - segment.begin), squaredLength(ray.squaredNorm())
  {
  }

  Eigen::Vector3d begin;
  Eigen::Vector3d ray;
  double squaredLength;
};

/** Of the centres of a row of cells, whose first is given.
 * @param along receives where on the line the nearest points are, as a share of its length: eq. (4.31)
 * @param squared receives the squared distances from these: eq. (4.30) */
template <typename Lanes>
LAMAP_INLINED void findDistances(const Line& line, const Eigen::Vector3d& centre,
                                 std::array<double, kEdge>& along, std::array<double, kEdge>& squared)
{
  using Some = Vector<double, Lanes::kDoubles>;
  using Numbers = typename Some::Numbers;
  constexpr double kSteps[kEdge] = {0, 1, 2, 3, 4, 5, 6, 7};
  const Eigen::Vector3d& begin = line.begin;
  const Eigen::Vector3d& ray = line.ray;
  const double yz = (centre.y() - begin.y()) * ray.y() + (centre.z() - begin.z()) * ray.z();
  const double divisor = line.squaredLength > 0 ? line.squaredLength : 1.0;
  const Numbers zero{};
  const Numbers one = zero + 1.0;
  for (size_t i = 0; i < kEdge; i += Lanes::kDoubles)
  {
    Numbers x;
    Some::load(kSteps + i, x);
    x = x + centre.x();
    const Numbers share = ((x - begin.x()) * ray.x() + yz) / divisor;
    const Numbers least = share < zero ? zero : share;
    const Numbers at = one < least ? one : least;
    const Numbers dx = x - (begin.x() + at * ray.x());
    const Numbers dy = centre.y() - (begin.y() + at * ray.y());
    const Numbers dz = centre.z() - (begin.z() + at * ray.z());
    Some::store(at, along.data() + i);
    Some::store(dx * dx + (dy * dy + dz * dz), squared.data() + i);
  }
}

/// The variance of a segment's widest point: variances are convex along a ray, so that it stands at an end.
double widestOf(const FreeSegment& segment)
{
  return std::max(segment.width.constant, segment.width.variance((segment.end - segment.begin).norm()));
}

}  // namespace

void PointSums::addPoint(const PlacedPoint& point)
{
  const size_t level = weights_.kernels.levelOf(point.width * point.width);
  const double support = weights_.kernels.supportOf(level);
  const double squaredSupport = support * support;
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(support);
  const CellBox box = cellsBetween(point.place - margin, point.place + margin, block_);
  const double factor = weights_.factor * point.weight;
  Row xx;
  for (size_t i = 0; i < xx.size(); ++i)
  {
    const double dx = block_.firstCell.x() + (static_cast<double>(i) + 0.5) - point.place.x();
    xx[i] = dx * dx;
  }
  for (int z = box.first[2]; z <= box.last[2]; ++z)
  {
    const double dz = block_.firstCell.z() + (z + 0.5) - point.place.z();
    for (int y = box.first[1]; y <= box.last[1]; ++y)
    {
      const double dy = block_.firstCell.y() + (y + 0.5) - point.place.y();
      const double yz = dy * dy + dz * dz;
      if (!(yz < squaredSupport)) continue;
      const auto row = static_cast<size_t>((z * kEdge + y) * kEdge);
      sharp_.reserve(kEdge);
      for (int x = box.first[0]; x <= box.last[0]; ++x)
      {
        const double squared = xx[static_cast<size_t>(x)] + yz;
        const size_t cell = row + static_cast<size_t>(x);
        if (level == 0)
          sharp_.push(squared, squared < squaredSupport, factor, cell);
        else if (squared < squaredSupport)
          addWide(level, squared, factor, cell);
      }
    }
  }
}

void PointSums::addWide(size_t level, double squared, double factor, size_t cell)
{
  sums_[cell] += weights_.scale.quantized(factor * weights_.kernels.at(level, squared));
  any_ = true;
}

double supportOf(const KernelsByWidth& kernels, const FreeSegment& segment)
{
  return kernels.supportOf(kernels.levelOf(widestOf(segment)));
}

/// Slab by slab across the ray's longest axis, calls visit(box) for the cells around the part of the ray that
/// can reach the slab.
template <typename Visit>
void PointSums::forEachBoxAlong(const FreeSegment& segment, double support, const Visit& visit) const
{
  const Eigen::Vector3d ray = segment.end - segment.begin;
  Eigen::Index major = 0;
  ray.cwiseAbs().maxCoeff(&major);
  const auto m = static_cast<size_t>(major);
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(support);
  const CellBox whole = cellsBetween(segment.begin.cwiseMin(segment.end) - margin,
                                     segment.begin.cwiseMax(segment.end) + margin, block_);
  // A row of cells along x is worked on at once.
  const int thickness = m == 0 ? kEdge : 1;
  for (int slab = whole.first[m]; slab <= whole.last[m]; slab += thickness)
  {
    const int last = std::min(slab + thickness - 1, whole.last[m]);
    double from = 0.0;
    double to = 1.0;
    if (ray[major] != 0)
    {
      const double low = block_.firstCell[major] + slab + 0.5;
      const double high = block_.firstCell[major] + last + 0.5;
      const double a =
          ((ray[major] > 0 ? low : high) - std::copysign(support, ray[major]) - segment.begin[major]) /
          ray[major];
      const double b =
          ((ray[major] > 0 ? high : low) + std::copysign(support, ray[major]) - segment.begin[major]) /
          ray[major];
      from = std::clamp(a, 0.0, 1.0);
      to = std::clamp(b, 0.0, 1.0);
    }
    const Eigen::Vector3d p = segment.begin + from * ray;
    const Eigen::Vector3d q = segment.begin + to * ray;
    // A little wider than the support, for the rounding of the two ends.
    const Eigen::Vector3d wider = margin.array() + 1e-6;
    CellBox box = cellsBetween(p.cwiseMin(q) - wider, p.cwiseMax(q) + wider, block_);
    box.first[m] = slab;
    box.last[m] = last;
    visit(box);
  }
}

void PointSums::addSegment(const FreeSegment& segment, const CellMask* leftOut)
{
  const Line line(segment);
  const double support = supportOf(weights_.kernels, segment);
  constexpr double kRounding = 1 + 1e-9;
  const bool isSharp = weights_.kernels.levelOf(widestOf(segment) * kRounding) == 0;
  std::array<Row, kEdge * kEdge> along;
  std::array<Row, kEdge * kEdge> squared;
  forEachBoxAlong(segment, support,
                  [&](const CellBox& box)
                  {
                    withRegisters(
                        [&](auto lanes) LAMAP_INLINED_LAMBDA
                        {
                          size_t row = 0;
                          for (int z = box.first[2]; z <= box.last[2]; ++z)
                            for (int y = box.first[1]; y <= box.last[1]; ++y, ++row)
                              findDistances<decltype(lanes)>(
                                  line, block_.firstCell + Eigen::Vector3d(0.5, y + 0.5, z + 0.5), along[row],
                                  squared[row]);
                        });
                    size_t row = 0;
                    for (int z = box.first[2]; z <= box.last[2]; ++z)
                    {
                      const uint64_t left = leftOut != nullptr ? (*leftOut)[static_cast<size_t>(z)] : 0;
                      for (int y = box.first[1]; y <= box.last[1]; ++y, ++row)
                      {
                        const RowOfBox cells{static_cast<size_t>((z * kEdge + y) * kEdge), box.first[0],
                                             box.last[0], left >> (y * kEdge) & 0xFF};
                        if (isSharp)
                          addSharpRow(segment, cells, squared[row]);
                        else
                          addRow(segment, std::sqrt(line.squaredLength), cells, along[row], squared[row]);
                      }
                    }
                  });
}

void PointSums::addSharpRow(const FreeSegment& segment, const RowOfBox& cells, const Row& squared)
{
  const double support = weights_.kernels.supportOf(0);
  const double squaredSupport = support * support;
  const double factor = weights_.factor * segment.weight;
  sharp_.reserve(kEdge);
  for (int x = cells.firstX; x <= cells.lastX; ++x)
  {
    const auto i = static_cast<size_t>(x);
    const bool isWithin = squared[i] < squaredSupport;
    any_ = any_ || isWithin;
    sharp_.push(squared[i], isWithin && (cells.leftOut >> x & 1) == 0, factor, cells.first + i);
  }
}

/// @param along where on the segment the nearest points are, as a share of its length
void PointSums::addRow(const FreeSegment& segment, double length, const RowOfBox& cells, const Row& along,
                       const Row& squared)
{
  const double factor = weights_.factor * segment.weight;
  sharp_.reserve(kEdge);
  for (int x = cells.firstX; x <= cells.lastX; ++x)
  {
    const auto i = static_cast<size_t>(x);
    const size_t level = weights_.kernels.levelOf(segment.width.variance(along[i] * length));
    const double support = weights_.kernels.supportOf(level);
    if (!(squared[i] < support * support)) continue;
    any_ = true;
    if ((cells.leftOut >> x & 1) != 0) continue;
    if (level == 0)
      sharp_.push(squared[i], true, factor, cells.first + i);
    else
      addWide(level, squared[i], factor, cells.first + i);
  }
}

}  // namespace lamap
