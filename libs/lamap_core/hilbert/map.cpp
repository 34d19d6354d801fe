#include <lamap_core/hilbert/map.h>

#include <lamap_core/features/rows.h>
#include <lamap_core/learning/lbfgs.h>
#include <lamap_core/learning/sgd.h>
#include <lamap_core/math/portable_math.h>
#include <lamap_core/math/workers.h>
#include <lamap_core/options/legal_range.h>
#include <tsl/robin_map.h>
#include <tsl/robin_set.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <stdexcept>
#include <string>
#include <tuple>

namespace lamap
{
namespace
{
constexpr int kBits = kScanBlockLog2Edge;
constexpr int kEdge = kScanBlockEdge;

struct CellHash
{
  [[nodiscard]] size_t operator()(const CellIndex& cell) const noexcept
  {
    return BlockIndexHash{}(BlockIndex{cell.x, cell.y, cell.z});
  }
};

struct PointWeights
{
  float hits = 0;
  float frees = 0;
};

/// Sites of a scan are counted from its anchor; shifted by this, their blocks are those of the lattice.
CellIndex shiftOf(const CellIndex& anchorSite)
{
  constexpr int32_t kLow = kEdge - 1;
  return {anchorSite.x & kLow, anchorSite.y & kLow, anchorSite.z & kLow};
}

BlockIndex plusAnchor(const BlockIndex& block, const CellIndex& anchorSite)
{
  return {block.x + (anchorSite.x >> kBits), block.y + (anchorSite.y >> kBits),
          block.z + (anchorSite.z >> kBits)};
}

Eigen::Vector3d cornerOf(const CellIndex& site, double spacing_m)
{
  return spacing_m * Eigen::Vector3d(site.x, site.y, site.z);
}

/// Finds the weights of sites that come sorted, looking up a block once for its row.
class SiteCursor
{
 public:
  SiteCursor(HilbertLattice<SitePosterior>& lattice, const CellIndex& anchorSite)
      : lattice_(lattice),
        low_{anchorSite.x & ~(kEdge - 1), anchorSite.y & ~(kEdge - 1), anchorSite.z & ~(kEdge - 1)}
  {
  }
  /// @param shifted site, which must be there
  SitePosterior& at(const CellIndex& shifted)
  {
    const CellIndex site{shifted.x + low_.x, shifted.y + low_.y, shifted.z + low_.z};
    const BlockIndex index = SiteSet::blockOf(site);
    if (block_ == nullptr || !(index == last_))
    {
      block_ = lattice_.find(index);
      last_ = index;
    }
    return block_->weights[block_->placeOf(SiteSet::offsetOf(site))];
  }

 private:
  HilbertLattice<SitePosterior>& lattice_;
  CellIndex low_;
  BlockIndex last_;
  HilbertLattice<SitePosterior>::Block* block_ = nullptr;
};

void addCovariances(const HilbertUncertainty& uncertainty, const Eigen::Vector3d& sensor_map,
                    const HilbertFrame& frame, HilbertTrainingSet& set)
{
  const Eigen::Vector3d corner = cornerOf(frame.anchorSite, frame.spacing_m);
  HilbertUncertainty local = uncertainty;
  local.centre -= corner;
  const Eigen::Vector3d sensor = sensor_map - corner;
  set.covariances.reserve(set.size());
  for (const Eigen::Vector3d& point : set.points)
  {
    Eigen::Matrix3d covariance = local.of(point, sensor);
    if (frame.planar)
    {
      covariance.row(2).setZero();
      covariance.col(2).setZero();
    }
    set.covariances.push_back(covariance);
  }
}

SgdOptions sgdOptions(const HilbertInference& inference, const HilbertStructure& structure)
{
  const bool l2 = inference.solverFor(structure.training) == HilbertSolver::SgdL2;
  return {inference, l2 ? SgdPenalty::L2 : SgdPenalty::L1, structure.seed};
}

}  // namespace

struct HilbertMap::Model
{
  HilbertLattice<SitePosterior> lattice;
  uint64_t sgdSteps = 0;
  NystroemFeatures nystroem;
  std::vector<float> classifier;
  NystroemFeatures::Folded folded;
  tsl::robin_map<CellIndex, PointWeights, CellHash> cells;
  std::vector<HilbertState::Point> points;
  HilbertInference lastInference;
  unsigned lastThreads = 0;
  std::atomic<bool> stale{false};
  std::mutex training;

  Model() = default;
  Model(const Model& other)
      : lattice(other.lattice),
        sgdSteps(other.sgdSteps),
        nystroem(other.nystroem),
        classifier(other.classifier),
        folded(other.folded),
        cells(other.cells),
        points(other.points),
        lastInference(other.lastInference),
        lastThreads(other.lastThreads),
        stale(other.stale.load())
  {
  }

