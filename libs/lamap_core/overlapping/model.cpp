#include <lamap_core/overlapping/model.h>

#include <lamap_core/features/logodds.h>
#include <lamap_core/grid/cell_sums.h>
#include <lamap_core/math/portable_math.h>
#include <lamap_core/scan/scan_frame.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <tuple>

namespace lamap
{
namespace
{
/// Nyström: the kernel is taken for 0 from here on.
constexpr double kNothing = 1e-9;

Eigen::Vector3d originOf(const Eigen::Isometry3d& pose, bool planar)
{
  return {pose.translation().x(), pose.translation().y(), planar ? 0.0 : pose.translation().z()};
}

bool isWeakHit(float logodds)
{
  return logodds < HilbertModel::kKeptHitLogodds;
}

/// Why no model can stand at a pose; null if one can.
const char* faultOf(const Eigen::Isometry3d& pose, double resolution_m, bool planar)
{
  if (!pose.matrix().allFinite()) return "is not finite";
  if (!isRotation(pose.linear())) return "has a rotation matrix that is not orthonormal";
  if (!cellAt(originOf(pose, planar), resolution_m)) return "lies beyond what cells can address";
  return nullptr;
}

/// The part of a rotation about the vertical: the direction in which the x axis then lies.
Eigen::Matrix3d yawOf(const Eigen::Matrix3d& rotation)
{
  double cosine = rotation(0, 0);
  double sine = rotation(1, 0);
  const double length = std::sqrt(cosine * cosine + sine * sine);
  constexpr double kUpright = 1e-6;  // no direction is left of an axis that points up
  if (length < kUpright) return Eigen::Matrix3d::Identity();
  cosine /= length;
  sine /= length;
  Eigen::Matrix3d yaw;
  yaw << cosine, -sine, 0, sine, cosine, 0, 0, 0, 1;
  return yaw;
}

double rounded(double length_m)
{
  return std::floor(length_m * 0x1p24 + 0.5) * 0x1p-24;
}

/// @param asked the shape as the model is asked
std::optional<float> logoddsBy(const HilbertModel& model, const ModelShape& asked, const Eigen::Vector3d& p)
{
  if (asked.compact())
  {
    const ReachedLogodds answer = asked.sum->at(model.sites, {}, p);
    return answer.reached ? std::optional<float>(answer.logodds) : std::nullopt;
  }
  double sum = model.bias;
  for (size_t k = 0; k < model.inducing.size(); ++k)
    sum += static_cast<double>(model.kernelWeights[k]) *
           portableExp(-asked.gamma * (p - model.inducing[k]).squaredNorm());
  return static_cast<float>(sum);
}

auto fieldsOf(const HilbertModel& m)
{
  return std::tie(m.sites, m.inducing, m.kernelWeights, m.bias, m.boxLow, m.boxHigh, m.hits, m.fieldWeight,
                  m.variance, m.scans);
}

}  // namespace

ModelPose ModelPose::of(const Eigen::Isometry3d& pose, double resolution_m, bool planar)
{
  if (const char* fault = faultOf(pose, resolution_m, planar))
    throw std::invalid_argument(std::string("the pose of a model ") + fault);
  const Eigen::Vector3d origin = originOf(pose, planar);
  const auto anchor = cellAt(origin, resolution_m);
  ModelPose result;
  result.anchor = *anchor;
  result.rotation = planar ? yawOf(pose.linear()) : Eigen::Matrix3d(pose.linear());
  const auto local = ScanFrame(resolution_m, *anchor, false).toLocal(origin);
  for (int axis = 0; axis < 3; ++axis) result.offset_m[axis] = rounded((*local)[axis] * resolution_m);
  return result;
}

void ModelPose::check(double resolution_m, bool planar) const
{
  const auto refuse = [](const char* fault)
  { throw std::runtime_error(std::string("the map is corrupt: the pose of a model ") + fault); };
  if (const char* fault = faultOf(isometry(resolution_m), resolution_m, planar)) refuse(fault);
  if (!(offset_m.cwiseAbs().maxCoeff() <= 2 * resolution_m)) refuse("is far from its anchor");
  const bool isUpright =
      rotation(0, 2) == 0 && rotation(1, 2) == 0 && rotation(2, 0) == 0 && rotation(2, 1) == 0;
  if (planar && !isUpright) refuse("is tilted, though the map is planar");
}

Eigen::Isometry3d ModelPose::isometry(double resolution_m) const
{
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = rotation;
  pose.translation() = Eigen::Vector3d(anchor.x, anchor.y, anchor.z) * resolution_m + offset_m;
  return pose;
}

Eigen::Vector3d ModelPose::toModel(const Eigen::Vector3d& fromAnchor_m) const
{
  const Eigen::Vector3d d = fromAnchor_m - offset_m;
  return turnedBack(d);
}

Eigen::Vector3d ModelPose::turnedBack(const Eigen::Vector3d& d) const
{
  const auto along = [&](int axis)
  { return (rotation(0, axis) * d.x() + rotation(1, axis) * d.y()) + rotation(2, axis) * d.z(); };
  return {along(0), along(1), along(2)};
}

Eigen::Vector3d ModelPose::fromModel(const Eigen::Vector3d& p) const
{
  const auto along = [&](int axis)
  {
    return ((rotation(axis, 0) * p.x() + rotation(axis, 1) * p.y()) + rotation(axis, 2) * p.z()) +
           offset_m[axis];
  };
  return {along(0), along(1), along(2)};
}

ModelShape::ModelShape(const OverlappingStructure& structure)
    : features(structure.features),
      gamma(structure.resolvedGamma()),
      cutoff(compact() ? structure.cutoff : 0.0),
      support_m(std::sqrt(-portableLog(compact() ? cutoff : kNothing) / gamma)),
      spacing_m(structure.latticeSpacing),
      resolution_m(structure.resolution),
      planar(structure.planar),
      sum(compact() ? std::make_optional<CompactSum>(structure.kernel(), spacing_m, planar) : std::nullopt),
      speaksOutOfField(structure.outOfFieldLimit > 0)
{
}

bool ModelShape::holds(const Eigen::Vector3d& p) const
{
  // A box is a little larger than its points.
  const double reach_m = (ScanFrame::kReach_cells + 2) * resolution_m;
  const auto isNear = [&](double coordinate) { return std::abs(coordinate) <= reach_m; };
  return p.allFinite() && isNear(p.x()) && isNear(p.y()) && (planar || isNear(p.z()));
}

double ModelShape::shareOf(double variance) const
{
  const double widening = 1 + 2 * gamma * variance;
  return planar ? 1 / widening : 1 / (widening * std::sqrt(widening));
}

ModelShape ModelShape::widened(double variance) const
{
  if (variance == 0) return *this;
  ModelShape wide = *this;
  wide.gamma = gamma / (1 + 2 * gamma * variance);
  wide.cutoff = compact() ? cutoff / shareOf(variance) : 0.0;
  wide.support_m = std::sqrt(-portableLog(compact() ? wide.cutoff : kNothing) / wide.gamma);
  if (compact()) wide.sum.emplace(CompactKernel(wide.gamma, wide.cutoff), spacing_m, planar);
  return wide;
}

double ModelShape::askable(double variance) const
{
  if (!compact()) return variance;
  const auto isLegal = [&](double some)
  {
    if (!(cutoff < shareOf(some))) return false;
    const double support = std::sqrt(-portableLog(cutoff / shareOf(some)) * (1 / gamma + 2 * some));
    return support >= support_m && 2 * support / spacing_m + 1 < AxisReach::kMaxSites;
  };
  constexpr double kNone_m2 = 1e-9;
  while (variance > kNone_m2 && !isLegal(variance)) variance *= 0.5;
  return variance > kNone_m2 ? variance : 0.0;
}

DepthView::Seen HilbertModel::seen(const std::array<Eigen::Vector3d, 4>& places) const
{
  DepthView::Seen seen;
  for (const DepthView& view : views) view.addSeen(places, seen);
  return seen;
}

std::optional<float> HilbertModel::logoddsAt(const ModelShape& shape, const Eigen::Vector3d& p) const
{
  return variance > 0 ? logoddsBy(*this, shape.widened(variance), p) : logoddsBy(*this, shape, p);
}

int64_t logoddsUnits(float logodds, double weight)
{
  constexpr double kMaxLogodds = 1000.0;
  return inEvidenceUnits(std::clamp(static_cast<double>(logodds), -kMaxLogodds, kMaxLogodds) * weight);
}

CellSums HilbertModel::evidenceOf(const ModelShape& shape, float logodds, bool inField, bool open) const
{
  SignedSums sums;
  // Free only where all rays beside a place reach farther; beyond them it is said as from outside.
  if (inField && (logodds >= 0 || open))
    sums.first = logoddsUnits(logodds, fieldWeight);
  else if (shape.speaksOutOfField)
    sums.second = logoddsUnits(logodds, 1.0);
  return sums.coded();
}

void HilbertModel::keepWeakHits(const std::vector<float>& logodds)
{
  std::vector<Eigen::Vector3f> weak;
  weak.reserve(static_cast<size_t>(std::count_if(logodds.begin(), logodds.end(), isWeakHit)));
  for (size_t i = 0; i < hits.size(); ++i)
    if (isWeakHit(logodds[i])) weak.push_back(hits[i]);
  hits = std::move(weak);
}

std::vector<std::optional<CellIndex>> HilbertModel::hitCells(const ModelPose& pose, const ModelShape& shape,
                                                             int32_t layer) const
{
  std::vector<std::optional<CellIndex>> cells;
  cells.reserve(hits.size());
  for (const Eigen::Vector3f& hit : hits)
  {
    const Eigen::Vector3d local = pose.fromModel(hit.cast<double>()) / shape.resolution_m;
    if (!(local.cwiseAbs().maxCoeff() < ScanFrame::kReach_cells))
    {
      cells.emplace_back(std::nullopt);
      continue;
    }
    const CellIndex cell = cellOfLocal(local);
    cells.push_back(CellIndex{pose.anchor.x + cell.x, pose.anchor.y + cell.y,
                              shape.planar ? layer : pose.anchor.z + cell.z});
  }
  return cells;
}

CellSums HilbertModel::evidenceAt(const ModelShape& shape, const Eigen::Vector3d& p, bool inHitCell) const
{
  if (!inBox(p, shape.planar)) return {};
  std::optional<float> logodds = logoddsAt(shape, p);
  if (inHitCell) logodds = std::max(logodds.value_or(kHitLogodds), kHitLogodds);
  if (!logodds) return {};
  const DepthView::Seen seenOf = seen({p, p, p, p});
  return evidenceOf(shape, *logodds, seenOf.inField[0], seenOf.open[0]);
}

size_t HilbertModel::memoryBytes() const
{
  size_t bytes = sizeof(*this) + sites.memoryBytes() + kernelWeights.capacity() * sizeof(float) +
                 inducing.capacity() * sizeof(Eigen::Vector3d) + hits.capacity() * sizeof(Eigen::Vector3f);
  for (const DepthView& view : views) bytes += view.memoryBytes();
  return bytes;
}

void HilbertModel::check(const ModelShape& shape) const
{
  const auto require = [](bool condition, const char* what)
  {
    if (!condition) throw std::runtime_error(std::string("a model of the map is corrupt: ") + what);
  };
  const auto legal = [](const std::vector<float>& weights)
  { return std::all_of(weights.begin(), weights.end(), [](float w) { return isLegalWeight(w); }); };
  const auto held = [&](const auto& p) { return shape.holds(p.template cast<double>()); };
  const auto isSiteBlock = [&](const BlockIndex& block)
  {
    // The nearest of its sites to the origin.
    const auto nearest = [&](int32_t i)
    { return std::max(0.0, std::abs(static_cast<double>(i)) - 1) * kScanBlockEdge * shape.spacing_m; };
    return held(Eigen::Vector3d(nearest(block.x), nearest(block.y), nearest(block.z))) &&
           (!shape.planar || block.z == 0);
  };
  require(sites.bits.size() == sites.blocks.size(), "not every block of its sites has a mask");
  require(std::adjacent_find(sites.blocks.begin(), sites.blocks.end(),
                             [](const BlockIndex& a, const BlockIndex& b)
                             { return !(a < b); }) == sites.blocks.end(),
          "its blocks of sites are not sorted");
  size_t count = 0;
  for (const SiteSet::Bits& bits : sites.bits)
    for (const uint64_t word : bits) count += SiteBits::countOf(word);
  require(sites.weights.size() == count, "not every site has one weight");
  require(sites.firstWeights.size() == sites.blocks.size(), "its sites are not numbered");
  require(kernelWeights.size() == inducing.size(), "not every inducing point has one weight");
  require(legal(sites.weights) && legal(kernelWeights) && isLegalWeight(bias),
          "a weight is not finite, or too large");
  require(std::all_of(sites.blocks.begin(), sites.blocks.end(), isSiteBlock), "a site is out of its reach");
  require(std::none_of(sites.weights.begin(), sites.weights.end(),
                       [](float w) { return std::abs(w) < kSmallestWeight; }),
          "a site's weight is 0");
  require(std::all_of(inducing.begin(), inducing.end(), held),
          "an inducing point is not finite, or out of its reach");
  require(shape.compact() ? inducing.empty() && bias == 0 : sites.blocks.empty(),
          "its features are not the map's");
  require(held(boxLow) && held(boxHigh) && (boxLow.array() <= boxHigh.array()).all(),
          "its box is not finite, out of its reach, or has its corners swapped");
  require(std::all_of(hits.begin(), hits.end(), held), "a hit is not finite, or out of its reach");
  require(std::all_of(views.begin(), views.end(),
                      [&](const DepthView& view)
                      { return held(view.image().sensor) && view.image().planar == shape.planar; }),
          "a view is not of this map, or its sensor out of reach");
  require(fieldWeight >= 1e-3 && fieldWeight <= 1e3, "the weight of its field is not legal");
  require(variance >= 0 && std::isfinite(variance) && shape.askable(variance) == variance,
          "its training points are too uncertain");
  require(scans >= 1, "it was trained on no scan");
}

bool operator==(const HilbertModel& a, const HilbertModel& b)
{
  return fieldsOf(a) == fieldsOf(b) && a.views.size() == b.views.size() &&
         std::equal(a.views.begin(), a.views.end(), b.views.begin(),
                    [](const DepthView& x, const DepthView& y) { return x.image() == y.image(); });
}

}  // namespace lamap
