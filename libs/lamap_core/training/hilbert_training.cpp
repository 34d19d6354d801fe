#include <lamap_core/training/hilbert_training.h>

#include <lamap_core/grid/scan_blocks.h>
#include <lamap_core/options/legal_range.h>
#include <lamap_core/training/point_groups.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace lamap
{
namespace
{
/// A bit for each cell of a scan block: 64-bit word z, bit y·8 + x.
using CellBits = std::array<uint64_t, kScanBlockEdge>;

struct HitsAndFree
{
  CellBits hit{};
  CellBits free{};
};

/// A ray in the scan's frame [cells].
struct SampledRay
{
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;  ///< of length 1
  double firstSample;         ///< distance of its farthest free sample from the origin; < 0: it has none
};

BlockIndex blockOf(int32_t x, int32_t y, int32_t z)
{
  return {x >> kScanBlockLog2Edge, y >> kScanBlockLog2Edge, z >> kScanBlockLog2Edge};
}

BlockIndex blockOf(const Eigen::Vector3d& local)
{
  return blockOf(localCell(local.x()), localCell(local.y()), localCell(local.z()));
}

/// Marks cells in the blocks that hold them; the last block is remembered, for rays walk on.
class CellMarker
{
 public:
  CellMarker(ScanBlocks& blocks, std::vector<HitsAndFree>& masks) : blocks_(blocks), masks_(masks) {}

  template <CellBits HitsAndFree::*kBits>
  void mark(const Eigen::Vector3d& local)
  {
    const int32_t x = localCell(local.x());
    const int32_t y = localCell(local.y());
    const int32_t z = localCell(local.z());
    const BlockIndex block = blockOf(x, y, z);
    if (number_ < 0 || !(block == last_))
    {
      number_ = blocks_.findOrAdd(block);
      last_ = block;
      if (static_cast<size_t>(number_) >= masks_.size()) masks_.resize(static_cast<size_t>(number_) + 1);
    }
    constexpr int32_t kLow = kScanBlockEdge - 1;
    (masks_[static_cast<size_t>(number_)].*kBits)[static_cast<size_t>(z & kLow)] |=
        uint64_t{1} << ((y & kLow) * kScanBlockEdge + (x & kLow));
  }

 private:
  ScanBlocks& blocks_;
  std::vector<HitsAndFree>& masks_;
  BlockIndex last_;
  int32_t number_ = -1;
};

/// Calls visit(place) for each free sample, from the far end to the sensor.
template <typename Visit>
void forEachFreeSample(const SampledRay& ray, double step, Visit&& visit)
{
  if (!(ray.firstSample >= 0)) return;
  const auto last = static_cast<int64_t>(ray.firstSample / step);
  for (int64_t i = 0; i <= last; ++i)
  {
    const double t = ray.firstSample - static_cast<double>(i) * step;
    visit(Eigen::Vector3d(ray.origin + std::max(t, 0.0) * ray.direction));
  }
}

Eigen::Matrix3d crossMatrix(const Eigen::Vector3d& v)
{
  Eigen::Matrix3d matrix;
  matrix << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return matrix;
}

template <typename Matrix>
void requireCovariance(const Matrix& covariance, const char* name)
{
  for (int row = 0; row < covariance.rows(); ++row)
  {
    requireLegal(covariance(row, row) >= 0 && std::isfinite(covariance(row, row)), name, covariance(row, row),
                 "a covariance: finite, with variances >= 0");
    for (int column = 0; column < row; ++column)
    {
      const double one = covariance(row, column);
      const double other = covariance(column, row);
      const double largest = std::sqrt(covariance(row, row)) * std::sqrt(covariance(column, column));
      requireLegal(std::isfinite(one) && std::abs(one - other) <= 1e-6 * largest + 1e-300 &&
                       std::abs(one) <= largest * (1 + 1e-6),
                   name, one, "a covariance: symmetric, no larger than its variances allow");
    }
  }
}

}  // namespace

void HilbertSampling::validate() const
{
  requireLegal(freeMargin >= 0 && std::isfinite(freeMargin), "freeMargin", freeMargin,
               "a finite length >= 0");
  requireLegal(freeResolution >= 1e-3 && std::isfinite(freeResolution), "freeResolution", freeResolution,
               "a finite length >= 0.001");
  requireLegal(hitWeight > 0 && hitWeight <= 1e6, "hitWeight", hitWeight, "a number > 0, at most 1e6");
  requireLegal(freeWeight >= 0 && freeWeight <= 1e6, "freeWeight", freeWeight, "a number from 0 to 1e6");
}

bool operator==(const HilbertSampling& a, const HilbertSampling& b)
{
  return a.trainingPoints == b.trainingPoints && a.freeMargin == b.freeMargin &&
         a.freeResolution == b.freeResolution && a.hitWeight == b.hitWeight && a.freeWeight == b.freeWeight;
}

bool HilbertUncertainty::any() const
{
  return !pose.isZero(0) || rangeStd_m > 0 || !point.isZero(0);
}

void HilbertUncertainty::validate() const
{
  requireCovariance(pose, "covariance of the pose");
  requireCovariance(point, "covariance of a point");
  requireLegal(centre.allFinite(), "centre of rotation", centre.sum(), "finite");
  requireLegal(rangeStd_m >= 0 && std::isfinite(rangeStd_m), "standard deviation of ranges", rangeStd_m,
               "a finite length >= 0");
}

Eigen::Matrix3d HilbertUncertainty::of(const Eigen::Vector3d& place, const Eigen::Vector3d& sensor) const
{
  Eigen::Matrix<double, 3, 6> change;  // of the place with the pose: t + ω × (place − centre)
  change.leftCols<3>().setIdentity();
  change.rightCols<3>() = -crossMatrix(place - centre);
  // Products without Eigen's kernels, which may fuse where a processor can.
  Eigen::Matrix3d sum = point;
  const Eigen::Vector3d ray = place - sensor;
  const double squaredRange = ray.squaredNorm();
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
    {
      for (int i = 0; i < 6; ++i)
        for (int j = 0; j < 6; ++j) sum(row, column) += change(row, i) * pose(i, j) * change(column, j);
      if (squaredRange > 0)
        sum(row, column) += rangeStd_m * rangeStd_m * ray[row] * ray[column] / squaredRange;
    }
  return sum;
}

void HilbertTrainingSet::clear()
{
  points.clear();
  labels.clear();
  weights.clear();
  covariances.clear();
}

void HilbertTrainingSet::add(const Eigen::Vector3d& point, bool occupied, double weight)
{
  points.push_back(point);
  labels.push_back(occupied ? 1.0f : 0.0f);
  weights.push_back(static_cast<float>(weight));
}

struct HilbertSampler::Workspace
{
  HilbertTrainingSet set;
  std::vector<SampledRay> rays;
  std::vector<Eigen::Vector3d> hits;  ///< [cells]
  PointGroups groups;
  ScanBlocks blocks;
  std::vector<HitsAndFree> masks;
  Eigen::Vector3d low = Eigen::Vector3d::Zero();
  Eigen::Vector3d high = Eigen::Vector3d::Zero();

  void collectFan(const SelectedFan& fan, const HilbertSampling& sampling, const HilbertFrame& frame,
                  RayCounts& counts);
  void addCells(const HilbertSampling& sampling, const HilbertFrame& frame);
  void addPoints(const HilbertSampling& sampling, const HilbertFrame& frame);

 private:
  void extend(const Eigen::Vector3d& local)
  {
    low = low.cwiseMin(local);
    high = high.cwiseMax(local);
  }
  void addRay(const Eigen::Vector3d& origin, const Eigen::Vector3d& end, double margin)
  {
    const Eigen::Vector3d ray = end - origin;
    const double length = ray.norm();
    if (length > 0) rays.push_back({origin, ray / length, length - margin});
  }
};

void HilbertSampler::Workspace::collectFan(const SelectedFan& fan, const HilbertSampling& sampling,
                                           const HilbertFrame& frame, RayCounts& counts)
{
  const auto origin = frame.cells.toLocal(fan.origin_map);
  const bool once = sampling.trainingPoints == HilbertPoints::Cells;
  const auto collect =
      [&](const std::vector<Eigen::Vector3d>& ends, size_t& used, double margin, auto&& toLocal, auto&& visit)
  {
    groups.clear();
    for (const Eigen::Vector3d& end : ends)
    {
      const std::optional<Eigen::Vector3d> local = origin ? toLocal(end) : std::nullopt;
      if (!local || (frame.planar && *local == *origin))
      {
        --used;
        ++(local ? counts.tooNear : counts.outside);
        continue;
      }
      extend(*local);
      visit(*local);
      if (once)
        groups.add(cellKey(*local), *local);
      else
        addRay(*origin, *local, margin);
    }
    if (!origin) return;
    extend(*origin);
    for (const PointGroup& group : groups.groups()) addRay(*origin, group.mean(), margin);
  };
  collect(
      fan.hitEnds_map, counts.hits, sampling.freeMargin / frame.resolution_m,
      [&](const Eigen::Vector3d& end) { return frame.cells.toLocal(end); },
      [&](const Eigen::Vector3d& local) { hits.push_back(local); });
  collect(
      fan.freeRays_map, counts.freeOnly, 0.0,
      [&](const Eigen::Vector3d& ray) { return frame.cells.endOfRay(*origin, ray); },
      [](const Eigen::Vector3d&) {});
}

void HilbertSampler::Workspace::addCells(const HilbertSampling& sampling, const HilbertFrame& frame)
{
  // A sample may round across the face of its ray's last cell.
  blocks.reset(blockOf(Eigen::Vector3d(low.array() - 1.0)), blockOf(Eigen::Vector3d(high.array() + 1.0)));
  masks.clear();
  CellMarker marker(blocks, masks);
  for (const Eigen::Vector3d& hit : hits) marker.mark<&HitsAndFree::hit>(hit);
  if (sampling.freeWeight > 0)
  {
    const double step = sampling.freeResolution / frame.resolution_m;
    for (const SampledRay& ray : rays)
      forEachFreeSample(ray, step,
                        [&](const Eigen::Vector3d& place) { marker.mark<&HitsAndFree::free>(place); });
  }

  std::vector<size_t> order(masks.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::sort(order.begin(), order.end(),
            [&](size_t a, size_t b) { return blocks.blocks()[a] < blocks.blocks()[b]; });
  for (const size_t number : order)
  {
    const BlockIndex& block = blocks.blocks()[number];
    const HitsAndFree& cells = masks[number];
    for (int z = 0; z < kScanBlockEdge; ++z)
    {
      const uint64_t hit = cells.hit[static_cast<size_t>(z)];
      for (uint64_t rest = hit | cells.free[static_cast<size_t>(z)]; rest != 0; rest &= rest - 1)
      {
        const int bit = __builtin_ctzll(rest);
        const Eigen::Vector3d centre(block.x * kScanBlockEdge + bit % kScanBlockEdge + 0.5,
                                     block.y * kScanBlockEdge + bit / kScanBlockEdge + 0.5,
                                     block.z * kScanBlockEdge + z + 0.5);
        const bool occupied = (hit >> bit & 1) != 0;
        set.add(frame.position(centre), occupied, occupied ? sampling.hitWeight : sampling.freeWeight);
      }
    }
  }
}

void HilbertSampler::Workspace::addPoints(const HilbertSampling& sampling, const HilbertFrame& frame)
{
  for (const Eigen::Vector3d& hit : hits) set.add(frame.position(hit), true, sampling.hitWeight);
  if (!(sampling.freeWeight > 0)) return;
  const double step = sampling.freeResolution / frame.resolution_m;
  double expected = static_cast<double>(hits.size());
  for (const SampledRay& ray : rays) expected += std::max(0.0, ray.firstSample / step + 1.0);
  constexpr double kMaxPoints = 5e7;
  if (expected > kMaxPoints)
    throw std::length_error(
        "a scan has more than 50 million training points: set maxRange, or a larger freeResolution");
  for (const SampledRay& ray : rays)
    forEachFreeSample(ray, step,
                      [&](const Eigen::Vector3d& place)
                      { set.add(frame.position(place), false, sampling.freeWeight); });
}

HilbertSampler::HilbertSampler() : workspace_(std::make_unique<Workspace>()) {}
HilbertSampler::~HilbertSampler() = default;

HilbertTrainingSet& HilbertSampler::sample(SelectedRays& selected, const HilbertSampling& sampling,
                                           const HilbertFrame& frame)
{
  sampling.validate();
  Workspace& work = *workspace_;
  work.set.clear();
  work.rays.clear();
  work.hits.clear();
  work.low.setZero();
  work.high.setZero();
  for (const SelectedFan& fan : selected.fans) work.collectFan(fan, sampling, frame, selected.counts);
  if (sampling.trainingPoints == HilbertPoints::Cells)
    work.addCells(sampling, frame);
  else
    work.addPoints(sampling, frame);
  return work.set;
}

}  // namespace lamap
