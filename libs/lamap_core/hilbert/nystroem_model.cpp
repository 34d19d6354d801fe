#include <lamap_core/hilbert/nystroem_model.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>

namespace lamap
{
namespace
{
/// Of all training points together: they take 4 GB then.
constexpr double kMostFeatures = 1e9;
}  // namespace

NystroemMapModel::NystroemMapModel(const HilbertStructure& structure)
    : MapModel(structure), reach_sites_(reachInSites(structure))
{
}

int NystroemMapModel::reachInSites(const HilbertStructure& structure)
{
  return static_cast<int>(std::floor(structure.kernel().support_m() / structure.latticeSpacing + 0.5));
}

void NystroemMapModel::requireFewFeatures(size_t points) const
{
  if (static_cast<double>(points) * structure_.components > kMostFeatures)
    throw std::length_error("components = " + std::to_string(structure_.components) + ": " +
                            std::to_string(points) +
                            " training points have more features than fit into memory");
}

bool NystroemMapModel::isSurelyRoomFor(size_t points, const Extent& extent) const
{
  return static_cast<double>(points) * structure_.components <= kMostFeatures &&
         MapModel::isSurelyRoomFor(points, extent);
}

void NystroemMapModel::requireRoomFor(const HilbertTrainingSet& set, const HilbertFrame& frame)
{
  requireFewFeatures(set.size());
  MapModel::requireRoomFor(set, frame);
}

void NystroemMapModel::learnWeights(HilbertTrainingSet& set, const HilbertFrame& frame,
                                    const HilbertInference& inference, const Workers& workers)
{
  requireFewFeatures(set.size());
  work_->compact.findSites(set, kernel_, structure_.latticeSpacing, structure_.planar,
                           shiftOf(frame.anchorSite));
  Growth growth(lattice_, work_->compact.sites().blocks().size());
  const ReachedBox reached = addSites(work_->compact.sites(), frame, {}, growth);
  for (Eigen::Vector3d& point : set.points) point += cornerOf(frame.anchorSite, frame.spacing_m);
  std::optional<NystroemFeatures> first;
  if (features_.components() == 0)
    first.emplace(set.points, structure_.components, kernel_.gamma(), structure_.seed);
  const NystroemFeatures& features = first ? *first : features_;
  FeatureRows rows;
  features.rowsOf(set, rows, workers);
  work_->mean.assign(rows.weights(), 0.0f);
  work_->precision.assign(rows.weights(), 0.0f);
  for (const uint32_t j : rows.used()) work_->precision[j] = static_cast<float>(structure_.priorPrecision);
  std::vector<float> classifier = classifier_;
  classifier.resize(features.weightCount(), 0.0f);
  const uint64_t steps =
      solve({rows, set.labels, set.weights, work_->mean, work_->precision}, inference, workers, classifier);
  for (float& weight : classifier) weight = boundedWeight(weight);
  NystroemFeatures::Folded folded = features.fold(classifier);
  // Nothing fails from here on.
  if (first) features_ = *std::move(first);
  classifier_ = std::move(classifier);
  folded_ = std::move(folded);
  sgdSteps_ = steps;
  reached_ = reached;
  growth.keep();
}

bool NystroemMapModel::reaches(const CellIndex& site) const
{
  const int reach = reach_sites_;
  const int reachZ = structure_.planar ? 0 : reach;
  for (int32_t z = site.z - reachZ; z <= site.z + reachZ; ++z)
    for (int32_t y = site.y - reach; y <= site.y + reach; ++y)
      for (int32_t x = site.x - reach; x <= site.x + reach;)
      {
        // A row of a block is a byte of its bits.
        const CellIndex first{x, y, z};
        const auto* block = lattice_.find(SiteSet::blockOf(first));
        const int inBlock = x & (kScanBlockEdge - 1);
        const int count = std::min(kScanBlockEdge - inBlock, site.x + reach - x + 1);
        x += count;
        if (block == nullptr) continue;
        const uint32_t offset = SiteSet::offsetOf(first);
        const uint64_t run = block->bits[offset / 64] >> (offset % 64) & ((uint64_t{1} << count) - 1);
        if (run != 0) return true;
      }
  return false;
}

bool NystroemMapModel::reaches(const PointAtSite& point) const
{
  const auto along = [&](double coordinate, int32_t anchor)
  { return anchor + AxisReaches::siteOf(coordinate, structure_.latticeSpacing); };
  const CellIndex& anchor = point.anchorSite;
  return !classifier_.empty() &&
         reaches(CellIndex{along(point.place.x(), anchor.x), along(point.place.y(), anchor.y),
                           structure_.planar ? 0 : along(point.place.z(), anchor.z)});
}

Eigen::Vector3d NystroemMapModel::inMap(const PointAtSite& point) const
{
  Eigen::Vector3d place = point.place + cornerOf(point.anchorSite, structure_.latticeSpacing);
  if (structure_.planar) place.z() = 0.5 * structure_.latticeSpacing;
  return place;
}

ReachedLogodds NystroemMapModel::saidAt(const PointAtSite& point) const
{
  if (!reaches(point)) return {};
  return {static_cast<float>(features_.logoddsAt(folded_, inMap(point))), true};
}

ReachedLogodds NystroemMapModel::saidAt(const PointAtSite& point, const Eigen::Matrix3d& covariance) const
{
  if (!reaches(point)) return {};
  return {static_cast<float>(features_.logoddsAt(folded_, inMap(point), covariance)), true};
}

void NystroemMapModel::saidAtRegular(const CellIndex& anchorSite, const RegularPoints& points,
                                     std::vector<ReachedLogodds>& out) const
{
  out.assign(points.size(), {});
  if (classifier_.empty() || out.empty()) return;
  RegularPoints moved = points;
  moved.first = inMap({anchorSite, points.first});
  std::vector<float> logodds;
  features_.logoddsAt(folded_, moved, logodds, Workers(1));
  // Points share sites: the sites are found axis by axis, and each is asked once.
  std::array<std::vector<int32_t>, 3> sites;
  for (int axis = 0; axis < 3; ++axis)
    for (int i = 0; i < points.counts[static_cast<size_t>(axis)]; ++i)
      sites[static_cast<size_t>(axis)].push_back(
          structure_.planar && axis == 2
              ? 0
              : AxisReaches::siteOf(points.first[axis] + i * points.step_m, structure_.latticeSpacing));
  const auto countOf = [&](size_t axis)
  { return static_cast<size_t>(sites[axis].back() - sites[axis].front() + 1); };
  std::vector<std::optional<bool>> reached(countOf(0) * countOf(1) * countOf(2));
  const auto numberAlong = [&](size_t axis, int32_t site)
  { return static_cast<size_t>(site - sites[axis].front()); };
  size_t i = 0;
  for (const int32_t z : sites[2])
    for (const int32_t y : sites[1])
      for (const int32_t x : sites[0])
      {
        std::optional<bool>& known =
            reached[(numberAlong(2, z) * countOf(1) + numberAlong(1, y)) * countOf(0) + numberAlong(0, x)];
        if (!known) known = reaches(CellIndex{anchorSite.x + x, anchorSite.y + y, anchorSite.z + z});
        if (*known) out[i] = {logodds[i], true};
        ++i;
      }
}

size_t NystroemMapModel::memoryBytes() const
{
  return MapModel::memoryBytes() + features_.memoryBytes() + classifier_.capacity() * sizeof(float);
}

void NystroemMapModel::save(HilbertState& state) const
{
  MapModel::save(state);
  state.inducing = features_.inducing();
  if (!state.inducing.empty())
    state.classifier.assign(classifier_.begin(),
                            classifier_.begin() + static_cast<long>(state.inducing.size()) + 1);
}

void NystroemMapModel::restore(const HilbertState& state)
{
  const std::vector<Eigen::Vector3d>& inducing = state.inducing;
  const std::vector<float>& classifier = state.classifier;
  HilbertState::require(classifier.size() == (inducing.empty() ? 0 : inducing.size() + 1),
                        "not one weight for each inducing point and one for the bias");
  HilbertState::require(inducing.size() <= structure_.components, "more inducing points than components");
  const auto isPlace = [&](const Eigen::Vector3d& p)
  {
    return p.allFinite() &&
           HilbertFrame::inMap(p, structure_.resolution, structure_.latticeSpacing, structure_.planarLayer())
               .has_value();
  };
  HilbertState::require(std::all_of(inducing.begin(), inducing.end(), isPlace),
                        "an inducing point is not finite, or beyond what can be addressed");
  HilbertState::require(std::all_of(classifier.begin(), classifier.end(), isLegalWeight),
                        "a weight is not finite, or too large");
  MapModel::restore(state);
  if (inducing.empty()) return;
  features_ = NystroemFeatures(inducing, kernel_.gamma());
  classifier_ = classifier;
  classifier_.resize(features_.weightCount(), 0.0f);
  folded_ = features_.fold(classifier_);
}

}  // namespace lamap
