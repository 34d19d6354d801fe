#include <lamap_core/overlapping/model.h>

#include <lamap_core/features/compact_kernel.h>
#include <lamap_core/features/lattice.h>
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

bool isRotation(const Eigen::Matrix3d& matrix)
{
  constexpr double kTolerance = 1e-6;
  return (matrix.transpose() * matrix - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < kTolerance &&
         matrix.determinant() > 0;
}

Eigen::Vector3d originOf(const Eigen::Isometry3d& pose, bool planar)
{
  return {pose.translation().x(), pose.translation().y(), planar ? 0.0 : pose.translation().z()};
}

/// Why no model can stand at a pose; null if one can.
const char* faultOf(const Eigen::Isometry3d& pose, double resolution_m, bool planar)
{
  if (!pose.matrix().allFinite()) return "is not finite";
  if (!isRotation(pose.linear())) return "has no rotation: its matrix is not orthonormal";
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

/// The sites of one axis that a coordinate reaches, and the kernel's factors of these.
class Factors
{
 public:
  Factors(double coordinate, const ModelShape& shape)
      : first(static_cast<int32_t>(std::ceil((coordinate - shape.support_m) / shape.spacing_m - 0.5))),
        coordinate_(coordinate)
  {
    const auto end = static_cast<int32_t>(std::floor((coordinate + shape.support_m) / shape.spacing_m - 0.5));
    last = std::min(end, first + static_cast<int32_t>(values_.size()) - 1);
  }

  int32_t first;
  int32_t last;

  /// Most questions meet no site: the factors are found where one does.
  void find(const ModelShape& shape)
  {
    for (int32_t site = first; site <= last; ++site)
    {
      const double d = coordinate_ - (site + 0.5) * shape.spacing_m;
      values_[static_cast<size_t>(site - first)] = portableExp(-shape.gamma * d * d);
    }
  }
  [[nodiscard]] double at(int32_t site) const { return values_[static_cast<size_t>(site - first)]; }

  /// Which of the eight sites from `begin` on are reached, a bit each.
  [[nodiscard]] uint64_t bitsFrom(int32_t begin) const
  {
    const int32_t low = std::max(first - begin, 0);
    const int32_t high = std::min(last - begin, kScanBlockEdge - 1);
    return low > high ? 0 : (uint64_t{2} << high) - (uint64_t{1} << low);
  }

 private:
  double coordinate_;
  std::array<double, AxisReach::kMaxSites + 2> values_;
};

size_t countOf(uint64_t word)
{
  return HilbertLattice<float>::Block::countOf(word);
}

/// Sum over the sites of a model that a point reaches.
class SiteSum
{
 public:
  SiteSum(const HilbertModel& model, const ModelShape& shape, const Eigen::Vector3d& p,
          const std::vector<uint32_t>& firstWeights)
      : model_(model),
        shape_(shape),
        firstWeights_(firstWeights),
        x_(p.x(), shape),
        y_(p.y(), shape),
        z_(p.z(), shape)
  {
  }

  std::optional<float> logodds()
  {
    const BlockIndex low = SiteSet::blockOf({x_.first, y_.first, z_.first});
    const BlockIndex high = SiteSet::blockOf({x_.last, y_.last, z_.last});
    size_t begin = 0;
    for (int32_t z = low.z; z <= high.z; ++z)
      for (int32_t y = low.y; y <= high.y; ++y)
        for (int32_t x = low.x; x <= high.x; ++x) addBlock({x, y, z}, begin);
    if (!reached_) return std::nullopt;
    return static_cast<float>(sum_);
  }

 private:
  /// @param begin where the search starts; blocks are asked for in their order
  void addBlock(const BlockIndex& index, size_t& begin)
  {
    const auto& blocks = model_.siteBlocks;
    const auto found = std::lower_bound(blocks.begin() + static_cast<long>(begin), blocks.end(), index);
    begin = static_cast<size_t>(found - blocks.begin());
    if (found == blocks.end() || !(*found == index)) return;
    const CellIndex corner{index.x * kScanBlockEdge, index.y * kScanBlockEdge, index.z * kScanBlockEdge};
    uint64_t reached = 0;
    for (uint64_t rows = y_.bitsFrom(corner.y); rows != 0; rows &= rows - 1)
      reached |= x_.bitsFrom(corner.x) << kScanBlockEdge * __builtin_ctzll(rows);
    const uint64_t layers = z_.bitsFrom(corner.z);
    size_t next = firstWeights_[begin];
    for (int32_t k = 0; k < kScanBlockEdge; ++k)
    {
      const uint64_t word = model_.siteBits[begin][static_cast<size_t>(k)];
      if ((layers >> k & 1) != 0 && (word & reached) != 0)
        addLayer({corner.x, corner.y, corner.z + k}, word, reached, next);
      next += countOf(word);
    }
  }

  /// @param corner of the layer; @param first number of its first weight
  void addLayer(const CellIndex& corner, uint64_t word, uint64_t reached, size_t first)
  {
    if (!found_)
      for (Factors* factors : {&x_, &y_, &z_}) factors->find(shape_);
    found_ = true;
    for (uint64_t rest = word & reached; rest != 0; rest &= rest - 1)
    {
      const int bit = __builtin_ctzll(rest);
      const double yz = y_.at(corner.y + bit / kScanBlockEdge) * z_.at(corner.z);
      const double kernel = x_.at(corner.x + bit % kScanBlockEdge) * yz - shape_.cutoff;
      if (!(kernel > 0)) continue;
      reached_ = true;
      const size_t number = first + countOf(word & ((uint64_t{1} << bit) - 1));
      sum_ += kernel * static_cast<double>(model_.siteWeights[number]);
    }
  }

  const HilbertModel& model_;
  const ModelShape& shape_;
  const std::vector<uint32_t>& firstWeights_;
  Factors x_;
  Factors y_;
  Factors z_;
  bool found_ = false;  ///< the factors
  double sum_ = 0;
  bool reached_ = false;
};

auto fieldsOf(const HilbertModel& m)
{
  return std::tie(m.siteBlocks, m.siteBits, m.siteWeights, m.inducing, m.kernelWeights, m.bias, m.boxLow,
                  m.boxHigh, m.fieldWeight, m.scans);
}

}  // namespace

bool ModelPose::isLegal(const Eigen::Isometry3d& pose, double resolution_m, bool planar)
{
  return faultOf(pose, resolution_m, planar) == nullptr;
}

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

Eigen::Isometry3d ModelPose::isometry(double resolution_m) const
{
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = rotation;
  pose.translation() = Eigen::Vector3d(anchor.x, anchor.y, anchor.z) * resolution_m + offset_m;
  return pose;
}

ModelShape::ModelShape(const OverlappingStructure& structure)
    : features(structure.features),
      gamma(structure.resolvedGamma()),
      cutoff(compact() ? structure.cutoff : 0.0),
      support_m(std::sqrt(-portableLog(compact() ? cutoff : kNothing) / gamma)),
      spacing_m(structure.latticeSpacing),
      resolution_m(structure.resolution),
      planar(structure.planar),
      speaksOutOfField(structure.outOfFieldLimit > 0)
{
}

std::array<bool, 4> HilbertModel::inField(const std::array<Eigen::Vector3d, 4>& places) const
{
  std::array<bool, 4> contained{};
  for (const DepthView& view : views) view.addContained(places, contained);
  return contained;
}

std::vector<uint32_t> HilbertModel::firstWeights() const
{
  std::vector<uint32_t> first;
  first.reserve(siteBits.size());
  size_t weights = 0;
  for (const SiteSet::Bits& bits : siteBits)
  {
    first.push_back(static_cast<uint32_t>(weights));
    for (const uint64_t word : bits) weights += countOf(word);
  }
  return first;
}

std::optional<float> HilbertModel::logoddsAt(const ModelShape& shape, const Eigen::Vector3d& p,
                                             const std::vector<uint32_t>& first) const
{
  if (shape.compact()) return SiteSum(*this, shape, p, first).logodds();
  double sum = bias;
  for (size_t k = 0; k < inducing.size(); ++k)
    sum +=
        static_cast<double>(kernelWeights[k]) * portableExp(-shape.gamma * (p - inducing[k]).squaredNorm());
  return static_cast<float>(sum);
}

int64_t logoddsUnits(float logodds, double weight)
{
  constexpr double kMaxLogodds = 1000.0;
  return inEvidenceUnits(std::clamp(static_cast<double>(logodds), -kMaxLogodds, kMaxLogodds) * weight);
}

CellSums HilbertModel::evidenceOf(const ModelShape& shape, float logodds, bool inField) const
{
  SignedSums sums;
  if (inField)
    sums.first = logoddsUnits(logodds, fieldWeight);
  else if (shape.speaksOutOfField)
    sums.second = logoddsUnits(logodds, 1.0);
  return sums.coded();
}

CellSums HilbertModel::evidenceAt(const ModelShape& shape, const Eigen::Vector3d& p,
                                  const std::vector<uint32_t>& first) const
{
  if (!inBox(p, shape.planar)) return {};
  const std::optional<float> logodds = logoddsAt(shape, p, first);
  return logodds ? evidenceOf(shape, *logodds, inField({p, p, p, p})[0]) : CellSums{};
}

size_t HilbertModel::memoryBytes() const
{
  size_t bytes = sizeof(*this) + siteBlocks.capacity() * sizeof(BlockIndex) +
                 siteBits.capacity() * sizeof(SiteSet::Bits) +
                 (siteWeights.capacity() + kernelWeights.capacity()) * sizeof(float) +
                 inducing.capacity() * sizeof(Eigen::Vector3d);
  for (const DepthView& view : views) bytes += view.memoryBytes();
  return bytes;
}

void HilbertModel::check(const ModelShape& shape) const
{
  const auto require = [](bool condition, const char* what)
  {
    if (!condition) throw std::runtime_error(std::string("a model of the map is corrupt: ") + what);
  };
  const auto finite = [](const std::vector<float>& weights)
  { return std::all_of(weights.begin(), weights.end(), [](float w) { return std::isfinite(w); }); };
  require(siteBits.size() == siteBlocks.size(), "its blocks of sites have not a mask each");
  require(std::adjacent_find(siteBlocks.begin(), siteBlocks.end(),
                             [](const BlockIndex& a, const BlockIndex& b)
                             { return !(a < b); }) == siteBlocks.end(),
          "its blocks of sites are not sorted");
  size_t sites = 0;
  for (const SiteSet::Bits& bits : siteBits)
    for (const uint64_t word : bits) sites += static_cast<size_t>(__builtin_popcountll(word));
  require(siteWeights.size() == sites, "it has not a weight a site");
  require(kernelWeights.size() == inducing.size(), "it has not a weight an inducing point");
  require(finite(siteWeights) && finite(kernelWeights) && std::isfinite(bias), "a weight is not finite");
  require(std::none_of(siteWeights.begin(), siteWeights.end(),
                       [](float w) { return std::abs(w) < kSmallestWeight; }),
          "a site's weight is 0");
  require(std::all_of(inducing.begin(), inducing.end(), [](const auto& p) { return p.allFinite(); }),
          "an inducing point is not finite");
  require(shape.compact() ? inducing.empty() && bias == 0 : siteBlocks.empty(),
          "its features are not the map's");
  require(boxLow.allFinite() && boxHigh.allFinite() && (boxLow.array() <= boxHigh.array()).all(),
          "its box is none");
  require(fieldWeight >= 1e-3 && fieldWeight <= 1e3, "the weight of its field is not legal");
  require(scans >= 1, "it was trained on no scan");
}

bool operator==(const HilbertModel& a, const HilbertModel& b)
{
  return fieldsOf(a) == fieldsOf(b) && a.views.size() == b.views.size() &&
         std::equal(a.views.begin(), a.views.end(), b.views.begin(),
                    [](const DepthView& x, const DepthView& y) { return x.image() == y.image(); });
}

}  // namespace lamap