  /// Solves for the weights u of rows, starting from u. @param precision Λ of the prior, whose mean is `mean`
  void solve(FeatureRows& rows, const HilbertTrainingSet& set, const HilbertInference& inference,
             const HilbertStructure& structure, const std::vector<float>& mean,
             const std::vector<float>& precision, const Workers& workers, std::vector<float>& u)
  {
    if (inference.solverFor(structure.training) == HilbertSolver::Lbfgs)
      lbfgs.minimize({rows, set.labels, set.weights, mean, precision},
                     {static_cast<int>(inference.iterationsFor(structure.training)), LbfgsOptions{}.memory},
                     u, workers);
    else
      sgdSteps = trainSgd(rows, set.labels, set.weights, sgdOptions(inference, structure), sgdSteps, u);
  }
  Lbfgs lbfgs;
};

struct HilbertMap::Workspace
{
  HilbertSampler sampler;
  CompactRows compact;
  SiteSet reached;
  std::vector<float> mean, precision, weights, curvature;
};

HilbertMap::HilbertMap(const HilbertStructure& structure)
    : structure_(structure), model_(std::make_unique<Model>())
{
  structure_.validate();
  kernel_ = structure_.kernel();
}

HilbertMap::HilbertMap(const HilbertMap& other) : structure_(other.structure_), kernel_(other.kernel_)
{
  const std::lock_guard<std::mutex> lock(other.model_->training);
  model_ = std::make_unique<Model>(*other.model_);
}

HilbertMap& HilbertMap::operator=(const HilbertMap& other)
{
  if (this != &other) *this = HilbertMap(other);
  return *this;
}

HilbertMap::HilbertMap(HilbertMap&&) noexcept = default;
HilbertMap& HilbertMap::operator=(HilbertMap&&) noexcept = default;
HilbertMap::~HilbertMap() = default;

RayCounts HilbertMap::insert(const Scan& scan, const HilbertInference& inference,
                             const HilbertUncertainty* uncertainty, unsigned threads)
{
  inference.validate(structure_);
  if (uncertainty != nullptr) uncertainty->validate();
  if (!workspace_) workspace_ = std::make_unique<Workspace>();
  SelectedRays rays = selectRays(scan, inference.rangeLimits());
  std::optional<HilbertFrame> frame;
  Eigen::Vector3d sensor = Eigen::Vector3d::Zero();
  for (const SelectedFan& fan : rays.fans)
  {
    if (frame || !fan.origin_map.allFinite()) continue;
    frame = HilbertFrame::inMap(fan.origin_map, structure_.resolution, structure_.latticeSpacing,
                                structure_.planarLayer());
    sensor = fan.origin_map;
  }
  if (!frame)
    frame = HilbertFrame::atCell({0, 0, structure_.planarLayer().value_or(0)}, structure_.resolution,
                                 structure_.latticeSpacing, structure_.planar);
  HilbertTrainingSet& set = workspace_->sampler.sample(rays, inference, *frame);
  if (set.size() == 0) return rays.counts;
  if (uncertainty != nullptr && uncertainty->any()) addCovariances(*uncertainty, sensor, *frame, set);

  if (structure_.training == HilbertTraining::Batch)
    keepPoints(set, *frame, inference, threads);
  else if (structure_.features == HilbertFeatures::Compact)
    learnOnLattice(set, *frame, inference, threads, *workspace_);
  else
    learnOnNystroem(set, *frame, inference, threads, *workspace_);
  return rays.counts;
}

void HilbertMap::addSites(const SiteSet& sites, const HilbertFrame& frame, const SitePosterior& weight) const
{
  for (size_t i = 0; i < sites.blocks().size(); ++i)
    model_->lattice.addSites(plusAnchor(sites.blocks()[i], frame.anchorSite), sites.bits(i), weight);
}

void HilbertMap::learnOnLattice(const HilbertTrainingSet& set, const HilbertFrame& frame,
                                const HilbertInference& inference, unsigned threads, Workspace& work) const
{
  const Workers workers(threads);
  const auto prior = static_cast<float>(structure_.priorPrecision);
  const bool laplace = structure_.training == HilbertTraining::Incremental;
  const CellIndex shift = shiftOf(frame.anchorSite);
  work.compact.findSites(set, kernel_, structure_.latticeSpacing, structure_.planar, shift);
  SiteSet& sites = work.compact.sites();
  if (sites.blocks().empty()) return;  // all points are too uncertain to say anything
  addSites(sites, frame, {0.0f, laplace ? prior : 0.0f});

  // The scan also speaks of features that are there already and that its points reach.
  work.reached = sites;
  work.reached.dilate(work.compact.reach_sites(), structure_.planar);
  for (size_t i = 0; i < work.reached.blocks().size(); ++i)
  {
    const BlockIndex& block = work.reached.blocks()[i];
    SiteSet::Bits bits = model_->lattice.bitsOf(plusAnchor(block, frame.anchorSite));
    bool any = false;
    for (size_t word = 0; word < bits.size(); ++word)
    {
      bits[word] &= work.reached.bits(i)[word];
      any = any || bits[word] != 0;
    }
    if (any) sites.insert(block, bits);
  }
  work.compact.build(set, workers);

  FeatureRows& rows = work.compact.rows();
  const SiteNumbers& numbers = work.compact.numbers();
  work.mean.assign(rows.weights(), 0.0f);
  work.precision.assign(rows.weights(), 0.0f);
  SiteCursor cursor(model_->lattice, frame.anchorSite);
  for (size_t j = 0; j < numbers.sites().size(); ++j)
  {
    const SitePosterior& posterior = cursor.at(numbers.sites()[j]);
    work.mean[numbers.used()[j]] = posterior.mean;
    work.precision[numbers.used()[j]] = laplace ? posterior.precision : prior;
  }
  work.weights = work.mean;
  model_->solve(rows, set, inference, structure_, work.mean, work.precision, workers, work.weights);
  if (laplace)
    model_->lbfgs.finalCurvature({rows, set.labels, set.weights, work.mean, work.precision}, work.curvature,
                                 workers);
  for (size_t j = 0; j < numbers.sites().size(); ++j)
  {
    SitePosterior& posterior = cursor.at(numbers.sites()[j]);
    posterior.mean = work.weights[numbers.used()[j]];
    if (laplace) posterior.precision = work.curvature[numbers.used()[j]];
  }
}

void HilbertMap::learnOnNystroem(HilbertTrainingSet& set, const HilbertFrame& frame,
                                 const HilbertInference& inference, unsigned threads, Workspace& work) const
{
  const Workers workers(threads);
  Model& model = *model_;
  constexpr double kMostFeatures = 1e9;
  if (static_cast<double>(set.size()) * structure_.components > kMostFeatures)
    throw std::length_error("components = " + std::to_string(structure_.components) + ": " +
                            std::to_string(set.size()) +
                            " training points have more features than fit into memory");
  work.compact.findSites(set, kernel_, structure_.latticeSpacing, structure_.planar,
                         shiftOf(frame.anchorSite));
  addSites(work.compact.sites(), frame, {});
  for (Eigen::Vector3d& point : set.points) point += cornerOf(frame.anchorSite, frame.spacing_m);
  if (model.nystroem.components() == 0)
  {
    model.nystroem = NystroemFeatures(set.points, structure_.components, kernel_.gamma(), structure_.seed);
    model.classifier.assign(model.nystroem.weightCount(), 0.0f);
  }
  FeatureRows rows;
  model.nystroem.rowsOf(set, rows, workers);
  const std::vector<float> mean(rows.weights(), 0.0f);
  std::vector<float> precision(rows.weights(), 0.0f);
  for (const uint32_t j : rows.used()) precision[j] = static_cast<float>(structure_.priorPrecision);
  model.solve(rows, set, inference, structure_, mean, precision, workers, model.classifier);
  model.folded = model.nystroem.fold(model.classifier);
}

void HilbertMap::keepPoints(const HilbertTrainingSet& set, const HilbertFrame& frame,
                            const HilbertInference& inference, unsigned threads)
{
  Model& model = *model_;
  // Points of equal place and label are one with the sum of their weights: the loss is the same.
  const bool atCentres = inference.trainingPoints == HilbertPoints::Cells && set.covariances.empty();
  const CellIndex& anchor = frame.cells.anchor();
  for (size_t i = 0; i < set.size(); ++i)
  {
    if (!atCentres)
    {
      model.points.push_back({set.points[i] + cornerOf(frame.anchorSite, frame.spacing_m), set.labels[i],
                              set.weights[i],
                              set.covariances.empty() ? Eigen::Matrix3d::Zero() : set.covariances[i]});
      continue;
    }
    const Eigen::Vector3d local = (set.points[i] - frame.cellOrigin_m) / frame.resolution_m;
    const CellIndex cell{
        anchor.x + static_cast<int32_t>(std::floor(local.x())),
        anchor.y + static_cast<int32_t>(std::floor(local.y())),
        structure_.planar ? anchor.z : anchor.z + static_cast<int32_t>(std::floor(local.z()))};
    PointWeights& weights = model.cells[cell];
    (set.labels[i] > 0.5f ? weights.hits : weights.frees) += set.weights[i];
  }
  model.lastInference = inference;
  model.lastThreads = threads;
  model.stale = true;
}

std::vector<HilbertState::CellPoints> HilbertMap::sortedCells() const
{
  std::vector<HilbertState::CellPoints> cells;
  cells.reserve(model_->cells.size());
  for (const auto& [cell, weights] : model_->cells) cells.push_back({cell, weights.hits, weights.frees});
  std::sort(cells.begin(), cells.end(),
            [](const auto& a, const auto& b) {
              return std::make_tuple(a.cell.z, a.cell.y, a.cell.x) <
                     std::make_tuple(b.cell.z, b.cell.y, b.cell.x);
            });
  return cells;
}

HilbertTrainingSet HilbertMap::keptPoints(HilbertFrame& frame) const
{
  const Model& model = *model_;
  const std::vector<HilbertState::CellPoints> cells = sortedCells();
  frame = cells.empty() ? *HilbertFrame::inMap(model.points.front().place, structure_.resolution,
                                               structure_.latticeSpacing, structure_.planarLayer())
                        : *HilbertFrame::atCell(cells.front().cell, structure_.resolution,
                                                structure_.latticeSpacing, structure_.planar);
  HilbertTrainingSet set;
  const CellIndex& anchor = frame.cells.anchor();
  for (const HilbertState::CellPoints& kept : cells)
  {
    const Eigen::Vector3d centre = frame.position({static_cast<double>(kept.cell.x) - anchor.x + 0.5,
                                                   static_cast<double>(kept.cell.y) - anchor.y + 0.5,
                                                   static_cast<double>(kept.cell.z) - anchor.z + 0.5});
    if (kept.hits > 0) set.add(centre, true, static_cast<double>(kept.hits));
    if (kept.frees > 0) set.add(centre, false, static_cast<double>(kept.frees));
  }
  if (model.points.empty()) return set;
  bool anyCovariance = false;
  for (const HilbertState::Point& point : model.points)
  {
    set.add(point.place - cornerOf(frame.anchorSite, frame.spacing_m), point.label > 0.5f,
            static_cast<double>(point.weight));
    anyCovariance = anyCovariance || !point.covariance.isZero(0);
  }
  if (!anyCovariance) return set;
  set.covariances.assign(set.size() - model.points.size(), Eigen::Matrix3d::Zero());
  for (const HilbertState::Point& point : model.points) set.covariances.push_back(point.covariance);
  return set;
}

void HilbertMap::trainBatch(unsigned threads) const
{
  Model& model = *model_;
  model.lattice.clear();
  model.nystroem = {};
  model.sgdSteps = 0;
  HilbertFrame frame =
      HilbertFrame::ofModel(structure_.resolution, structure_.latticeSpacing, structure_.planar);
  HilbertTrainingSet set = keptPoints(frame);
  Workspace work;  // for all points: too much to keep
  if (structure_.features == HilbertFeatures::Compact)
    learnOnLattice(set, frame, model.lastInference, threads, work);
  else
    learnOnNystroem(set, frame, model.lastInference, threads, work);
}

bool HilbertMap::isStale() const
{
  return model_->stale.load(std::memory_order_acquire);
}

void HilbertMap::train(unsigned threads) const
{
  if (!isStale()) return;
  const std::lock_guard<std::mutex> lock(model_->training);
  if (!isStale()) return;
  trainBatch(threads);
  model_->stale.store(false, std::memory_order_release);
}

const HilbertMap::Model& HilbertMap::trained() const
{
  train(model_->lastThreads);
  return *model_;
}

void HilbertMap::clear()
{
  model_ = std::make_unique<Model>();
}

bool HilbertMap::empty() const
{
  return model_->lattice.blockCount() == 0 && trainingPointCount() == 0;
}

// ---- Questions

std::optional<std::pair<CellIndex, Eigen::Vector3d>> HilbertMap::placeOf(
    const Eigen::Vector3d& point_map) const
{
  std::array<int32_t, 3> site{};
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  for (int axis = 0; axis < (structure_.planar ? 2 : 3); ++axis)
  {
    constexpr double kLastSite = 1 << 30;
    const double number = std::floor(point_map[axis] / structure_.latticeSpacing);
    if (!(std::abs(number) < kLastSite)) return std::nullopt;
    site[static_cast<size_t>(axis)] = static_cast<int32_t>(number);
    place[axis] = point_map[axis] - number * structure_.latticeSpacing;
  }
  return std::make_pair(CellIndex{site[0], site[1], site[2]}, place);
}

bool HilbertMap::nystroemReaches(const CellIndex& site) const
{
  const HilbertLattice<SitePosterior>& lattice = model_->lattice;
  const int reach = reachOfSites();
  const int reachZ = structure_.planar ? 0 : reach;
  for (int32_t z = site.z - reachZ; z <= site.z + reachZ; ++z)
    for (int32_t y = site.y - reach; y <= site.y + reach; ++y)
      for (int32_t x = site.x - reach; x <= site.x + reach;)
      {
        // A row of a block is a byte of its bits.
        const CellIndex first{x, y, z};
        const auto* block = lattice.find(SiteSet::blockOf(first));
        const int inBlock = x & (kEdge - 1);
        const int count = std::min(kEdge - inBlock, site.x + reach - x + 1);
        x += count;
        if (block == nullptr) continue;
        const uint32_t offset = SiteSet::offsetOf(first);
        const uint64_t run = block->bits[offset / 64] >> (offset % 64) & ((uint64_t{1} << count) - 1);
        if (run != 0) return true;
      }
  return false;
}

int HilbertMap::reachOfSites() const
{
  return static_cast<int>(std::floor(kernel_.support_m() / structure_.latticeSpacing + 0.5));
}

ReachedLogodds HilbertMap::answerAt(const CellIndex& anchorSite, const Eigen::Vector3d& place) const
{
  if (structure_.features == HilbertFeatures::Compact)
    return compactLogoddsAt(model_->lattice, kernel_, structure_.latticeSpacing, structure_.planar,
                            anchorSite, place);
  ReachedLogodds result;
  const auto siteAlong = [&](double coordinate, int32_t anchor)
  { return anchor + AxisReaches::siteOf(coordinate, structure_.latticeSpacing); };
  const CellIndex site{siteAlong(place.x(), anchorSite.x), siteAlong(place.y(), anchorSite.y),
                       structure_.planar ? 0 : siteAlong(place.z(), anchorSite.z)};
  if (model_->classifier.empty() || !nystroemReaches(site)) return result;
  result.reached = true;
  result.logodds =
      static_cast<float>(model_->nystroem.logoddsAt(model_->folded, nystroemPlace(anchorSite, place)));
  return result;
}

Eigen::Vector3d HilbertMap::nystroemPlace(const CellIndex& anchorSite, const Eigen::Vector3d& place) const
{
  Eigen::Vector3d point = place + cornerOf(anchorSite, structure_.latticeSpacing);
  if (structure_.planar) point.z() = 0.5 * structure_.latticeSpacing;
  return point;
}

std::optional<double> HilbertMap::logoddsAt(const Eigen::Vector3d& point_map) const
{
  (void)trained();
  const auto place = placeOf(point_map);
  if (!place) return std::nullopt;
  const ReachedLogodds answer = answerAt(place->first, place->second);
  return answer.reached ? std::optional<double>(answer.logodds) : std::nullopt;
}

std::optional<double> HilbertMap::logoddsAt(const Eigen::Vector3d& point_map,
                                            const Eigen::Matrix3d& covariance) const
{
  const Model& model = trained();
  const auto place = placeOf(point_map);
  if (!place) return std::nullopt;
  Eigen::Matrix3d inMap = covariance;
  if (structure_.planar)
  {
    inMap.row(2).setZero();
    inMap.col(2).setZero();
  }
  if (structure_.features == HilbertFeatures::Compact)
  {
    CompactQuery query(model.lattice, kernel_, structure_.latticeSpacing, structure_.planar);
    const ReachedLogodds answer = query.at(place->first, place->second, inMap);
    return answer.reached ? std::optional<double>(answer.logodds) : std::nullopt;
  }
  if (!answerAt(place->first, place->second).reached) return std::nullopt;
  return model.nystroem.logoddsAt(model.folded, nystroemPlace(place->first, place->second), inMap);
}

std::optional<double> HilbertMap::logoddsOf(const CellIndex& cell) const
{
  (void)trained();
  if (structure_.planar && cell.z != *structure_.planarLayer()) return std::nullopt;
  const auto frame =
      HilbertFrame::atCell(cell, structure_.resolution, structure_.latticeSpacing, structure_.planar);
  if (!frame) return std::nullopt;
  const ReachedLogodds answer = answerAt(frame->anchorSite, frame->position({0.5, 0.5, 0.5}));
  return answer.reached ? std::optional<double>(answer.logodds) : std::nullopt;
}

void HilbertMap::logoddsAt(const std::vector<Eigen::Vector3d>& points_map,
                           std::vector<ReachedLogodds>& out) const
{
  (void)trained();
  out.assign(points_map.size(), {});
  for (size_t i = 0; i < points_map.size(); ++i)
    if (const auto place = placeOf(points_map[i])) out[i] = answerAt(place->first, place->second);
}

void HilbertMap::logoddsOf(const CellIndex& first, const std::array<int, 3>& counts,
                           std::vector<ReachedLogodds>& out) const
{
  const Model& model = trained();
  const auto frame =
      HilbertFrame::atCell(first, structure_.resolution, structure_.latticeSpacing, structure_.planar);
  const RegularPoints points{frame ? frame->position({0.5, 0.5, 0.5}) : Eigen::Vector3d::Zero(),
                             structure_.resolution, counts};
  out.assign(points.size(), {});
  if (!frame || (structure_.planar && first.z != *structure_.planarLayer())) return;
  if (structure_.features == HilbertFeatures::Compact)
  {
    CompactQuery query(model.lattice, kernel_, structure_.latticeSpacing, structure_.planar);
    return query.atRegular(frame->anchorSite, points, out);
  }
  if (model.classifier.empty() || out.empty()) return;
  RegularPoints inMap = points;
  inMap.first = nystroemPlace(frame->anchorSite, points.first);
  std::vector<float> logodds;
  model.nystroem.logoddsAt(model.folded, inMap, logodds, Workers(1));
  // Cells share sites: which of them a cell is in is found an axis at a time, and each site is asked once.
  std::array<std::vector<int32_t>, 3> sites;
  for (size_t axis = 0; axis < 3; ++axis)
    for (int i = 0; i < counts[axis]; ++i)
      sites[axis].push_back(
          structure_.planar && axis == 2
              ? 0
              : AxisReaches::siteOf(points.first[static_cast<int>(axis)] + i * points.step_m,
                                    structure_.latticeSpacing));
  const CellIndex& anchor = frame->anchorSite;
  const auto countOf = [&](size_t axis)
  { return static_cast<size_t>(sites[axis].back() - sites[axis].front() + 1); };
  std::vector<std::optional<bool>> reached(countOf(0) * countOf(1) * countOf(2));
  auto* answer = out.data();
  const float* logodd = logodds.data();
  for (const int32_t z : sites[2])
    for (const int32_t y : sites[1])
      for (const int32_t x : sites[0])
      {
        std::optional<bool>& known = reached[(static_cast<size_t>(z - sites[2].front()) * countOf(1) +
                                              static_cast<size_t>(y - sites[1].front())) *
                                                 countOf(0) +
                                             static_cast<size_t>(x - sites[0].front())];
        if (!known) known = nystroemReaches({anchor.x + x, anchor.y + y, anchor.z + z});
        if (*known) *answer = {*logodd, true};
        ++answer;
        ++logodd;
      }
}

// ---- Cells

std::pair<CellIndex, CellIndex> HilbertMap::cellsNear(const CellIndex& low, const CellIndex& high) const
{
  // With a site's width more than the support, for Nyström's reach is counted in sites.
  const double reach = kernel_.support_m() + structure_.latticeSpacing;
  const auto cell = [&](int32_t site, int end, double by)
  {
    const double place = (static_cast<double>(site) + end) * structure_.latticeSpacing + by;
    constexpr double kLastCell = 2140000000.0;
    return static_cast<int32_t>(std::clamp(std::floor(place / structure_.resolution), -kLastCell, kLastCell));
  };
  const auto layer = structure_.planarLayer();
  return {{cell(low.x, 0, -reach), cell(low.y, 0, -reach), layer ? *layer : cell(low.z, 0, -reach)},
          {cell(high.x, 1, reach), cell(high.y, 1, reach), layer ? *layer : cell(high.z, 1, reach)}};
}

std::vector<BlockIndex> HilbertMap::cellBlocks() const
{
  tsl::robin_set<BlockIndex, BlockIndexHash> found;
  for (const BlockIndex& index : model_->lattice.sortedBlocks())
  {
    const SiteSet::Bits bits = model_->lattice.bitsOf(index);
    CellIndex low{kEdge, kEdge, kEdge};
    CellIndex high{-1, -1, -1};
    for (int32_t z = 0; z < kEdge; ++z)
      for (uint64_t rest = bits[static_cast<size_t>(z)]; rest != 0; rest &= rest - 1)
      {
        const int bit = __builtin_ctzll(rest);
        low = {std::min(low.x, bit % kEdge), std::min(low.y, bit / kEdge), std::min(low.z, z)};
        high = {std::max(high.x, bit % kEdge), std::max(high.y, bit / kEdge), std::max(high.z, z)};
      }
    const auto [first, last] =
        cellsNear({index.x * kEdge + low.x, index.y * kEdge + low.y, index.z * kEdge + low.z},
                  {index.x * kEdge + high.x, index.y * kEdge + high.y, index.z * kEdge + high.z});
    const int bitsZ = structure_.planar ? 0 : kBits;
    for (int32_t z = first.z >> bitsZ; z <= last.z >> bitsZ; ++z)
      for (int32_t y = first.y >> kBits; y <= last.y >> kBits; ++y)
        for (int32_t x = first.x >> kBits; x <= last.x >> kBits; ++x) found.insert({x, y, z});
  }
  std::vector<BlockIndex> blocks(found.begin(), found.end());
  std::sort(blocks.begin(), blocks.end());
  return blocks;
}

void HilbertMap::visitCells(const CellVisitor& visitor, unsigned threads) const
{
  (void)trained();
  const std::vector<BlockIndex> blocks = cellBlocks();
  const Workers workers(threads);
  const std::array<int, 3> counts{kEdge, kEdge, structure_.planar ? 1 : kEdge};
  const auto firstOf = [&](const BlockIndex& block) {
    return CellIndex{block.x * kEdge, block.y * kEdge, structure_.planar ? block.z : block.z * kEdge};
  };
  // So many blocks at a time, to be visited in their order.
  constexpr size_t kBatch = 256;
  std::vector<std::vector<ReachedLogodds>> answers(std::min(kBatch, blocks.size()));
  for (size_t begin = 0; begin < blocks.size(); begin += kBatch)
  {
    const size_t count = std::min(kBatch, blocks.size() - begin);
    workers.forEach(count, [&](size_t i) { logoddsOf(firstOf(blocks[begin + i]), counts, answers[i]); });
    for (size_t block = 0; block < count; ++block)
    {
      const CellIndex first = firstOf(blocks[begin + block]);
      size_t i = 0;
      for (int z = 0; z < counts[2]; ++z)
        for (int y = 0; y < counts[1]; ++y)
          for (int x = 0; x < counts[0]; ++x, ++i)
          {
            const ReachedLogodds& answer = answers[block][i];
            if (answer.reached)
              visitor({first.x + x, first.y + y, first.z + z}, static_cast<double>(answer.logodds));
          }
    }
  }
}

std::optional<std::pair<CellIndex, CellIndex>> HilbertMap::cellBounds() const
{
  const std::vector<BlockIndex> blocks = trained().lattice.sortedBlocks();
  if (blocks.empty()) return std::nullopt;
  BlockIndex low = blocks.front();
  BlockIndex high = low;
  for (const BlockIndex& block : blocks)
  {
    low = {std::min(low.x, block.x), std::min(low.y, block.y), std::min(low.z, block.z)};
    high = {std::max(high.x, block.x), std::max(high.y, block.y), std::max(high.z, block.z)};
  }
  constexpr int32_t kLast = kEdge - 1;
  return cellsNear({low.x * kEdge, low.y * kEdge, low.z * kEdge},
                   {high.x * kEdge + kLast, high.y * kEdge + kLast, high.z * kEdge + kLast});
}

// ---- What was learned

size_t HilbertMap::weightCount() const
{
  const Model& model = trained();
  if (structure_.features == HilbertFeatures::Compact) return model.lattice.siteCount();
  return model.nystroem.components();
}

size_t HilbertMap::trainingPointCount() const
{
  size_t count = model_->points.size();
  for (const auto& [cell, weights] : model_->cells) count += (weights.hits > 0) + (weights.frees > 0);
  return count;
}

size_t HilbertMap::memoryBytes() const
{
  const Model& model = *model_;
  return model.lattice.memoryBytes() + model.nystroem.memoryBytes() +
         model.classifier.capacity() * sizeof(float) +
         model.cells.bucket_count() * (sizeof(std::pair<CellIndex, PointWeights>) + 8) +
         model.points.capacity() * sizeof(HilbertState::Point);
}

const HilbertLattice<SitePosterior>& HilbertMap::lattice() const
{
  return trained().lattice;
}

HilbertState HilbertMap::state() const
{
  const Model& model = trained();
  HilbertState state;
  for (const BlockIndex& index : model.lattice.sortedBlocks())
  {
    const auto* block = model.lattice.find(index);
    state.blocks.push_back({index, block->bits, block->weights});
  }
  state.sgdSteps = model.sgdSteps;
  state.inducing = model.nystroem.inducing();
  if (!state.inducing.empty())
    state.classifier.assign(model.classifier.begin(),
                            model.classifier.begin() + static_cast<long>(state.inducing.size()) + 1);
  state.cells = sortedCells();
  state.points = model.points;
  return state;
}

void HilbertMap::restore(const HilbertState& state)
{
  auto model = std::make_unique<Model>();
  restoreLattice(state, model->lattice);
  const auto require = [](bool legal, const char* what)
  {
    if (!legal) throw std::invalid_argument(std::string("state of a Hilbert map: ") + what);
  };
  const bool nystroem = structure_.features == HilbertFeatures::Nystroem;
  require(nystroem || state.inducing.empty(), "inducing points, though its features are compact");
  require(state.classifier.size() == (state.inducing.empty() ? 0 : state.inducing.size() + 1),
          "not one weight for each inducing point and one for the bias");
  require(state.inducing.size() <= structure_.components, "more inducing points than components");
  require(
      std::all_of(state.inducing.begin(), state.inducing.end(), [](const auto& p) { return p.allFinite(); }),
      "an inducing point is not finite");
  require(
      std::all_of(state.classifier.begin(), state.classifier.end(), [](float w) { return std::isfinite(w); }),
      "a weight is not finite");
  if (!state.inducing.empty())
  {
    model->nystroem = NystroemFeatures(state.inducing, kernel_.gamma());
    model->classifier = state.classifier;
    model->classifier.resize(model->nystroem.weightCount(), 0.0f);
    model->folded = model->nystroem.fold(model->classifier);
  }
  model->sgdSteps = state.sgdSteps;
  require(structure_.training == HilbertTraining::Batch || (state.cells.empty() && state.points.empty()),
          "training points, though its training is not `batch`");
  const auto isWeight = [](float weight) { return weight >= 0 && std::isfinite(weight); };
  for (const HilbertState::CellPoints& kept : state.cells)
  {
    require(isWeight(kept.hits) && isWeight(kept.frees), "the weight of a cell is not legal");
    require(
        HilbertFrame::atCell(kept.cell, structure_.resolution, structure_.latticeSpacing, structure_.planar)
            .has_value(),
        "a cell beyond what can be addressed");
    require(model->cells.emplace(kept.cell, PointWeights{kept.hits, kept.frees}).second, "a cell twice");
  }
  for (const HilbertState::Point& point : state.points)
  {
    require(point.place.allFinite() && point.covariance.allFinite() && isWeight(point.weight) &&
                (point.label == 0.0f || point.label == 1.0f),
            "a training point is not legal");
    require(HilbertFrame::inMap(point.place, structure_.resolution, structure_.latticeSpacing,
                                structure_.planarLayer())
                .has_value(),
            "a training point beyond what can be addressed");
    model->points.push_back(point);
  }
  model_ = std::move(model);
}

void HilbertMap::restoreLattice(const HilbertState& state, HilbertLattice<SitePosterior>& lattice) const
{
  const auto require = [](bool legal, const char* what)
  {
    if (!legal) throw std::invalid_argument(std::string("state of a Hilbert map: ") + what);
  };
  const BlockIndex* last = nullptr;
  for (const HilbertState::Block& block : state.blocks)
  {
    constexpr int32_t kLastBlock = 1 << (30 - kBits);
    const auto fits = [](int32_t i) { return i >= -kLastBlock && i <= kLastBlock; };
    require(fits(block.index.x) && fits(block.index.y) && fits(block.index.z), "a block is out of range");
    require(!structure_.planar || block.index.z == 0, "a block beside the plane");
    require(last == nullptr || *last < block.index, "blocks are not in their order");
    last = &block.index;
    size_t count = 0;
    for (const uint64_t word : block.bits) count += static_cast<size_t>(__builtin_popcountll(word));
    require(count > 0 && count == block.weights.size(), "a block has not one weight for each of its sites");
    for (const SitePosterior& weight : block.weights)
      require(std::isfinite(weight.mean) && weight.precision >= 0 && std::isfinite(weight.precision),
              "a weight is not finite, or its precision negative");
    lattice.put(block.index, {block.bits, block.weights});
  }
}

namespace
{
CellEstimate estimateOf(double logodds, const StateThresholds& thresholds)
{
  CellEstimate cell;
  cell.prob = logistic(logodds);
  cell.state = stateOf(cell.prob, thresholds);
  cell.evidence = {logodds, 0};
  return cell;
}
}  // namespace

std::optional<CellEstimate> HilbertMap::at(const Eigen::Vector3d& point_map,
                                           const StateThresholds& thresholds) const
{
  const auto logodds = logoddsAt(point_map);
  if (!logodds) return std::nullopt;
  return estimateOf(*logodds, thresholds);
}

std::optional<CellEstimate> HilbertMap::cell(const CellIndex& cell, const StateThresholds& thresholds) const
{
  const auto logodds = logoddsOf(cell);
  if (!logodds) return std::nullopt;
  return estimateOf(*logodds, thresholds);
}

void HilbertMap::visitCells(const StateThresholds& thresholds, const EstimateVisitor& visitor,
                            unsigned threads) const
{
  visitCells([&](const CellIndex& cell, double logodds) { visitor(cell, estimateOf(logodds, thresholds)); },
             threads);
}

}  // namespace lamap
